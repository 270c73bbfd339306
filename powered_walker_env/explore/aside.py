"""Work done aside, of which only the newest is wanted.

A slider that moves asks for the same pictures again and again; each new wish makes those
before it void, wherever they are.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any


class Outdated(Exception):  # noqa: N818 (no error: nobody wants the answer any more)
    """Something newer has been asked for."""


class Aside:
    """A thread that does the last thing it was asked for, and drops what came before.

    Args:
        deliver: called in that thread with a function that hands over an answer; it must run
            the function where answers are wanted, later (`add_next_tick_callback`, say).
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], Any], name: str = "aside") -> None:
        self._deliver = deliver
        self._wish: tuple[Callable[..., Any], Callable[[Any], None]] | None = None
        self._changed = threading.Condition()
        self._newest, self._closed = 0, False
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def ask(self, work: Callable[[Callable[[], None]], Any], take: Callable[[Any], None]) -> None:
        """Do `work(check)` aside, then `take(answer)`, unless something newer is asked for.

        `check()` raises `Outdated` as soon as that is so. An exception of the work is an answer.
        """
        with self._changed:
            self._newest += 1
            self._wish = (work, take)
            self._changed.notify()

    def forget(self) -> None:
        """Want nothing any more."""
        with self._changed:
            self._newest += 1
            self._wish = None

    def close(self) -> None:
        """End the thread, once the work it is at lets it."""
        with self._changed:
            self._newest += 1
            self._closed, self._wish = True, None
            self._changed.notify()

    def _run(self) -> None:
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or self._wish is not None)
                if self._closed or self._wish is None:
                    return
                (work, take), number, self._wish = self._wish, self._newest, None
            self._answer(work, take, number)

    def _answer(self, work: Callable[..., Any], take: Callable[[Any], None], number: int) -> None:
        """Do what was asked for as wish `number`, and have it handed over."""
        try:
            answer = work(lambda: self._check(number))
        except Outdated:
            return
        except Exception as error:
            answer = error
        if number == self._newest:
            self._deliver(lambda: self._hand_over(number, take, answer))

    def _hand_over(self, number: int, take: Callable[[Any], None], answer: Any) -> None:
        """In the thread that wants it: the wish may have changed on the way."""
        if number == self._newest:
            take(answer)

    def _check(self, number: int) -> None:
        if number != self._newest:
            raise Outdated
