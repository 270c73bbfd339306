"""What pages include and the package knows: films, facts of environments, tables, lists."""

from __future__ import annotations

import importlib
import inspect
import itertools
import re
import textwrap
from pathlib import Path

from study_pages import baselines, questions, study
from tabulated import table

from powered_walker_env import (
    ENVIRONMENTS,
    PRESETS,
    PoweredWalkerEnv,
    find_gait,
    walk,
)
from powered_walker_env.envs.description import describe
from powered_walker_env.envs.levels import LEVELS, SIZES
from powered_walker_env.envs.registration import MAX_EPISODE_STEPS
from powered_walker_env.literature import Kind, Row, validate
from powered_walker_env.model.powering import SCHEMES, scheme_of
from powered_walker_env.model.presets import Preset
from powered_walker_env.model.quantities import quantities
from powered_walker_env.pictures.film import save_animation

STRIDES = 3  # of a film
#: Rooms in the order of the architecture, and what one finds there.
ROOMS = {
    "model": "The walker, its state, presets, outcomes",
    "model.powering": "Ways to power it, controls, policies",
    "simulation": "Strides, their derivatives, walks",
    "poincare": "The gait laboratory",
    "results": "Results on disk",
    "envs": "Environments",
    "controllers": "Controllers and their evaluation",
    "sb3": "Stable-Baselines3",
    "torch": "Gradients in torch",
    "pictures.charts": "Figures",
    "pictures.film": "Films",
    "pictures.renderer": "Pictures",
    "literature": "Published values",
}
#: Public names of rooms that do not list theirs.
NAMES = {
    "results": ["load_result", "result_info", "save_result", "versions"],
    "sb3": ["PoweredWalkerVecEnv"],
    "torch": ["Strides", "differentiable_strides"],
    "pictures.film": ["save_animation", "save_frames", "save_side_by_side"],
    "pictures.renderer": ["Renderer"],
}
PACKAGE = "powered_walker_env"
PUBLISHED = ("quantity", "published", "here", "difference", "")


def everything(generated: Path, reference: Path) -> None:
    """Write it all; files that are as they should be are not touched."""
    generated.mkdir(exist_ok=True)
    benchmark = generated.parent / "benchmark"
    for env_id, (preset, threshold) in ENVIRONMENTS.items():
        film(generated / f"{env_id}.gif", preset)
        write(generated / f"{env_id}.md", environment(env_id, preset, threshold))
        write(generated / f"{env_id}-baselines.md", baselines(env_id, benchmark))
    write(generated / "contract.md", textwrap.dedent(describe()))
    write(generated / "presets.md", presets())
    write(generated / "schemes.md", schemes())
    write(generated / "published.md", published())
    write(generated / "study.md", study(benchmark))
    for name, text in questions(generated.parent / "questions").items():
        write(generated / f"questions-{name}.md", text)
    for room, title in ROOMS.items():
        write(reference / f"{room}.md", reference_page(room, title))
    write(generated / "daily.md", daily())
    pages = {f"{home(room, name)}.rst" for name, room in documented_in().items()}
    for left in (reference / "api").glob("*.rst"):
        if left.name not in pages:
            left.unlink()  # of a name that is gone


def write(path: Path, text: str) -> None:
    """Write a text unless it is there already: Sphinx reads anew what is newer."""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def film(path: Path, preset: str) -> None:
    """A film of the preset's gait."""
    if not path.is_file():
        params, control, state, _ = PRESETS[preset]
        save_animation(walk(state, control, params, STRIDES), path, width=560, height=300)


def source_of(preset: Preset) -> str:
    """Where a walker comes from, without where its gait does."""
    return re.split(r"; (?:long )?gait found", preset.source)[0]


def environment(env_id: str, preset: str, threshold: float) -> str:
    """The facts of one environment."""
    task = PoweredWalkerEnv(preset=preset).task
    gait = find_gait(task.params, task.control, task.gait[0].tolist())
    numbers = quantities(task.control).values()
    actions = [
        (f"{k}", f"{each.label} {each.symbol}", f"{getattr(task.control, each.name):g} {each.unit}",
         f"±{reach:g} {each.unit}")
        for k, (each, reach) in enumerate(zip(numbers, task.half_range.tolist(), strict=True))
    ]  # fmt: skip
    units = ("rad", "rad", "rad/s", "rad/s")
    observed = [
        (f"{k}", name.replace("_", " "), f"{value:.6f} {unit}", f"{scale:g} {unit}")
        for k, (name, value, scale, unit) in enumerate(
            zip(gait.state._fields, gait.state, task.scale.tolist(), units, strict=True)
        )
    ]
    source = source_of(PRESETS[preset])
    facts = [
        ("Make it", f"`gym.make(\"{PACKAGE}:{env_id}\")`"),
        ("Walker", f"preset `{preset}`: {source}"),
        ("Physics", f"`{task.params.physics}`"),
        ("Powered by", f"`{task.scheme.name}`"),
        ("Action", "`Box(-1, 1, (2,), float32)`"),
        ("Observation", "`Box(-20, 20, (4,), float32)`"),
        ("Episode", f"{MAX_EPISODE_STEPS} strides, or a fall"),
        ("Disturbed by default", f"pushes of {task.disturbance.push:g} rad/s (`\"light\"`)"),
        ("Solved at return", f"{threshold:g}"),
        ("Gait", f"spectral radius {gait.spectral_radius:.4f}, {gait.step_length:.4f} m in "
         f"{gait.duration:.4f} s, cost of transport {gait.cost_of_transport:.4f}"),
    ]  # fmt: skip
    sizes = [
        (f"`{kind}`", *(f"{size:g}" for size in levels)) for kind, levels in SIZES[preset].items()
    ]
    return "\n".join(
        [
            table(("", ""), facts),
            "## Action\n",
            table(("", "number", "at 0", "at ±1"), actions),
            "## Observation\n",
            "Minus the gait's state, over the scale:\n",
            table(("", "number", "gait", "scale"), observed),
            "## Disturbances\n",
            "Standard deviations (`disturbance=\"rough\"`, `\"light-ground\"`, …):\n",
            table(("kind", *LEVELS[1:]), sizes),
        ]
    )  # fmt: skip


