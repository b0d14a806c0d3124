"""Outlines of what is drawn in the plane, closed over the seam.

In: shapely geometry that repeats itself from turn to turn. Out: its outlines once each, with their winding.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from brep_slicer.errors import LayerError
from brep_slicer.layers import Closure
from brep_slicer.maps import Array

if TYPE_CHECKING:
    from shapely import Geometry

# Ends of an outline on the two sides of the chart belong together within this, mm.
SAME_PLACE = 1e-6
# What lies no farther from a side of the chart lies on it, mm: rounding.
ON_SIDE = 1e-9


class Outlined(NamedTuple):
    """`points` (n, 2) once round, what is outlined on their left; the last is the first, `winding` turns on."""

    points: Array
    winding: int


def stitched_outlines(
    shape: Geometry, closure: Closure, *, first: float, thin: float = 0.0, spot: float = 0.0
) -> list[Outlined]:
    """The outlines of a geometry, each once, thinned out to `thin` (mm).

    It is cut at a place from `first` (turns) to a turn further on where no corner lies, and a turn from there: so far it must
    be drawn. Polygons there of an area less than `spot` (mm**2) are left out.

    Raises
    ------
    LayerError
        If the two sides of the cut do not fit together.
    """
    import shapely

    if shape.is_empty:
        return []
    corners = shapely.get_coordinates(shape)
    heights = closure.heights_of(corners)
    seam = _free_place(closure.turns_near(corners, first + 0.5), first)
    flat = shape.intersection(closure.window(seam, seam + 1.0, float(heights.min()) - 1.0, float(heights.max()) + 1.0))
    polygons = [p for p in shapely.get_parts(flat) if p.geom_type == "Polygon" and p.area > spot]
    rings = [ring for p in polygons for q in [shapely.orient_polygons(p)] for ring in (q.exterior, *q.interiors)]
    runs = [run for ring in rings for run in _runs(np.asarray(ring.coords)[:-1], seam, closure)]
    if thin:
        runs = [np.asarray(shapely.LineString(run).simplify(thin).coords) for run in runs]
    closed = [bool((run[0] == run[-1]).all()) for run in runs]
    whole = [Outlined(run, 0) for run, shut in zip(runs, closed, strict=True) if shut and len(run) > 3]
    return whole + _stitched([run for run, shut in zip(runs, closed, strict=True) if not shut], seam, closure)


def _free_place(turns: Array, first: float) -> float:
    """A place in [first, first + 1) turns as far from all corners, at `turns` (n,), as can be."""
    corners = np.sort(np.remainder(turns, 1.0))
    gaps = np.diff(np.append(corners, corners[0] + 1.0))
    place = float(corners[gaps.argmax()] + 0.5 * gaps.max())
    return place - math.floor(place - first)


def _runs(ring: Array, seam: float, closure: Closure) -> list[Array]:
    """Stretches (n, 2) of a closed ring that do not run along a side of the chart; a closed one repeats its first point."""
    turns = closure.turns_near(ring, seam + 0.5)
    following = np.roll(turns, -1)
    beside = ON_SIDE / closure.ring_lengths(closure.heights_of(ring))
    on, after = (np.abs(np.abs(t - seam - 0.5) - 0.5) < beside for t in (turns, following))
    along = on & after & (np.abs(following - turns) < beside)
    if not along.any():
        return [np.concatenate([ring, ring[:1]])]
    # begin behind a segment along a side, then cut at every other one
    first = int(np.flatnonzero(along)[0]) + 1
    ring, along = np.roll(ring, -first, axis=0), np.roll(along, -first)
    cuts = np.flatnonzero(along)
    return [part for part in np.split(ring, cuts + 1) if len(part) > 1]


def _stitched(runs: list[Array], seam: float, closure: Closure) -> list[Outlined]:
    """Runs from side to side of the chart, each followed by the one that goes on from its end on the other side."""
    starts, ends = (np.array([run[k] for run in runs]).reshape(-1, 2) for k in (0, -1))
    (begin_at, begin_high), (end_at, end_high) = (
        (closure.turns_near(points, seam + 0.5) - seam, closure.heights_of(points)) for points in (starts, ends)
    )
    follower = np.full(len(runs), -1)
    for side in (0.0, 1.0):
        ending = np.flatnonzero(np.abs(end_at - side) < 0.25)
        beginning = np.flatnonzero(np.abs(begin_at - 1.0 + side) < 0.25)
        ending, beginning = ending[end_high[ending].argsort()], beginning[begin_high[beginning].argsort()]
        if len(ending) != len(beginning) or np.any(np.abs(end_high[ending] - begin_high[beginning]) > SAME_PLACE):
            raise LayerError(f"an outline does not close over the seam, {360.0 * seam:g} degrees round")
        follower[ending] = beginning
    out, used = [], np.zeros(len(runs), dtype=bool)
    for begin in range(len(runs)):
        if used[begin]:
            continue
        chain, turns, i = [runs[begin][:1]], 0, begin
        while not used[i]:
            used[i] = True
            chain.append(closure.moved(runs[i][1:], turns))
            turns += 1 if end_at[i] > 0.5 else -1
            i = int(follower[i])
        chain[-1][-1] = closure.moved(runs[begin][0], turns)
        out.append(Outlined(np.concatenate(chain), turns))
    return out
