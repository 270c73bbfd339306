"""Docstrings in Markdown, as Gymnasium has them for environments, have a page of their own."""

from __future__ import annotations

from typing import Any

WHERE = ["Spaces, rewards, disturbances and arguments: :doc:`/environments/contract`.", ""]


def replace_markdown(
    app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]
) -> None:
    """Leave the first paragraph, and say where the rest is."""
    headings = [k for k, line in enumerate(lines) if line.startswith("## ")]
    if headings:
        lines[headings[0] :] = WHERE