def presets() -> str:
    """All walkers with known gaits."""
    rows = []
    for name, preset in PRESETS.items():
        gait = find_gait(*preset[:3])
        rows.append((f"`{name}`", f"`{scheme_of(preset.control).name}`",
                     f"{preset.params.slope:.4g}", f"{gait.spectral_radius:.4f}",
                     f"{gait.speed:.4g}", source_of(preset)))  # fmt: skip
    header = ("preset", "powered by", "slope, rad", "spectral radius", "speed, m/s", "source")
    return table(header, rows)


def schemes() -> str:
    """All ways to power a walker, with their numbers and phases."""
    rows = []
    for name, scheme in SCHEMES.items():
        known = quantities(scheme.control).values() if scheme.control else ()
        numbers = ", ".join(f"{each.label} {each.symbol} ({each.unit})" for each in known) or "none"
        kind = scheme.control.__name__ if scheme.control else "None"
        rows.append((f"`{name}`", f"`{kind}`", numbers,
                     ", ".join(phase.name for phase in scheme.cycle)))  # fmt: skip
    return table(("scheme", "control", "its numbers", "phases of a stride"), rows)


def published() -> str:
    """Every published value beside ours, by kind of origin, walker and source."""
    order = list(Kind)
    rows = sorted(validate(), key=lambda row: order.index(row.kind))
    text = []
    for kind, group in itertools.groupby(rows, lambda row: row.kind):
        of_kind = list(group)
        agree = sum(row.agrees for row in of_kind)
        text += [f"## {kind[0].upper()}{kind[1:]}\n", f"{agree} of {len(of_kind)} agree.\n"]
        for walker, of_walker in itertools.groupby(of_kind, lambda row: row.walker):
            text.append(f"### {walker}\n")
            for source, lines in itertools.groupby(of_walker, lambda row: row.source):
                text += [f"{source}\n", table(PUBLISHED, map(published_row, lines))]
    return "\n".join(text)


def published_row(row: Row) -> tuple[str, ...]:
    """One line of the table."""
    verdict = row.verdict + (f": {row.differs}" if row.differs else "")
    numbers = (f"`{row.published}`", f"`{row.ours}`", f"{row.difference:.1e}")
    return row.quantity, *numbers, verdict


def public_names(room: str) -> list[str]:
    """Of a room."""
    module = importlib.import_module(f"{PACKAGE}.{room}")
    return sorted(NAMES.get(room) or module.__all__, key=str.lower)


def home(room: str, name: str) -> str:
    """The full name under which a page documents it: constants where their comment stands."""
    module = importlib.import_module(f"{PACKAGE}.{room}")
    if callable(getattr(module, name)):
        return f"{module.__name__}.{name}"
    root = Path(inspect.getfile(module))
    files = sorted(root.parent.rglob("*.py")) if root.name == "__init__.py" else [root]
    for file in files:
        if re.search(rf"^(\w+, )*{name}\b.*=", file.read_text(encoding="utf-8"), re.MULTILINE):
            parts = file.relative_to(root.parent).with_suffix("").parts
            inside = [part for part in parts if part != "__init__"] if len(files) > 1 else []
            return ".".join([module.__name__, *inside, name])
    return f"{module.__name__}.{name}"


def documented_in() -> dict[str, str]:
    """Public name to the room that documents it: the first that has it."""
    rooms: dict[str, str] = {}
    for room in ROOMS:
        for name in public_names(room):
            rooms.setdefault(name, room)
    return rooms


def reference_page(room: str, title: str) -> str:
    """The list of a room's names, each with a page of its own."""
    rooms = documented_in()
    names = [home(room, name) for name in public_names(room) if rooms[name] == room]
    listed = "\n".join(f"   {name}" for name in names)
    return (
        f"# {title}\n\n`{PACKAGE}.{room}`\n\n```{{eval-rst}}\n.. autosummary::\n"
        f"   :toctree: api\n   :nosignatures:\n\n{listed}\n```\n"
    )


def daily() -> str:
    """What one types in a day: the names that the package itself exports."""
    package, rooms = importlib.import_module(PACKAGE), documented_in()
    names = sorted((name for name in package.__all__ if name in rooms), key=str.lower)
    return "".join(f"- {{py:obj}}`{home(rooms[name], name)}`\n" for name in names)
