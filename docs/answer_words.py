"""The answers to the thesis's questions in sentences, their numbers from the files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from answer_tables import best_subsets, between, known_optimum, said
from study_rows import LEVELS, ROUND, THESIS, WALKERS, Study, duration, points

ENOUGH = 0.95  # of the LQR's strides
RUNGS = {"trial-open-loop": "none", "numbers-1": "one", "numbers-2": "two", "numbers-3": "three",
         "lqr": "four"}  # fmt: skip


def simplest(study: Study, ladder: dict[str, Any]) -> str:
    """No number, one, two; the fewest that are as good as four."""

    def strides(name: str) -> str:
        return each_of(lambda env_id: study.text(env_id, "light", name, "strides", ".0f"))

    def radius(env_id: str) -> str:
        return study.text(env_id, "light", "open-loop", "spectral_radius", ".2f")

    fewest = [f"{label} {fewest_numbers(study, env_id)}" for env_id, label in WALKERS.items()]
    on_round_feet = ladder[ROUND]["subsets"]
    rate = next(row for row in on_round_feet if row["numbers"] == ["stance_rate"])
    two = next(best_subsets(on_round_feet))
    trial, lqr = (
        study.text(THESIS, "light", name, "strides", ".0f") for name in ("trial-open-loop", "lqr")
    )
    return (
        "**No measurement at all, if stable is all it must be.** Under its own constant control "
        f"each of the four gaits is stable: the largest multipliers are {each_of(radius)} (in the "
        f"order {each_of(WALKERS.__getitem__)}).\n\n"
        f"Pushed at every step (`light`), of 100 strides these walk {strides('open-loop')}. "
        f"Another constant control, chosen once in trials, walks {strides('trial-open-loop')}; "
        f"linear feedback of all four numbers (LQR) {strides('lqr')}. Two numbers walk "
        f"{strides('numbers-2')}; one number to both actions {strides('numbers-1')}; one to one "
        f"action {strides('one-number')}.\n\n"
        f"The fewest measured numbers that walk {100 * ENOUGH:.0f} % of the LQR's strides or more: "
        f"{', '.join(fewest)}. On the thesis's walker a constant control walks {trial} strides "
        f"where its LQR walks {lqr}. On round feet the stance rate alone, to both actions, walks "
        f"{rate['strides']:.0f} in trials, and {' and '.join(map(said, two['numbers']))} walk "
        f"{two['strides']:.0f}.\n"
    )


def fewest_numbers(study: Study, env_id: str) -> str:
    """In words, with the strides walked of the LQR's."""
    full = study.value(env_id, "light", "lqr", "strides") or 0.0
    for name, word in RUNGS.items():
        walked = study.value(env_id, "light", name, "strides")
        if walked is not None and walked >= ENOUGH * full:
            return f"{word} ({walked:.0f} of {full:.0f})"
    return "more than four"


def stable(study: Study, kernels: dict[str, Any]) -> str:
    """The score of the best where the optimum is known; the kernel; how long it lasts."""
    known = [(env_id, level) for level in LEVELS for env_id in WALKERS
             if (found := known_optimum(env_id, level)) and found.resolved]  # fmt: skip
    parts = []
    for env_id, level in known:
        best, value = best_learner(study, env_id, level)
        if best:
            parts.append(f"{WALKERS[env_id]} ({level}) `{best}` has {value:.2f} of it, the LQR "
                         f"{study.text(env_id, level, 'lqr', 'score', '.2f')}")  # fmt: skip
    listed = "; ".join(parts) or "the study's scores are not published with this version"
    shares = {name: each_of(lambda env_id, name=name: share(kernels, env_id, name))
              for name in ("open-loop", "lqr", "ppo", "optimal")}  # fmt: skip
    lasts = {
        name: each_of(lambda env_id, name=name: duration(study, env_id, "light", name))
        for name in ("open-loop", "lqr", "ppo")
    }
    return (
        "**Under light pushes nearly as stable as its bounds allow, but for the walker as "
        "published; under rough ones less so.** Counting the return from 0 (open loop) to 1 (the "
        f"optimum): {listed}. Elsewhere the optimum is not resolved, and only the best known "
        "control can be compared with.\n\n"
        "Of the states at heel strike from which *some* control within the bounds walks on, the "
        f"open loop keeps {shares['open-loop']}, the LQR {shares['lqr']}, PPO {shares['ppo']}, and "
        f"the optimum or the best known {shares['optimal']} (in the order "
        f"{each_of(WALKERS.__getitem__)}).\n\nPushed at every step (`light`) the open loop walks "
        f"{lasts['open-loop']} strides in the mean before it falls, the LQR {lasts['lqr']}, PPO "
        f"{lasts['ppo']}. A small multiplier is not what counts: see the last table.\n"
    )


def share(kernels: dict[str, Any], env_id: str, name: str) -> str:
    """Of a walker's kernel; a dash where it was not asked."""
    return between(kernels[env_id]["of_kernel"].get(name)) if env_id in kernels else "–"


def best_learner(study: Study, env_id: str, level: str) -> tuple[str, float]:
    """The controller of the greatest score but the optimum, and the score."""
    scored = {
        name: study.value(env_id, level, name, "score")
        for each, at, name in study.rows
        if (each, at) == (env_id, level) and name != "optimal"
    }
    known = {name: value for name, value in scored.items() if value is not None}
    best = max(known, key=lambda name: known[name], default="")
    return best, known.get(best, 0.0)


def computation(study: Study, bodies: dict[str, Any]) -> str:
    """The front in words, and what a body is worth."""
    lines = []
    for env_id, label in WALKERS.items():
        some = points(study, env_id)
        steps = []
        for limit, words in ((0, "no operation"), (16, "up to 16"), (200, "up to 200"),
                             (20_000, "up to 20,000"), (float("inf"), "any number")):  # fmt: skip
            within = [(time, name) for flops, time, name in some if flops <= limit]
            if within:
                best = max(within)[1]
                steps.append(f"{words} {duration(study, env_id, 'light', best)} (`{best}`)")
        lines.append(f"- {label}: {'; '.join(steps)}")
    gains = [
        f"{WALKERS[env_id]} {answer['walked']['own']['strides']:.0f} → "
        f"{answer['walked']['tuned']['strides']:.0f}"
        for env_id, answer in bodies.items()
    ]
    own = bodies[THESIS]
    return (
        "**A well chosen constant, then a gain of two or three numbers, then a network of eight "
        "units; and before all of them, on the thesis's legs, a better body.** Mean strides to a "
        "fall under "
        "`light` pushes, by the floating-point operations that a stride may take:\n\n"
        + "\n".join(lines)
        + "\n\n"
        f"Feet and masses chosen once for the least sensitivity (the norm on the thesis's legs "
        f"{own['norm']['own']:.3f} → {own['norm']['tuned']:.3f}, found in {own['seconds']:.0f} s) "
        f"walk in the open loop, with no operation a stride, of 100 strides: {', '.join(gains)}.\n"
    )


def each_of(text: Callable[[str], str]) -> str:
    """What is said of each walker, in their order."""
    values = [text(env_id) for env_id in WALKERS]
    return f"{', '.join(values[:-1])} and {values[-1]}"
