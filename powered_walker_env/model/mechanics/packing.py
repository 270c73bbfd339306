"""The numbers that kernels need of a walker, from `WalkerParams`: one row of floats.

A row has the walker's own numbers, what follows from them (`Constants`), and its chains (`Chains`).
"""

from __future__ import annotations

import functools
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.records import Layout
from powered_walker_env.model.knee import Knee
from powered_walker_env.model.mechanics.constants import Constants, constants_from
from powered_walker_env.model.mechanics.dual import Dual, tangent_of, value_of
from powered_walker_env.model.mechanics.links import (
    Chain,
    Chains,
    bent_chain,
    free_chain,
    locked_chain,
)
from powered_walker_env.model.quantities import quantities
from powered_walker_env.model.walker import AS_PUBLISHED, CONSERVING, WalkerParams

Array = NDArray[np.float64]

#: Names of the walker's own numbers, in the order in which they begin its row.
NUMBERS = (*quantities(WalkerParams), *quantities(Knee), "as_published")
OWN = len(NUMBERS)
LEG_LENGTH, LEG_MASS, GRAVITY = (NUMBERS.index(n) for n in ("leg_length", "leg_mass", "gravity"))

CONSTANTS, CHAIN = Layout(Constants), Layout(Chain)
CONSTANTS_SIZE, CHAIN_SIZE = CONSTANTS.size, CHAIN.size
#: Where the parts of a row begin.
LOCKED_CHAIN = OWN + CONSTANTS_SIZE
FREE_CHAIN, BENT_CHAIN = LOCKED_CHAIN + CHAIN_SIZE, LOCKED_CHAIN + 2 * CHAIN_SIZE
ROW = BENT_CHAIN + CHAIN_SIZE


def own_numbers(params: WalkerParams) -> list[float]:
    """A walker's own numbers, in the order of `NUMBERS`."""
    own = [getattr(params, name) for name in quantities(WalkerParams)]
    knee = [0.0 if params.knee is None else getattr(params.knee, n) for n in quantities(Knee)]
    return [*own, *knee, float(params.physics == AS_PUBLISHED)]


def rows_from_own(own: Array) -> Array:
    """(N, ROW) the rows of walkers from their own numbers, (N, OWN)."""
    numbers = SimpleNamespace(**dict(zip(NUMBERS, own.T, strict=True)))
    return np.ascontiguousarray(np.hstack([own, _derived(numbers, value_of)]))


def row_tangents(own: Array, change: Array) -> Array:
    """(N, ROW) derivatives of the rows of walkers along a change of their own numbers, (OWN,)."""
    if not change.any():
        return np.zeros((len(own), ROW))
    moved = {
        name: Dual(number, np.full(len(own), part))
        for name, number, part in zip(NUMBERS, own.T, change, strict=True)
    }
    tangents = _derived(SimpleNamespace(**moved), tangent_of)
    return np.ascontiguousarray(np.hstack([np.tile(change, (len(own), 1)), tangents]))


def _derived(own: SimpleNamespace, part: Any) -> Array:
    count = len(value_of(own.leg_length))
    with np.errstate(all="ignore"):  # of walkers that no kernel can walk either
        c = constants_from(own)
        chains = Chains(locked_chain(c), free_chain(c), bent_chain(c, own))
        records: list[tuple[Layout[Any], Any]] = [(CONSTANTS, c), *((CHAIN, x) for x in chains)]
        columns = [
            column if np.ndim(column) else np.full(count, column)
            for layout, record in records
            for column in layout.columns([part(value) for value in record])
        ]
    return np.stack(columns, axis=1)


def pack_all(walkers: Sequence[WalkerParams]) -> Array:
    """(N, ROW) the rows of N walkers."""
    return rows_from_own(np.array([own_numbers(params) for params in walkers]))


def packed(params: WalkerParams) -> Array:
    """(1, ROW) the walker's row; everybody's, not to be written to."""
    global _latest  # to hash a walker takes longer than to find it the same
    walker, row = _latest
    if walker is not params:
        row = _packed(params)
        _latest = params, row
    return row


@functools.lru_cache(maxsize=256)
def _packed(params: WalkerParams) -> Array:
    return pack_all([params])


_latest: tuple[WalkerParams | None, Array] = None, np.empty((0, 0))


def pack(params: WalkerParams) -> Array:
    """(ROW,) the walker's row."""
    return packed(params)[0].copy()


def params_of(row: Array) -> WalkerParams:
    """The inverse of `pack`."""
    *numbers, as_published = row[:OWN].tolist()
    known = dict(zip(NUMBERS[:-1], numbers, strict=True))
    knee = {name: known.pop(name) for name in quantities(Knee)}
    return WalkerParams(
        **known,
        knee=Knee(**knee) if knee["shank_length"] else None,
        physics=AS_PUBLISHED if as_published else CONSERVING,
    )


def constants_of(params: WalkerParams) -> Constants:
    """The walker as the formulas take it."""
    return CONSTANTS.of(pack(params)[OWN:LOCKED_CHAIN])


def chains_of(params: WalkerParams) -> Chains:
    """The walker's chains."""
    row = pack(params)
    return Chains(*(CHAIN.of(row[first:]) for first in (LOCKED_CHAIN, FREE_CHAIN, BENT_CHAIN)))
