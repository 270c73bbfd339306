"""The page, served on this machine and to nobody else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from powered_walker_env.explore.choice import Choice

HERE = "127.0.0.1"
PATH = "/"


def import_bokeh() -> None:
    """Find out whether there is what draws the page.

    Raises:
        ImportError: bokeh is not installed; the message says how to install it.
    """
    try:
        import bokeh.server.server  # noqa: F401
    except ImportError as error:
        raise ImportError(
            'explore needs bokeh, which is not installed; pip install "powered-walker-env[explore]"'
        ) from error


def make_server(choice: Choice, controllers: Sequence[str] = (), port: int = 0) -> Any:
    """A server of the page, not yet started; every visitor has a walker of their own.

    Args:
        choice: what walks first.
        controllers: offered besides those of the package, as `load_controller` takes them.
        port: 0 for any that is free.

    Raises:
        ImportError: bokeh is not installed.
        OSError: the port is taken.
    """
    import_bokeh()
    from bokeh.application import Application
    from bokeh.application.handlers.function import FunctionHandler
    from bokeh.server.server import Server

    from powered_walker_env.explore.page import Page

    def open_page(document: Any) -> None:
        Page(document, choice, controllers)

    pages = {PATH: Application(FunctionHandler(open_page))}
    try:
        return Server(pages, address=HERE, port=port)
    except OSError as error:
        raise OSError(f"port {port} cannot be had: {error}; choose another, or 0") from error


def serve(
    choice: Choice,
    controllers: Sequence[str] = (),
    port: int = 0,
    *,
    ready: Callable[[str], None],
) -> None:
    """Serve the page until Ctrl-C.

    Args:
        ready: called with the page's address as soon as it can be opened.

    Raises:
        ImportError, OSError: as `make_server`.
    """
    server = make_server(choice, controllers, port)
    server.start()
    try:
        server.io_loop.add_callback(ready, f"http://localhost:{server.port}{PATH}")
        server.io_loop.start()
    finally:
        server.stop()
