"""The rimless wheel: closed forms (`rimless_wheel.py`) against published numbers."""

from __future__ import annotations

from powered_walker_env.literature.values.checks import Measures, Row, digits_row, printed_rows
from powered_walker_env.literature.values.published import load
from powered_walker_env.model.rimless_wheel import RimlessWheel

FAMILY = "wheel"


def wheel() -> RimlessWheel:
    """Coleman's benchmark wheel."""
    data = load("published.json")["rimless_wheel"]["rimless_wheel"]
    return RimlessWheel.with_spokes(data["n"], data["alpha"], data["lambda2"])


def rows(long: bool) -> list[Row]:
    """The lines of this family."""
    data = load("published.json")["rimless_wheel"]["rimless_wheel"]
    name = f"rimless wheel, {data['n']} spokes, λ² = 2/3, slope {data['alpha']}"
    compared = {
        "rate after a collision, rad/s": (data["x0"][1], wheel().steady_rate),
        "Floquet multiplier": (data["sigma"], wheel().multiplier),
    }
    within = load("published.json")["accuracy"]["analytic"]
    found = [
        digits_row(FAMILY, name, data["source"], quantity, value, ours, within)
        for quantity, (value, ours) in compared.items()
    ]
    return found + printed_rows(FAMILY, MEASURES, long)


MEASURES: Measures = {"wheel_rate": lambda: wheel().steady_rate}
