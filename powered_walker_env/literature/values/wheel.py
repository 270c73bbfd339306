"""The rimless wheel: closed forms (`model/rimless_wheel.py`) against published numbers."""

from __future__ import annotations

from powered_walker_env.literature.values.published import Kind, Origin, load
from powered_walker_env.literature.values.rows import Family, Row, digits_rows
from powered_walker_env.model.rimless_wheel import RimlessWheel


def _wheel() -> RimlessWheel:
    """Coleman's benchmark wheel."""
    data = load("published.json")["rimless_wheel"]["rimless_wheel"]
    return RimlessWheel.with_spokes(data["n"], data["alpha"], data["lambda2"])


def _known() -> list[Row]:
    data = load("published.json")["rimless_wheel"]["rimless_wheel"]
    name = f"rimless wheel, {data['n']} spokes, λ² = 2/3, slope {data['alpha']}"
    origin = Origin(Kind.PRINTED, FAMILY.name, name, data["source"])
    pairs = [
        ("rate after a collision, rad/s", data["x0"][1], _wheel().steady_rate),
        ("Floquet multiplier", data["sigma"], _wheel().multiplier),
    ]
    return digits_rows(origin, pairs, load("published.json")["accuracy"]["analytic"])


FAMILY = Family("wheel", {"wheel_rate": lambda: _wheel().steady_rate}, _known)
