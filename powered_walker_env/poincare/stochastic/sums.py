"""The sums over a law, compiled: expectations, best choices, and its matrix."""

from __future__ import annotations

import math

import numpy as np

from powered_walker_env.compiled.decorators import internal, kernel

LEFT = 1e-9  # of the weights, for their rounding


@internal
def _value_at(values, bends, counts, a, b, c, outside):
    """The table interpolated at a place; `outside` off the grid."""
    n, m, o = counts[0], counts[1], counts[2]
    if not (a >= 0.0 and b >= 0.0 and c >= 0.0 and a <= n - 1 and b <= m - 1 and c <= o - 1):
        return outside
    i, j, k = min(int(a), max(n - 2, 0)), min(int(b), max(m - 2, 0)), min(int(c), max(o - 2, 0))
    x, y, z = a - i, b - j, c - k
    right = m * o if n > 1 else 0
    up = o if m > 1 else 0
    ahead = 1 if o > 1 else 0
    base = (i * m + j) * o + k
    at = base + (right if x > 0.5 else 0) + (up if y > 0.5 else 0) + (ahead if z > 0.5 else 0)
    bend = (
        x * (1.0 - x) * bends[at, 0] + y * (1.0 - y) * bends[at, 1] + z * (1.0 - z) * bends[at, 2]
    )
    p, q = values[base], values[base + ahead]
    r, s = values[base + up], values[base + up + ahead]
    base += right
    t, u = values[base], values[base + ahead]
    v, w = values[base + up], values[base + up + ahead]
    front = (1.0 - y) * ((1.0 - z) * p + z * q) + y * ((1.0 - z) * r + z * s)
    back = (1.0 - y) * ((1.0 - z) * t + z * u) + y * ((1.0 - z) * v + z * w)
    found = (1.0 - x) * front + x * back - 0.5 * bend
    low = min(min(min(p, q), min(r, s)), min(min(t, u), min(v, w)))
    high = max(max(max(p, q), max(r, s)), max(max(t, u), max(v, w)))
    return min(max(found, low), high)


@internal
def _curved(curve, a, b, c):
    """The first place, counted in nodes, as a grid's curve has it (`Grid.counted_curve`)."""
    x, y, z = a - curve[5], b - curve[6], c - curve[7]
    level = y * (curve[2] * y + curve[3] * z) + curve[4] * z * z
    return curve[5] + x * math.exp(curve[0] * y + curve[1] * z) + level


@internal
def _led(mean, gain, bend, row, axis, u, v):
    """Where a row leads under the noise (u, v), along an axis, before the grid's curve."""
    straight = mean[row, axis] + gain[row, axis, 0] * u + gain[row, axis, 1] * v
    p, q, r = bend[row, axis, 0], bend[row, axis, 1], bend[row, axis, 2]
    return straight + (p * u + q * v) * u + r * v * v


@kernel
def best_choices(
    first, beyond, values, bends, counts, curve, begin, choice, weight, mean, gain, bend, reward,
    points, weights, discount, outside, factor, best, chosen,
):  # fmt: skip
    """`Law.best` of the nodes from `first` to before `beyond`."""
    bent = np.any(curve[:5] != 0.0)
    most = max(np.max(values), outside)
    for node in range(first, beyond):
        greatest, winner, total, current = 0.0, -1, 0.0, -1
        last = begin[node + 1]
        for row in range(begin[node], last):
            if choice[row] != current:
                if current >= 0 and (winner < 0 or total > greatest):
                    greatest, winner = total, current
                current, total = choice[row], 0.0
            # A choice of one row is left as soon as it cannot become the best.
            alone = total == 0.0 and (row + 1 == last or choice[row + 1] != current)
            enough = -np.inf
            if alone and winner >= 0 and weight[row] * discount > 0.0:
                enough = (greatest / weight[row] - factor * reward[row]) / discount
            expected, left = 0.0, 1.0 + LEFT
            for q in range(weights.shape[0]):
                u, v = points[q, 0], points[q, 1]
                a = _led(mean, gain, bend, row, 0, u, v)
                b = _led(mean, gain, bend, row, 1, u, v)
                c = _led(mean, gain, bend, row, 2, u, v)
                if bent:
                    a = _curved(curve, a, b, c)
                expected += weights[q] * _value_at(values, bends, counts, a, b, c, outside)
                left -= weights[q]
                if expected + left * most < enough:
                    expected += left * most
                    break
            total += weight[row] * (factor * reward[row] + discount * expected)
        if current >= 0 and (winner < 0 or total > greatest):
            greatest, winner = total, current
        best[node], chosen[node] = greatest, winner


@kernel
def spread(counts, curve, weight, mean, gain, bend, points, weights, index, share):
    """The nodes and shares that each row and point of ξ leads to; share 0 off the grid."""
    n, m, o = counts[0], counts[1], counts[2]
    number = 0
    bent = np.any(curve[:5] != 0.0)
    for row in range(weight.shape[0]):
        for q in range(weights.shape[0]):
            u, v = points[q, 0], points[q, 1]
            a = _led(mean, gain, bend, row, 0, u, v)
            b = _led(mean, gain, bend, row, 1, u, v)
            c = _led(mean, gain, bend, row, 2, u, v)
            if bent:
                a = _curved(curve, a, b, c)
            inside = a >= 0.0 and b >= 0.0 and c >= 0.0
            inside = inside and a <= n - 1 and b <= m - 1 and c <= o - 1
            i, j, k = 0, 0, 0
            if inside:
                i = min(int(a), max(n - 2, 0))
                j = min(int(b), max(m - 2, 0))
                k = min(int(c), max(o - 2, 0))
            for corner in range(8):
                di, dj, dk = corner >> 2, corner >> 1 & 1, corner & 1
                x = a - i if di else 1.0 - (a - i)
                y = b - j if dj else 1.0 - (b - j)
                z = c - k if dk else 1.0 - (c - k)
                part = weight[row] * weights[q] * x * y * z if inside else 0.0
                if part > 0.0:
                    index[number] = ((i + di) * m + j + dj) * o + k + dk
                else:
                    index[number], part = 0, 0.0
                share[number] = part
                number += 1


@kernel
def led_into(counts, mean, half, inside, every, off_grid, held):
    """Which rows (M,) lead into a set of nodes: all nodes about the row's box, or any of them.

    Args:
        mean, half: (M, 3) middle and half widths of the boxes, in nodes.
        inside: (N,) the set; every: whether all nodes about the box must be of it, or any.
        off_grid: whether what leaves the grid counts as of the set.
        held: (M,) is written.
    """
    m, o = counts[1], counts[2]
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for row in range(mean.shape[0]):
        leaves, misses = False, False
        for axis in range(3):
            low, high = mean[row, axis] - half[row, axis], mean[row, axis] + half[row, axis]
            if not (low >= 0.0 and high <= counts[axis] - 1):
                leaves = True
            if not (high >= 0.0 and low <= counts[axis] - 1):
                misses = True
            first[axis] = max(int(np.floor(max(low, 0.0))), 0)
            last[axis] = min(int(np.ceil(min(high, counts[axis] - 1.0))), counts[axis] - 1)
        if misses or (leaves and (off_grid or every)):
            held[row] = off_grid
            continue
        found = every
        for i in range(first[0], last[0] + 1):
            for j in range(first[1], last[1] + 1):
                for k in range(first[2], last[2] + 1):
                    if inside[(i * m + j) * o + k] != every:
                        found = not every
        held[row] = found
