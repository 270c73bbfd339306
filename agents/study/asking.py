"""What the commands behind the question pages share: one answer for each walker, one JSON file."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from tqdm import tqdm

from agents.command import CONFIGS
from agents.runs import write_json
from powered_walker_env import ENVIRONMENTS

QUESTIONS = CONFIGS.parent / "docs" / "questions"
Answers = dict[str, dict[str, Any]]  # by the id


def parser(name: str, about: str | None) -> argparse.ArgumentParser:
    """The command line of `python -m agents.study.NAME`."""
    result = argparse.ArgumentParser(
        prog=f"python -m agents.study.{name}", description=about,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )  # fmt: skip
    result.add_argument(
        "--out", type=Path, default=QUESTIONS, help="a folder (default: docs/questions)"
    )
    result.add_argument(
        "--env", nargs="+", choices=list(ENVIRONMENTS), default=list(ENVIRONMENTS), metavar="ID",
        help="of these only; the answers of others stay (default: all)",
    )  # fmt: skip
    return result


def answered(
    out: Path, file: str, env_ids: Sequence[str], ask: Callable[[str], dict[str, Any]]
) -> Answers:
    """Ask for each walker, and write the file after each: what is done is kept.

    Raises:
        ValueError: a file of that name that holds something else.
        OSError: a folder that cannot be made.
    """
    out.mkdir(parents=True, exist_ok=True)
    path = out / file
    found = load_answers(path)
    for env_id in tqdm(env_ids, unit=" walkers", disable=None):
        answer = ask(env_id)
        found = {each: answer if each == env_id else found[each] for each in ENVIRONMENTS
                 if each in (env_id, *found)}  # fmt: skip
        write_json(path, found)
    print(path)
    return found


def load_answers(path: Path) -> Answers:
    """What a file holds; nothing if there is none.

    Raises:
        ValueError: it holds something else.
    """
    if not path.is_file():
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        content = None
    if not isinstance(content, dict) or not set(content) <= set(ENVIRONMENTS):
        raise ValueError(f"{str(path)!r} must hold answers by id, got something else; remove it")
    return content
