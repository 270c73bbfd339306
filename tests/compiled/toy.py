"""A small package that stands in for the walker's: the same two modules, a formula, a kernel that
calls it, and a room that no kernel needs."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import powered_walker_env

PACKAGE = Path(powered_walker_env.__file__).parent
TOY = "toy_walker"
FORMULA = """
from toy_walker.compiled.decorators import formula

@formula
def f(x):
    return {} * x
"""
KERNEL = """
from toy_walker.compiled.decorators import slow_kernel
from toy_walker.model import formulas
from toy_walker.model.formulas import f

@slow_kernel
def run(x):
    return f(x)
"""


class Toy:
    """The small package, as a new process would import it."""

    def __init__(self, folder: Path) -> None:
        self.root = folder / TOY
        for room in ("compiled", "model", "envs"):
            (self.root / room).mkdir(parents=True)
            (self.root / room / "__init__.py").write_text("")
        (self.root / "__init__.py").write_text("")
        for name in ("cache.py", "decorators.py"):
            source = (PACKAGE / "compiled" / name).read_text(encoding="utf-8")
            copied = source.replace("from powered_walker_env", f"from {TOY}")
            (self.root / "compiled" / name).write_text(copied, encoding="utf-8")
        self.write("model/formulas.py", FORMULA.format(2.0))
        self.write("kernel.py", KERNEL)
        self.write("envs/task.py", "reward = 1.0\n")

    def write(self, name: str, text: str) -> None:
        (self.root / name).write_text(text)

    def forget(self) -> None:
        """Nothing of it has been imported."""
        for name in [name for name in sys.modules if name.split(".")[0] == TOY]:
            del sys.modules[name]
        importlib.invalidate_caches()

    def run(self) -> tuple[float, bool]:
        """What its kernel makes of 3, and whether it was loaded from the disk."""
        self.forget()
        compiled = importlib.import_module(f"{TOY}.kernel").run
        return compiled(3.0), bool(compiled.stats.cache_hits)

    def block(self) -> None:
        """No folder can be made beside the package."""
        (self.root / "__pycache__").write_text("in the way")


def files(folder: Path) -> list[Path]:
    """The cached machine code under a folder."""
    return sorted(path for path in folder.rglob("*.nb*") if path.is_file())
