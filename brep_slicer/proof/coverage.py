"""How much of a region its beads cover: bare, once, more than once.

In: a region, beads, their width. Out: areas, exact but for the chord of the samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.fill import Bead
from brep_slicer.layers import Closure
from brep_slicer.maps import Array
from brep_slicer.region import Region

from .chart import Track, drawn
from .equals import Share

# Segments a quarter circle of the beads' round ends.
QUARTER = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class Coverage:
    """Areas in mm**2: of a region, of what is `bare`, covered by one bead (`once`) or `more`, and covered `outside` of it."""

    area: float
    bare: float
    once: float
    more: float
    outside: float

    @property
    def bare_share(self) -> float:
        """Bare area over the region's."""
        return self.bare / self.area if self.area else 0.0


def coverage_of_shares(shares: Sequence[Share], width: float) -> Coverage:
    """Coverage of a layer by shares of it, each as many times as it counts."""
    found = [(share.times, coverage_of(share.region, share.beads, width)) for share in shares]
    names = ("area", "bare", "once", "more", "outside")
    return Coverage(**{name: sum(times * getattr(one, name) for times, one in found) for name in names})


def coverage_of(region: Region, beads: Sequence[Bead], width: float) -> Coverage:
    """Coverage of a region by beads of `width` (mm), across the seam too."""
    import shapely

    shape, tracks = drawn(region, beads, reach=width)
    if shape.is_empty:
        return Coverage(area=0.0, bare=0.0, once=0.0, more=0.0, outside=0.0)
    if not tracks:
        return Coverage(area=shape.area, bare=shape.area, once=0.0, more=0.0, outside=0.0)
    strips = _strips(tracks, width)
    # bare is what no bead covers, its corners round; more is what strips cover twice, cut flat where a bead goes on
    once = shapely.union_all(np.concatenate([strips, _corners(tracks, width)]))
    first, second = shapely.STRtree(strips).query(strips, predicate="intersects")
    pairs = np.array([(i, j) for i, j in zip(first, second, strict=True) if i < j and not _joined(tracks[i], tracks[j])])
    first, second = pairs.reshape(-1, 2).astype(int).T
    twice = shapely.intersection(strips[first], strips[second])
    bare, more = shape.difference(once).area, shape.intersection(shapely.union_all(twice)).area
    outside = _beyond(once, shape, region.closure, 0.0 if any(p.winds for p in region.pieces) else width)
    return Coverage(area=shape.area, bare=bare, once=shape.area - bare - more, more=more, outside=outside)


def _strips(tracks: list[Track], width: float) -> Array:
    """What each track covers: round at the bead's own ends, flat where the bead goes on."""
    import shapely

    lines = np.array([shapely.LineString(track.points) for track in tracks])
    flat = shapely.buffer(lines, 0.5 * width, quad_segs=QUARTER, cap_style="flat")
    for k in (0, -1):
        own = np.flatnonzero([track.ends[k] for track in tracks])
        tips = shapely.points(np.array([tracks[i].points[k] for i in own]).reshape(-1, 2))
        flat[own] = shapely.union(flat[own], shapely.buffer(tips, 0.5 * width, quad_segs=QUARTER))
    return flat


def _corners(tracks: list[Track], width: float) -> Array:
    """The discs at both ends of every track: where a bead turns, it covers the outside of the corner."""
    import shapely

    ends = shapely.multipoints([shapely.points(track.points[[0, -1]]) for track in tracks])
    return shapely.buffer(ends, 0.5 * width, quad_segs=QUARTER)


def _joined(first: Track, second: Track) -> bool:
    """Whether one track goes on where the other ends: they overlap there for no more than a corner."""
    if first.bead != second.bead:
        return False
    gaps = (first.points[-1] - second.points[0], second.points[-1] - first.points[0])
    return any(float(np.abs(gap).max()) < 1e-6 for gap in gaps)


def _beyond(once, shape, closure: Closure, reach: float) -> float:
    """What is covered outside of the region, once round from `reach` (mm) to the left of it.

    A piece over the seam is drawn on one side of it, its beads on both.
    """
    import shapely

    if closure.is_open:
        return float(once.difference(shape).area)
    start, _ = closure.span_of(shapely.box(*shape.bounds).buffer(reach).bounds)
    around = [closure.motion(turns).shape(shape) for turns in closure.copies_between(shape.bounds, start, start + 1.0)]
    heights = closure.heights_of(shapely.get_coordinates(once))
    window = closure.window(start, start + 1.0, float(heights.min()), float(heights.max()))
    return float(once.intersection(window).difference(shapely.union_all(around)).area)
