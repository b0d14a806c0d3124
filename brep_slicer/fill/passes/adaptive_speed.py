"""Speed that follows the spacing: where neighbouring beads come nearer, each lays less metal.

In: the beads of one piece. Out: the same beads with speed factors.

A bead's share of the layer reaches half-way to its neighbours: the metal wanted per length is t times half the sum of the
distances to the left and to the right, against t d on even ground. Speed goes with the inverse.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brep_slicer.layers import NO_CLOSURE, Closure
from brep_slicer.maps import Array

from ..bead import Bead

# Farther than this many step-overs there is no neighbour.
FARTHEST = 1.6
# Along a bead, spacing is measured this often (of the step-over).
EVERY = 0.25


def with_speed_by_spacing(
    beads: Sequence[Bead], *, step_over: float, limits: tuple[float, float], closure: Closure = NO_CLOSURE
) -> tuple[Bead, ...]:
    """Give each bead factors on its speed, d / spacing within `limits`, at points no farther apart than a quarter of d.

    With a `closure`, beads a turn away are neighbours too.
    """
    dense = [_divided(bead, EVERY * step_over) for bead in beads]
    starts = np.concatenate([closure.moved(b.points[:-1], k) for k in closure.beside for b in dense])
    ends = np.concatenate([closure.moved(b.points[1:], k) for k in closure.beside for b in dense])
    out = []
    for bead in dense:
        spacing = _spacing(bead.points, starts, ends, step_over)
        out.append(replace(bead, speed=np.clip(step_over / spacing, *limits)))
    return tuple(out)


def _divided(bead: Bead, longest: float) -> Bead:
    import shapely

    line = shapely.segmentize(shapely.LineString(bead.points), longest)
    return replace(bead, points=shapely.get_coordinates(line), speed=None)


def _spacing(points: Array, a: Array, b: Array, step_over: float) -> Array:
    """Half the sum of the distances to the nearest beads on the left and on the right, (n,), mm."""
    way = np.gradient(points, axis=0)
    normal = np.stack([-way[:, 1], way[:, 0]], axis=1) / np.maximum(np.hypot(way[:, 0], way[:, 1]), 1e-300)[:, None]
    left, right = (_along(points, way * normal, a, b, FARTHEST * step_over) for way in (1.0, -1.0))
    # a bead lays as much to its left as to its right: on the rim, what its one neighbour leaves to it counts twice
    one = np.where(np.isfinite(left), left, right)
    both = np.isfinite(left) & np.isfinite(right)
    return np.where(both, 0.5 * (left + right), np.where(np.isfinite(one), one, step_over))


def _along(points: Array, ways: Array, a: Array, b: Array, farthest: float) -> Array:
    """Distance (n,) from each point along its way to the first segment that crosses it, inf if none is near."""
    out = np.full(len(points), np.inf)
    near = (np.minimum(a, b) - farthest, np.maximum(a, b) + farthest)
    for begin in range(0, len(points), 256):
        p, n = points[begin : begin + 256], ways[begin : begin + 256]
        some = ((near[1] >= p.min(axis=0)) & (near[0] <= p.max(axis=0))).all(axis=1)
        d, r = (b - a)[some], a[some][None] - p[:, None]
        cross = n[:, None, 0] * d[None, :, 1] - n[:, None, 1] * d[None, :, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            reach = (r[..., 0] * d[None, :, 1] - r[..., 1] * d[None, :, 0]) / cross
            share = (r[..., 0] * n[:, None, 1] - r[..., 1] * n[:, None, 0]) / cross
        hit = (reach > 1e-6) & (reach <= farthest) & (share >= 0.0) & (share <= 1.0)
        out[begin : begin + 256] = np.where(hit, reach, np.inf).min(axis=1, initial=np.inf)
    return out
