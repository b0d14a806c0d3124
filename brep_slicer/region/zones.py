"""A region without what stands in rings round the axis: collars and flanges that are not to be built.

In: a Region, heights between which metal stands. Out: the Region of the rest.
"""

from __future__ import annotations

from collections.abc import Sequence

from brep_slicer.curves import LineCurve, Loop

from .overlay import difference_of_regions, union_of_regions
from .region import Region, region_from_loops

# A piece with this share of its length along the axis in a zone stands as a whole, one with less than the rest is built as a
# whole: heights of zones are good to half a thousandth of the part's length.
WHOLLY = 0.9


def outside_of_zones(region: Region, zones: Sequence[tuple[float, float]]) -> Region:
    """What of a region lies outside of the zones, each (low, high) in v, mm; a piece that reaches out of one is cut there.

    Raises
    ------
    LayerError
        If a piece cannot be cut at a zone's edge.
    """
    for low, high in zones:
        kept, cut = [], []
        for piece in region.pieces:
            _, v0, _, v1 = piece.bounds()
            share = (min(v1, high) - max(v0, low)) / max(v1 - v0, 1e-300)
            if share <= 1.0 - WHOLLY:
                kept.append(piece)
            elif share < WHOLLY:
                cut.append(piece)
        rest = Region(radius=region.radius, pieces=tuple(kept), touch=region.touch)
        if cut:
            parted = difference_of_regions(Region(radius=region.radius, pieces=tuple(cut)), _ring(region.radius, low, high))
            rest = union_of_regions(region.radius, [rest, parted])
        region = rest
    return region


def _ring(radius: float, low: float, high: float) -> Region:
    """The whole turn between two heights."""
    turn = Region(radius=radius).period
    below = Loop(curves=(LineCurve.between((0.0, low), (turn, low)),), radius=radius, winding=1)
    above = Loop(curves=(LineCurve.between((turn, high), (0.0, high)),), radius=radius, winding=-1)
    return region_from_loops(radius, [below, above])
