"""Numbers with their derivatives, in plain Python, against differences of sixth order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from powered_walker_env.model.mechanics import dual
from powered_walker_env.model.mechanics.dual import Dual, tangent_of, value_of
from tests.helpers.derivation import Array
from tests.helpers.differences import central

REAL: dict[str, Callable[[Any, Any], Any]] = {
    "sum": lambda a, b: a + b,
    "difference": lambda a, b: a - b,
    "product": lambda a, b: a * b,
    "quotient": lambda a, b: a / b,
    "minus": lambda a, b: -a * b,
    "plain numbers left": lambda a, b: 2.0 + 3.0 * a - (1.0 - b),
    "plain numbers right": lambda a, b: (a * 2.0 + 1.0 - b) / 4.0,
    "one over": lambda a, b: 1.0 / a + 2.0 / b,
    "an array left": lambda a, b: np.array([1.0, -2.0, 3.0]) * a + np.array([2.0, 1.0, 3.0]) / b,
    "an array right": lambda a, b: a - np.array([1.0, 2.0, 3.0]) + b * np.array([1.0, 2.0, 3.0]),
    "a number of numpy": lambda a, b: np.float64(2.0) * a - np.float64(1.0) / b,
    "unit": lambda a, b: dual.unit(a * b),
    "complex": lambda a, b: (a + 1j * b) * (2.0 - 1j * a),
    "conjugate": lambda a, b: dual.conjugate(a + 1j * b) * b,
    "square": lambda a, b: dual.square(a * a + 1j * b),
    "length": lambda a, b: dual.length(a + 1j * a * b),
    "choose": lambda a, b: dual.choose(np.array([True, False, True]), a * b, 1.0),
    "choose the other": lambda a, b: dual.choose(np.array([False, True, True]), 2.0, a / b),
}


@pytest.mark.parametrize("name", REAL)
def test_derivatives_are_those_of_differences_and_values_those_of_plain_numbers(name: str) -> None:
    function, rng = REAL[name], np.random.default_rng(1)
    for _ in range(20):
        a, b, da, db = rng.uniform(0.5, 2.0, (4, 3))
        found = function(Dual(a, da), Dual(b, db))
        assert isinstance(found, Dual)
        np.testing.assert_array_equal(found.value, function(a, b))

        def along(h: float, start: tuple[Array, ...] = (a, b, da, db)) -> Any:
            a, b, da, db = start
            return function(a + h * da, b + h * db)

        np.testing.assert_allclose(found.tangent, central(along, 1e-3), rtol=0, atol=3e-10)


def test_a_plain_number_has_no_derivative() -> None:
    assert (value_of(3.0), tangent_of(3.0)) == (3.0, 0.0)
    assert (value_of(Dual(3.0, 2.0)), tangent_of(Dual(3.0, 2.0))) == (3.0, 2.0)
    assert not isinstance(dual.choose(np.array([True]), 1.0, 2.0), Dual)


def test_a_division_by_nothing_is_not_a_number_and_spoils_no_neighbour() -> None:
    with np.errstate(all="ignore"):
        found = dual.length(Dual(np.array([0j, 3.0 + 4.0j]), np.array([1.0 + 0j, 1.0 + 0j])))
    assert np.isnan(found.tangent[0])
    assert found.tangent[1] == pytest.approx(0.6, rel=1e-15)
