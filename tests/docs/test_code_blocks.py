"""Every block of Python in the README and in the pages of the site runs as it stands.

Pages with `{code-cell}` run as the site is built.
"""

from __future__ import annotations

import re
from pathlib import Path

import gymnasium as gym
import pytest

sybil = pytest.importorskip("sybil")
parsers = pytest.importorskip("sybil.parsers.markdown")

ROOT = Path(__file__).parents[2]
PYTHON = re.compile(r"^```python$", re.MULTILINE)
DOCS = ROOT / "docs"


def is_generated(page: Path) -> bool:
    """Whether it is made as the site is built, which may be now."""
    reference = DOCS / "reference"
    return DOCS / "generated" in page.parents or (
        reference in page.parents and page != reference / "index.md"
    )


WRITTEN = [
    ROOT / "README.md",
    *(page for page in sorted(DOCS.rglob("*.md")) if not is_generated(page)),
]
PAGES = [page for page in WRITTEN if PYTHON.search(page.read_text(encoding="utf-8"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_the_blocks_of_a_page_run(page: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gym.envs.registration, "registry", dict(gym.registry))
    document = sybil.Sybil(parsers=[parsers.PythonCodeBlockParser()]).parse(page)
    examples = list(document.examples())
    assert len(examples) == len(PYTHON.findall(page.read_text(encoding="utf-8")))
    for example in examples:
        example.evaluate()


def test_the_readme_has_them_and_is_short() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(PYTHON.findall(readme)) >= 2
    assert len(readme.splitlines()) <= 130
    for command in (
        'pip install -e ".[train,render]" && python -m agents.quickstart',
        'pip install -e ".[dev]" && python -m pytest -n auto',
    ):
        assert f"```sh\n{command}\n```" in readme


@pytest.mark.parametrize("page", WRITTEN, ids=lambda page: page.relative_to(ROOT).as_posix())
def test_links_between_files_lead_somewhere(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    for target in re.findall(r"\]\((?!https?:|#)([^)#\s]+)", text):
        if "generated/" not in target:  # made as the site is built
            assert (page.parent / target).exists(), target
