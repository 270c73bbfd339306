"""Random numbers of N walkers: one 64-bit word each, normal draws compiled.

SplitMix64 (G. Steele, D. Lea & C. Flood, Fast splittable pseudorandom number
generators, OOPSLA 2014): a counter that advances by an odd constant, and a mixer. A
NumPy generator for each walker would take a kilobyte each and a Python call for each
draw; a word can be copied and saved as it is, and every walker still meets its own
noise, whatever walks beside it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from powered_walker_env.compiled.decorators import internal, kernel, rare
from powered_walker_env.simulation.strides import Array

Words = NDArray[np.uint64]

ADVANCE = np.uint64(0x9E3779B97F4A7C15)  # 2⁶⁴ over the golden ratio, odd
MIX_1, MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SHIFT_1, SHIFT_2, SHIFT_3 = np.uint64(30), np.uint64(27), np.uint64(31)
SPARE_BITS = np.uint64(11)  # a double holds 53 bits


def first_word(generator: np.random.Generator) -> np.uint64:
    """Where a walker's random numbers begin, drawn from a NumPy generator."""
    return generator.integers(2**64, dtype=np.uint64)


@internal
def mixed(word: np.uint64) -> np.uint64:
    """The 64 random bits that a state of the counter stands for."""
    word = (word ^ (word >> SHIFT_1)) * MIX_1
    word = (word ^ (word >> SHIFT_2)) * MIX_2
    return word ^ (word >> SHIFT_3)


@internal
def uniform(word: np.uint64) -> float:
    """A state of the counter as a number in (0, 1]; never 0, so that it has a logarithm."""
    return (float(mixed(word) >> SPARE_BITS) + 0.5) * 2.0**-53


@rare
def draw_row(word: np.uint64, sizes: Array, draws: Array, i: int) -> np.uint64:
    """Fill row i of `draws` (N, an even k) with normal numbers of deviations `sizes`.

    Box and Muller's method: two uniform numbers make two normal ones. Numbers of size zero
    are not made, but passed over, so that the others do not depend on them. Returns the word
    that the next numbers come from.
    """
    for j in range(0, draws.shape[1], 2):
        first = word + ADVANCE
        word = first + ADVANCE
        if sizes[j] == 0.0 and sizes[j + 1] == 0.0:
            draws[i, j], draws[i, j + 1] = 0.0, 0.0
            continue
        radius = math.sqrt(-2.0 * math.log(uniform(first)))
        angle = 2.0 * math.pi * uniform(word)
        draws[i, j] = sizes[j] * radius * math.cos(angle)
        draws[i, j + 1] = sizes[j + 1] * radius * math.sin(angle)
    return word


@kernel
def draw_normals(words: Words, sizes: Array, draws: Array) -> None:
    """`draw_row` for every word; the words advance."""
    for i in range(draws.shape[0]):
        words[i] = draw_row(words[i], sizes, draws, i)
