"""How much metal beads of any course need: what of a piece is nearest to each stretch of them.

In: a polygon, beads. Out: the beads with more points, and the amount of metal at each (1: t d per length).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from brep_slicer.layers import NO_CLOSURE, Closure
from brep_slicer.maps import Array, lengths_along

from ..bead import Bead, BeadKind
from .metal import ROUND_END
from .within import LEAST_WITHIN, Within

# Stretches of a bead and cells of the piece's grid, in step-overs: some fifteen cells a stretch.
STRETCH, GRID = 0.5, 0.18
# More cells than this are not asked for: the grid is coarser on large pieces.
MOST_CELLS = 200_000
# Amounts that lie on a straight line along the bead within this are not written out.
TOLERANCE = 0.03
# What is farther from all beads than this (of the larger of step-over and bead width) is not theirs to fill.
REACH = 0.75


def amounts_by_nearest(
    ground, beads: Sequence[Bead], *, step_over: float, width: float, within: Within, closure: Closure = NO_CLOSURE
) -> tuple[list[Array], list[Array], float]:
    """(points, amounts) of each bead, and the share of the polygon that they reach; with a `closure` across the seam, too."""
    places, ways, lengths, owner = _stretches(beads, STRETCH * step_over, width)
    # only where the piece is narrower than a bead; near the outline a bead lays as much beyond it as the fit asks for
    narrow = np.array([bead.kind is BeadKind.SKELETON for bead in beads])[owner]
    if narrow.any():
        lengths[narrow] *= np.maximum(within.shares(places[narrow], ways[narrow]), LEAST_WITHIN)
    cell = max(GRID * step_over, (ground.area / MOST_CELLS) ** 0.5)
    inside, corner = _grid(ground, cell)
    copies = np.concatenate([closure.moved(places, turns) for turns in closure.beside])
    nearest = _nearest((copies - corner) / cell, inside, REACH * max(width, step_over) / cell)
    reached = nearest[nearest >= 0] % len(places)
    cells = max(int(inside.sum()), 1)
    area = np.bincount(reached, minlength=len(places)) * (ground.area / cells)
    out_points, out_amounts = [], []
    last = np.searchsorted(owner, np.arange(len(beads) + 1))
    for i, bead in enumerate(beads):
        mine = slice(last[i], last[i + 1])
        amount = _smooth(area[mine], bead.closed) / np.maximum(step_over * _smooth(lengths[mine], bead.closed), 1e-300)
        p, a = _along(bead, amount)
        out_points.append(p)
        out_amounts.append(a)
    return out_points, out_amounts, len(reached) / cells


def _grid(ground, cell: float) -> tuple[Array, Array]:
    """Of the square cells over a polygon, those (rows, columns) whose middles lie inside, and the first one's middle (2,)."""
    import shapely

    k0, v0, k1, v1 = ground.bounds
    kappa, v = (np.arange(lo + 0.5 * cell, hi, cell) for lo, hi in ((k0, k1), (v0, v1)))
    shapely.prepare(ground)
    return shapely.contains_xy(ground, *np.meshgrid(kappa, v)), np.array([k0, v0]) + 0.5 * cell


def _nearest(places: Array, inside: Array, reach: float) -> Array:
    """For each cell that is inside, the number of the place nearest to it; -1 where none is within reach, and outside.

    Places (n, 2) and reach are in cells, from the middle of the first one. Each place looks at the cells round it only.
    """
    near = np.arange(-math.ceil(reach), math.ceil(reach) + 1)
    columns, rows = (np.rint(places[:, k]).astype(int)[:, None] + near for k in (0, 1))
    distance = np.hypot((columns - places[:, :1])[:, None, :], (rows - places[:, 1:])[:, :, None])
    high, wide = inside.shape
    there = ((columns >= 0) & (columns < wide))[:, None, :] & ((rows >= 0) & (rows < high))[:, :, None]
    seen = (distance <= reach) & there
    place, distance = np.nonzero(seen)[0], distance[seen]
    cell = (rows[:, :, None] * wide + columns[:, None, :])[seen]
    least = np.full(inside.size, np.inf)
    np.minimum.at(least, cell, distance)
    first = distance == least[cell]
    out = np.full(inside.size, -1)
    out[cell[first]] = place[first]
    return np.where(inside, out.reshape(inside.shape), -1)


def _stretches(beads: Sequence[Bead], longest: float, width: float) -> tuple[Array, Array, Array, Array]:
    """Middles (n, 2) of equal stretches of all beads, unit vectors along them, what lengths they hold, round ends included, and
    whose they are."""
    places, ways, lengths, owner = [], [], [], []
    for i, bead in enumerate(beads):
        along = lengths_along(bead.points)
        n = max(1, int(np.ceil(along[-1] / longest)))
        at = (np.arange(n) + 0.5) * along[-1] / n
        places.append(np.stack([np.interp(at, along, bead.points[:, k]) for k in (0, 1)], axis=1))
        k = np.clip(np.searchsorted(along, at), 1, len(along) - 1)
        way = bead.points[k] - bead.points[k - 1]
        ways.append(way / np.maximum(np.hypot(*way.T), 1e-300)[:, None])
        held = np.full(n, along[-1] / n)
        if not bead.closed:
            held[0] += ROUND_END * width
            held[-1] += ROUND_END * width
        lengths.append(held)
        owner.append(np.full(n, i))
    return np.concatenate(places), np.concatenate(ways), np.concatenate(lengths), np.concatenate(owner)


def _smooth(values: Array, closed: bool) -> Array:
    """Averaged over some three stretches; what it sums up to stays about the same."""
    if len(values) < 3:
        return np.full(len(values), values.mean())
    for _ in range(2):
        padded = np.concatenate([values[-1:], values, values[:1]]) if closed else np.pad(values, 1, mode="edge")
        values = 0.25 * padded[:-2] + 0.5 * padded[1:-1] + 0.25 * padded[2:]
    return values


def _along(bead: Bead, amount: Array) -> tuple[Array, Array]:
    """The bead's own points and as many more as the amounts ask for."""
    import shapely

    along = lengths_along(bead.points)
    n = len(amount)
    at = (np.arange(n) + 0.5) * along[-1] / n
    ends = np.full(2, 0.5 * (amount[0] + amount[-1])) if bead.closed else amount[[0, -1]]
    at, amount = np.concatenate([[0.0], at, along[-1:]]), np.concatenate([ends[:1], amount, ends[1:]])
    # a line through (length, amount): as few of its points as keep it within the tolerance
    scale = 1e-3 * max(float(along[-1]), 1e-9)
    kept = shapely.get_coordinates(shapely.LineString(np.stack([at, scale * amount], axis=1)).simplify(scale * TOLERANCE))
    knots = np.unique(np.concatenate([along, kept[:, 0]]))
    points = np.stack([np.interp(knots, along, bead.points[:, k]) for k in (0, 1)], axis=1)
    return points, np.interp(knots, kept[:, 0], kept[:, 1] / scale)
