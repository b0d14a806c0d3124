"""A region and its beads drawn in one chart, copies across the seam included.

In: a region, beads. Out: polygons and tracks of the same stretch of the plane.

Words: *track*, a part of a bead that does not come back beside itself: a spiral's turns, a zigzag's lines are tracks each.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.fill import Bead
from brep_slicer.maps import Array
from brep_slicer.region import Region

# A track ends where it has turned by this much in all (rad).
MOST_TURN = np.pi - 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Track:
    """`points` (n, 2) of a part of bead number `bead`, the `speed` factors there, and whether its `ends` are the bead's own."""

    bead: int
    points: Array
    speed: Array
    ends: tuple[bool, bool]


def drawn(region: Region, beads: Sequence[Bead], *, reach: float, chord: float = 0.005):
    """(the region's polygon, every copy of every track that comes within `reach` (mm) of it)."""
    import shapely

    shape = shapely.union_all([p if p.is_valid else p.buffer(0.0) for p in region.to_shapely(chord=chord).geoms])
    box = shape.bounds if not shape.is_empty else (0.0, 0.0, 0.0, 0.0)
    around = shapely.box(*box).buffer(reach).bounds
    closure = region.closure
    low, high = closure.span_of(around)
    tracks: list[Track] = []
    for number, bead in enumerate(beads):
        for points, speed, ends in _parts(bead):
            turns = closure.turns_along(points)
            for k in range(math.ceil(low - float(turns.max())), math.floor(high - float(turns.min())) + 1):
                moved = closure.moved(points, k)
                (x0, y0), (x1, y1) = moved.min(axis=0), moved.max(axis=0)
                if x0 <= around[2] and x1 >= around[0] and y0 <= around[3] and y1 >= around[1]:
                    tracks.append(Track(bead=number, points=moved, speed=speed, ends=ends))
    return shape, tracks


def _parts(bead: Bead) -> Iterator[tuple[Array, Array, tuple[bool, bool]]]:
    points = bead.points
    speed = np.ones(len(points)) if bead.speed is None else bead.speed
    way = np.arctan2(*np.diff(points, axis=0).T[::-1])
    turn = np.abs(np.remainder(np.diff(way) + np.pi, 2.0 * np.pi) - np.pi)
    begin, total = 0, 0.0
    for i, angle in enumerate(turn.tolist(), start=1):
        total += angle
        if total > MOST_TURN:
            yield points[begin : i + 1], speed[begin : i + 1], (begin == 0 and not bead.closed, False)
            begin, total = i, 0.0
    yield points[begin:], speed[begin:], (begin == 0 and not bead.closed, not bead.closed)
