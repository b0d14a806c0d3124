"""Beads taken apart into bits of equal metal, from a toolpath's points, speeds and the bead's profile alone.

In: a toolpath, d and w, the usual speed. Out: places of bits, their metal over t, the bead of each.

A segment lays t d per length at the usual speed, spread as the bead's section (a parabola w wide); round corners as a round
drop (half an ellipsoid) that moves along, which leaves that section; beyond a bead's end as that section turned about its
middle.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

# A place on a bead so often (of its width), so many bits there, and so many in each round end.
EVERY, BITS, IN_END = 1.0 / 20.0, 96, 192
# A bead turns sharply where the cosine between two segments is below this.
CORNER = 0.955
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Bits:
    """`places` (n, 2) in (kappa, v), `metal` (n,) in mm2: its volume over t, `bead` (n,)."""

    places: np.ndarray
    metal: np.ndarray
    bead: np.ndarray


def bits_of_layer(path, layer: int, *, step_over: float, width: float, usual: float, period: float) -> Bits:
    """All beads of a layer as bits; `usual` is the deposition speed (mm/s) at which a segment lays t d per length."""
    rows = np.flatnonzero((path.layer == layer) & path.deposits)
    flat = np.stack([path.kappa, path.v], axis=1)
    length = np.hypot(*(flat[rows] - flat[rows - 1]).T)
    rows, length = rows[length > 0.0], length[length > 0.0]
    if not len(rows):
        return Bits(places=np.zeros((0, 2)), metal=np.zeros(0), bead=np.zeros(0, dtype=int))
    a, bead = flat[rows - 1], path.bead[rows]
    way, amount = (flat[rows] - a) / length[:, None], step_over * usual / path.speed[rows]
    first = np.flatnonzero(np.append(True, bead[1:] != bead[:-1]))
    last = np.append(first[1:], len(bead)) - 1
    gap = flat[rows[last]] - a[first]
    gap[:, 0] -= np.round(gap[:, 0] / period) * period
    is_open = np.hypot(*gap.T) > 1e-6
    # where along its bead each bit lies, and how far from the next corner
    cuts = np.ceil(length / (EVERY * width)).astype(int)
    of = np.repeat(np.arange(len(a)), cuts)
    step = (np.arange(len(of)) - np.repeat(np.cumsum(cuts) - cuts, cuts) + 0.5) / cuts[of]
    before = np.cumsum(length) - length
    along = before[of] + step * length[of]
    corner = np.append(True, np.einsum("ij,ij->i", way[1:], way[:-1]) < CORNER)
    corner[first] = False
    corners = [*before[corner], *before[first[~is_open]], *(before + length)[last[~is_open]]]
    corners = np.sort([-np.inf, *corners, np.inf])
    after = np.searchsorted(corners, along)
    near = np.minimum(along - corners[after - 1], corners[after] - along) < 0.5 * width
    x, y = _spread(len(of), near)
    laid = _placed(a[of] + (step * length[of])[:, None] * way[of], way[of], 0.5 * width * x, 0.5 * width * y)
    metal = np.repeat(amount[of] * length[of] / cuts[of] / BITS, BITS)
    ends, tips, out = _ends(first[is_open], last[is_open], a, flat[rows], way)
    x, y = 0.5 * width * _round_end()
    beyond = _placed(tips, out, x[None], y[None])
    # a round end holds as much as 3 pi / 32 w of the bead's length
    held = np.repeat(amount[ends] * 3.0 * math.pi / 32.0 * width / IN_END, IN_END)
    owner = np.concatenate([np.repeat(bead[of], BITS), np.repeat(bead[ends], IN_END)])
    return Bits(places=np.concatenate([laid, beyond]), metal=np.concatenate([metal, held]), bead=owner)


def _placed(places, way, x, y):
    side = np.stack([-way[:, 1], way[:, 0]], axis=1)
    return (places[:, None] + x[:, :, None] * way[:, None] + y[:, :, None] * side[:, None]).reshape(-1, 2)


def _ends(first, last, starts, stops, way):
    """Which segments end beads, where, and which way on."""
    ends = np.concatenate([first, last])
    return ends, np.concatenate([starts[first], stops[last]]), np.concatenate([-way[first], way[last]])


def _spread(count: int, at_corner):
    """Bits of `count` places along and across, in half widths: drops where `at_corner`, sections elsewhere.

    They lie elsewhere at each place, so that no edge that runs along a bead parts the same two bits all along. The share of a
    section below s is (2 + 3 s - s**3) / 4, that of a drop within r is 1 - (1 - r**2)**(3/2).
    """
    s, k, place = np.linspace(-1.0, 1.0, 4001), np.arange(BITS), np.arange(count)[:, None]
    across = np.interp((k + np.remainder(GOLDEN * place, 1.0)) / BITS, 0.25 * (2.0 + 3.0 * s - s**3), s)
    r, angle = np.sqrt(1.0 - (1.0 - (k + 0.5) / BITS) ** (2.0 / 3.0)), 2.0 * np.pi * (GOLDEN * k + math.sqrt(2.0) * place)
    drop = np.asarray(at_corner)[:, None]
    return np.where(drop, r * np.cos(angle), 0.0), np.where(drop, r * np.sin(angle), across)


def _round_end():
    """The share of a round end within r is 2 r**2 - r**4."""
    k = np.arange(IN_END)
    r, angle = np.sqrt(1.0 - np.sqrt(1.0 - (k + 0.5) / IN_END)), np.pi * (np.remainder(GOLDEN * k, 1.0) - 0.5)
    return np.stack([r * np.cos(angle), r * np.sin(angle)])
