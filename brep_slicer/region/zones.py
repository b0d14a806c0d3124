"""A region without what stands in rings round the axis: collars and flanges that are not to be built.

In: a Region, heights between which metal stands. Out: the Region of the rest.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.layers import Sheet

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
        rest = Region(sheet=region.sheet, pieces=tuple(kept), touch=region.touch)
        if cut:
            parted = difference_of_regions(Region(sheet=region.sheet, pieces=tuple(cut)), _ring(region.sheet, low, high))
            rest = union_of_regions(region.sheet, [rest, parted])
        region = rest
    return region


def _ring(sheet: Sheet, low: float, high: float) -> Region:
    """The whole turn between two heights."""
    below, above = (
        LineCurve(p0=start, p1=sheet.closure.moved(start, 1)) for start in (np.array([0.0, height]) for height in (low, high))
    )
    loops = [Loop(curves=(below,), sheet=sheet, winding=1), Loop(curves=(above.reversed(),), sheet=sheet, winding=-1)]
    return region_from_loops(sheet, loops)
