"""The tables of the two pages: titles, headers and rows of text, from the measures alone."""

from __future__ import annotations

from typing import Any

NONE = "–"
TIMINGS = ("toe-off-at-strike", "late-toe-off")  # of one and the same gait
NAMES = {
    "passive": "passive, on a slope",
    "toe-off": "toe-off before the strike",
    "toe-off-at-strike": "toe-off with it",
    "late-toe-off": "toe-off after it",
    "hip-torque": "hip torque",
    "motor-with-stop": "motor with a stop",
}


def coordination(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Stability and timing of every case; feedback; what the two numbers of a motor can do."""
    header = (
        "scheme", "largest multiplier", "the others", "as a clock", "sensitivity to pushes",
        "push survived, rad/s", "step survived, mm", "basin, %", "torque on, %",
        "legs pass at, %", "foot extends from, %",
    )  # fmt: skip
    found = [
        _table(case, header, [coordination_row(row) for row in case["schemes"]
                              if "reason" not in row and row["scheme"] not in TIMINGS])
        for case in content["cases"]
    ]  # fmt: skip
    return [*found, _refused(content), _feedback(content)]


def efficiency(content: dict[str, Any]) -> list[dict[str, Any]]:
    """Costs of every case, and of the best controls of a motor."""
    header = (
        "scheme", "its numbers", "step, m", "cost", "braked", "lost at strikes", "electrical",
        "ideal push here", "largest multiplier",
    )  # fmt: skip
    found = [
        _table(case, header, [efficiency_row(row) for row in case["schemes"]
                              if "reason" not in row])
        for case in content["cases"]
    ]  # fmt: skip
    return [*found, _best(content)]


def coordination_row(row: dict[str, Any]) -> list[str]:
    """One scheme's stability and timing."""
    timing, robust, foot = row["timing"], row["robustness"], row["timing"]["foot"]
    others = sorted((_size(value) for value in row["multipliers"][1:]), reverse=True)
    name = "toe-off, at any time" if row["scheme"] == "toe-off" else _name(row["scheme"])
    basin = robust and robust["basin"]
    return [
        name,
        f"{row['spectral_radius']:.3f}",
        ", ".join(f"{value:.2f}" for value in others if value > 5e-3) or "0",
        NONE if row["clock"] is None else f"{_size(row['clock'][0]):.3f}",
        f"{robust['sensitivity_to_pushes']:.3g}" if robust else NONE,
        _between(robust["push"]) if robust else NONE,
        _between([1e3 * each for each in robust["step"]]) if robust else NONE,
        f"{100 * basin['share']:.1f}" if basin else NONE,
        f"{100 * timing['acting']:.0f}",
        f"{100 * timing['legs_pass']:.0f}",
        f"{100 * foot['extends_from']:.0f}" if foot else NONE,
    ]


def efficiency_row(row: dict[str, Any]) -> list[str]:
    """One scheme's costs."""
    return [
        _name(row["scheme"]),
        ", ".join(f"{value:.5g}" for value in row["control"].values())
        or f"slope {row['slope']:.4g}",
        f"{row['step_length']:.4f}",
        f"{row['mechanical']:.5f}",
        f"{row['braked']:.5f}" if row["braked"] > 5e-6 else "0",
        f"{row['lost']:.5f}",
        NONE if row["electrical"] is None else f"{row['electrical']:.3g}",
        NONE if row["ideal"] is None else f"{row['ideal']:.5f}",
        f"{row['spectral_radius']:.3f}",
    ]


def _name(scheme: str) -> str:
    return NAMES.get(scheme, scheme)


def _size(pair: list[float]) -> float:
    return abs(complex(*pair))


def _between(ends: list[float]) -> str:
    return f"{ends[0]:+.3g} to {ends[1]:+.3g}".replace("-", "−")


def _table(case: dict[str, Any], header: Any, rows: list[list[str]]) -> dict[str, Any]:
    title = f"{case['legs']}: {case['speed']:.4g} m/s"
    return {"title": title, "header": list(header), "rows": rows}


def _refused(content: dict[str, Any]) -> dict[str, Any]:
    """No gait: of which legs under which schemes, in the words of the search."""
    where: dict[tuple[str, str], list[str]] = {}
    for case in content["cases"]:
        for row in case["schemes"]:
            if "reason" in row:
                words = row["reason"].partition(" (")[0].partition(", got ")[0]
                where.setdefault((case["case"], words), []).append(_name(row["scheme"]))
    rows = [[legs, ", ".join(names), words] for (legs, words), names in where.items()]
    return {"title": "No gait found", "header": ["legs", "schemes", "how far the search came"],
            "rows": rows}  # fmt: skip


def _feedback(content: dict[str, Any]) -> dict[str, Any]:
    rows = []
    for case in content["feedback"]:
        for name, loop in case["loops"].items():
            if "reason" in loop:
                rows.append([case["legs"], name, loop["reason"], *[NONE] * 4])
                continue
            norm = loop["sensitivity_to_pushes"]
            sizes = ", ".join(f"{_size(value):.3f}" for value in loop["multipliers"][:3])
            rows.append([
                case["legs"], name, sizes, NONE if norm is None else f"{norm:.3g}",
                _between(loop["push"]), _between([1e3 * each for each in loop["step"]]),
                f"{loop['mechanical']:.5f}",
            ])  # fmt: skip
    header = ["preset", "loop", "multipliers, sizes", "sensitivity to pushes",
              "push survived, rad/s", "step survived, mm", "cost"]  # fmt: skip
    return {"title": "Feedback", "header": header, "rows": rows}


def _best(content: dict[str, Any]) -> dict[str, Any]:
    words = {"spectral_radius": "forgets fastest", "mechanical": "least mechanical cost",
             "electrical": "least electrical cost"}  # fmt: skip
    rows = []
    for table in content["maps"]:
        for name, best in table["best"].items():
            rows.append([
                table["legs"], words[name], f"{best['switch_angle']:.4g}",
                f"{best['stall_torque']:.5g}", f"{best['spectral_radius']:.3f}",
                f"{best['mechanical']:.5f}", f"{best['electrical']:.3g}", f"{best['speed']:.4g}",
                f"{best['step_length']:.4g}",
            ])  # fmt: skip
    header = ["legs", "of the stable controls", "switch angle, rad", "stall torque, N m",
              "largest multiplier", "cost", "electrical", "speed, m/s", "step, m"]  # fmt: skip
    return {"title": "The best controls of a motor", "header": header, "rows": rows}
