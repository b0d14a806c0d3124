"""Outlines of what is drawn in the plane, closed over the seam.

In: shapely geometry that repeats itself from turn to turn. Out: its outlines once each, with their winding.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from brep_slicer.errors import LayerError
from brep_slicer.maps import Array

if TYPE_CHECKING:
    from shapely import Geometry

# Ends of an outline on the two sides of the chart belong together within this, mm.
SAME_PLACE = 1e-6


class Outlined(NamedTuple):
    """`points` (n, 2) once round, what is outlined on their left; the last is the first, `winding` turns on."""

    points: Array
    winding: int


def stitched_outlines(shape: Geometry, *, first: float, period: float, thin: float = 0.0, spot: float = 0.0) -> list[Outlined]:
    """The outlines of a geometry, each once, thinned out to `thin` (mm).

    It is cut at a kappa from `first` (mm) to a turn further on where no corner lies, and a turn from there: so far it must be
    drawn. Polygons there of an area less than `spot` (mm**2) are left out.

    Raises
    ------
    LayerError
        If the two sides of the cut do not fit together.
    """
    import shapely

    if shape.is_empty:
        return []
    seam = _free_place(shape, first, period)
    low, high = shape.bounds[1::2]
    flat = shape.intersection(shapely.box(seam, low - 1.0, seam + period, high + 1.0))
    polygons = [p for p in shapely.get_parts(flat) if p.geom_type == "Polygon" and p.area > spot]
    rings = [ring for p in polygons for q in [shapely.orient_polygons(p)] for ring in (q.exterior, *q.interiors)]
    runs = [run for ring in rings for run in _runs(np.asarray(ring.coords)[:-1], seam, period)]
    if thin:
        runs = [np.asarray(shapely.LineString(run).simplify(thin).coords) for run in runs]
    closed = [bool((run[0] == run[-1]).all()) for run in runs]
    whole = [Outlined(run, 0) for run, shut in zip(runs, closed, strict=True) if shut and len(run) > 3]
    return whole + _stitched([run for run, shut in zip(runs, closed, strict=True) if not shut], seam, period)


def _free_place(shape: Geometry, first: float, period: float) -> float:
    """A kappa in [first, first + period) as far from all corners as can be."""
    import shapely

    corners = np.sort(np.remainder(shapely.get_coordinates(shape)[:, 0], period))
    gaps = np.diff(np.append(corners, corners[0] + period))
    place = float(corners[gaps.argmax()] + 0.5 * gaps.max())
    return place - period * math.floor((place - first) / period)


def _runs(ring: Array, seam: float, period: float) -> list[Array]:
    """Stretches (n, 2) of a closed ring that do not run along a side of the chart; a closed one repeats its first point."""
    following = np.roll(ring, -1, axis=0)
    on = np.abs(np.abs(ring[:, 0] - seam - 0.5 * period) - 0.5 * period) < 1e-9
    after = np.abs(np.abs(following[:, 0] - seam - 0.5 * period) - 0.5 * period) < 1e-9
    along = on & after & (np.abs(following[:, 0] - ring[:, 0]) < 1e-9)
    if not along.any():
        return [np.concatenate([ring, ring[:1]])]
    # begin behind a segment along a side, then cut at every other one
    first = int(np.flatnonzero(along)[0]) + 1
    ring, along = np.roll(ring, -first, axis=0), np.roll(along, -first)
    cuts = np.flatnonzero(along)
    return [part for part in np.split(ring, cuts + 1) if len(part) > 1]


def _stitched(runs: list[Array], seam: float, period: float) -> list[Outlined]:
    """Runs from side to side of the chart, each followed by the one that goes on from its end on the other side."""
    starts, ends = (np.array([run[k] for run in runs]).reshape(-1, 2) for k in (0, -1))
    follower = np.full(len(runs), -1)
    for side in (0.0, period):
        ending = np.flatnonzero(np.abs(ends[:, 0] - seam - side) < 0.25 * period)
        beginning = np.flatnonzero(np.abs(starts[:, 0] - seam - period + side) < 0.25 * period)
        ending, beginning = ending[ends[ending, 1].argsort()], beginning[starts[beginning, 1].argsort()]
        if len(ending) != len(beginning) or np.any(np.abs(ends[ending, 1] - starts[beginning, 1]) > SAME_PLACE):
            raise LayerError(f"an outline does not close over the seam at kappa {seam:g} mm")
        follower[ending] = beginning
    out, used = [], np.zeros(len(runs), dtype=bool)
    for begin in range(len(runs)):
        if used[begin]:
            continue
        chain, turns, i = [runs[begin][:1]], 0, begin
        while not used[i]:
            used[i] = True
            chain.append(runs[i][1:] + np.array([turns * period, 0.0]))
            turns += 1 if ends[i, 0] > seam + 0.5 * period else -1
            i = int(follower[i])
        chain[-1][-1] = runs[begin][0] + np.array([turns * period, 0.0])
        out.append(Outlined(np.concatenate(chain), turns))
    return out
