"""The tables of the thesis's questions, from the files that hold their numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from generate import table
from study_rows import LEVELS, WALKERS, Study, duration, points, rounded

from powered_walker_env.controllers import Optimal
from powered_walker_env.controllers.evaluation import task_of
from powered_walker_env.poincare import Optimum

#: From all four numbers to none: the study's controllers, and what they are called.
LADDER = {
    "lqr": "4 numbers (LQR)", "numbers-3": "3 numbers", "numbers-2": "2 numbers",
    "numbers-1": "1 number", "one-number": "1 number to 1 action",
    "trial-open-loop": "none; best constant in trials",
    "tuned-open-loop": "none; least sensitive constant", "open-loop": "none; the gait's own",
}  # fmt: skip
LISTED = ("open-loop", "trial-open-loop", "numbers-2", "lqr", "look-ahead-1", "look-ahead-3",
          "apg", "cmaes", "ppo", "sac", "tqc", "crossq", "optimal")  # fmt: skip
UNSEEN = 3.69  # falls that are none in one of 40 trials: -ln 0.025


def ladder(study: Study) -> str:
    """Strides and scores of each rung at each walker, and their figure."""
    parts = ["![Strides against measured numbers](../generated/ladder.png)\n"]
    for level in LEVELS:
        rows = []
        for name, label in {**LADDER, "optimal": "the optimum, or the best known"}.items():
            cells = [rung(study, env_id, level, name) for env_id in WALKERS]
            rows.append((label, f"`{name}`", *cells))
        header = ("measured", "controller", *WALKERS.values())
        parts.append(f"Pushes `{level}`, strides of 100 and score:\n\n{table(header, rows)}")
    return "\n".join(parts)


def rung(study: Study, env_id: str, level: str, name: str) -> str:
    """Strides and score."""
    strides = study.text(env_id, level, name, "strides")
    return f"{strides}, {study.text(env_id, level, name, 'score', '.2f')}"


def pairs(found: dict[str, Any]) -> str:
    """The 4x2 tables, and the best of each count of numbers."""
    parts = []
    for env_id, answer in found.items():
        actions = list(dict.fromkeys(row["action"] for row in answer["pairs"]))
        names = list(dict.fromkeys(row["number"] for row in answer["pairs"]))
        known = {(row["number"], row["action"]): row["strides"] for row in answer["pairs"]}
        both = {tuple(row["numbers"]): row["strides"] for row in answer["subsets"]}
        rows = [(said(name), *(f"{known[name, action]:.1f}" for action in actions),
                 f"{both[(name,)]:.1f}") for name in names]  # fmt: skip
        header = (WALKERS[env_id], *(f"to the {said(action)}" for action in actions), "to both")
        best = ", ".join(
            f"{' and '.join(map(said, row['numbers']))} {row['strides']:.1f}"
            for row in best_subsets(answer["subsets"])
        )
        parts.append(f"{table(header, rows)}\nThe best two and three: {best}; "
                     f"none of them: {both[()]:.1f}.\n")  # fmt: skip
    return "\n".join(parts)


def best_subsets(subsets: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """The two numbers, and the three, that walk longest."""
    for count in (2, 3):
        some = [row for row in subsets if len(row["numbers"]) == count]
        yield max(some, key=lambda row: row["strides"])


def deadbeat(found: dict[str, Any]) -> str:
    """In how many strides, and for which share of the pushes."""
    rows = []
    for env_id, answer in found.items():
        back = answer["deadbeat"]
        shares = [percent(share) for share in back["pushes_undone_within_bounds"].values()]
        within = percent(back["feedback_within_bounds"])
        rows.append((WALKERS[env_id], back["strides"], within, ", ".join(shares)))
    header = ("walker", "strides to the gait", "pushes for which its actions are within bounds",
              "pushes that some actions undo within bounds, in 2, 3, 4 strides")  # fmt: skip
    return table(header, rows)


def percent(share: float) -> str:
    """Whole ones."""
    return f"{100 * share:.0f} %"


def optima() -> str:
    """What is known of each optimum: of the tables that come with the package."""
    rows = []
    for env_id, level in ((each, level) for level in LEVELS for each in WALKERS):
        found = known_optimum(env_id, level)
        if found is None:
            rows.append((WALKERS[env_id], level, "–", "–", "no table"))
            continue
        rows.append((WALKERS[env_id], level, f"{found.value:.1f} ± {found.error:.1f}",
                     f"{found.walked[0]:.1f} ± {3 * found.walked[1]:.1f}",
                     "resolved" if found.resolved else "the best known"))  # fmt: skip
    header = ("walker", "pushes", "greatest return, by the table", "its policy walks", "optimum")
    return table(header, rows)


def known_optimum(env_id: str, level: str) -> Optimum | None:
    """The optimum that comes with the package; None without one."""
    try:
        return Optimal(task_of(env_id, disturbance=level)).found
    except ValueError:
        return None


def scores(study: Study) -> str:
    """Score of each controller at each walker."""
    parts = []
    for level in LEVELS:
        names = [name for name in LISTED if any((each, level, name) in study.rows
                                                for each in WALKERS)]  # fmt: skip
        rows = [(f"`{name}`", *(score(study, each, level, name) for each in WALKERS))
                for name in names]  # fmt: skip
        parts.append(f"Pushes `{level}`:\n\n{table(('controller', *WALKERS.values()), rows)}")
    return "\n".join(parts)


def score(study: Study, env_id: str, level: str, controller: str) -> str:
    """With its interval."""
    found = (study.rows.get((env_id, level, controller)) or {}).get("score")
    return "–" if found is None else f"{found[0]:.2f} [{found[1]:.2f}, {found[2]:.2f}]"


def kernels(found: dict[str, Any]) -> str:
    """Shares of the box that can be saved, and of these what each controller keeps."""
    names = {"open-loop": "open loop", "lqr": "LQR", "ppo": "PPO",
             "optimal": "the optimum, or the best known"}  # fmt: skip
    rows = [
        (WALKERS[env_id], between(answer["kernel"]),
         *(between(answer["of_kernel"].get(name)) for name in names), answer["starts"],
         answer["refuted"])
        for env_id, answer in found.items()
    ]  # fmt: skip
    header = ("walker", "kernel, of the box", *names.values(), "starts", "called lost, yet kept")
    return table(header, rows)


def between(bounds: Sequence[float] | None) -> str:
    """Two shares as percent."""
    if bounds is None:
        return "–"
    low, high = (f"{100 * share:.0f}" for share in bounds)
    return f"{low} %" if low == high else f"{low} to {high} %"


def lasting(study: Study) -> str:
    """Largest multiplier and mean first passage time of each controller, light pushes."""
    rows = []
    for name in LISTED:
        cells = []
        for env_id in WALKERS:
            time = duration(study, env_id, "light", name)
            cells.append(f"{study.text(env_id, 'light', name, 'spectral_radius', '.2f')}, {time}")
        rows.append((f"`{name}`", *cells))
    return table(("multiplier, strides", *WALKERS.values()), rows)


def fronts(study: Study) -> str:
    """The controllers that no other beats at less cost, for each walker."""
    parts = ["![Mean first passage time against operations](../generated/cost.png)\n"]
    rows = []
    for env_id in WALKERS:
        best = 0.0
        for flops, time, name in sorted(
            points(study, env_id), key=lambda each: (each[0], -each[1])
        ):
            if time > best:
                rows.append((WALKERS[env_id], f"`{name}`", f"{flops:,.0f}",
                             duration(study, env_id, "light", name)))  # fmt: skip
                best = time
    header = ("walker", "on the front", "operations a stride", "mean first passage, strides")
    return "\n".join([*parts, table(header, rows)])


def bodies(found: dict[str, Any]) -> str:
    """The walkers as they are and as they feel pushes least, and what was changed."""
    rows, changes = [], []
    for env_id, answer in found.items():
        own, tuned = (answer["walked"][name] for name in ("own", "tuned"))
        norm, speed = (
            tuple(answer[what][name] for name in ("own", "tuned")) for what in ("norm", "speed")
        )
        rows.append((
            WALKERS[env_id], f"{norm[0]:.3f} → {norm[1]:.3f}",
            f"{own['strides']:.1f} → {tuned['strides']:.1f}", f"{lasted(own)} → {lasted(tuned)}",
            f"{speed[0]:.2f} → {speed[1]:.2f}", f"{answer['seconds']:.0f}",
        ))  # fmt: skip
        changed = [f"{before:.4g} → {after:.4g}" for before, after in answer["changed"].values()]
        changes.append((WALKERS[env_id], *changed))
    header = ("walker", "sensitivity norm", "strides of 100", "mean first passage, strides",
              "speed, m/s", "seconds of search")  # fmt: skip
    fields = [f"`{name}`" for name in next(iter(found.values()))["changed"]]
    return f"{table(header, rows)}\n{table(('walker', *fields), changes)}"


def lasted(walked: dict[str, Any]) -> str:
    """A mean first passage time; without falls what it is at least."""
    if walked["falls"]:
        return rounded(walked["mean_first_passage"])
    return f"> {rounded(walked['walked'] / UNSEEN)}"


def said(name: str) -> str:
    """A field's name in words."""
    return name.replace("_", " ")
