"""Docstrings as they are written in this project, made ready for Sphinx (before napoleon).

Fields of dataclasses and named tuples are explained by the comment beside them; environments have
their docstring in Markdown, as Gymnasium has it, and a page of their own for it.
"""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any

WHERE = ["Spaces, rewards, disturbances and arguments: :doc:`/environments/contract`.", ""]
FIELD = re.compile(r"    (\w+): [^#]*?(?:  # (.*))?$")
INLINE = ("attribute", "data", "property")
_KEPT: dict[str, list[str]] = {}
MORE = re.compile(r"    # (.*)$")


def prepare(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Change the lines of a docstring in place."""
    headings = [k for k, line in enumerate(lines) if line.startswith("## ")]
    if headings:
        lines[headings[0] :] = WHERE
    if what in INLINE:
        _KEPT[name] = list(lines)
    if what == "class" and isinstance(obj, type):
        listed = [f"    {field}: {words}" for field, words in commented_fields(obj)]
        if listed:
            lines += ["", "Attributes:", *listed, ""]


def restore(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Undo what napoleon did to an attribute: it takes words before a colon for a type."""
    if what in INLINE:
        lines[:] = [*_KEPT.pop(name), ""]


def commented_fields(cls: type) -> Iterator[tuple[str, str]]:
    """Fields of a record with the comments beside and below them."""
    record = dataclasses.is_dataclass(cls) or hasattr(cls, "_fields")
    if not record:
        return
    names = set(getattr(cls, "_fields", ())) or {
        field.name for field in dataclasses.fields(cls) if "domain" not in field.metadata
    }
    found: dict[str, list[str]] = {}
    current = ""
    for line in inspect.getsource(cls).splitlines():
        if (field := FIELD.match(line)) and field[1] in names:
            current = field[1]
            found[current] = [field[2] or ""]
        elif (more := MORE.match(line)) and current and found[current][0]:
            found[current].append(more[1])
        else:
            current = ""
    yield from ((name, escaped(" ".join(words))) for name, words in found.items() if words[0])


def escaped(text: str) -> str:
    """A comment as reStructuredText: no signs in it mean anything, but for code."""
    return re.sub(r"([*|_])", r"\\\1", text) if "`" not in text else text
