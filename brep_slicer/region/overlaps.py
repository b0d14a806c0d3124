"""A section that lies over itself: a thread wider than its pitch, a solid whose faces run through one another.

In: a region. Out: how much of its area is counted more than once.

An engine cannot tell: each curve is where face and cylinder meet, and all of them close. It is a fault of the solid.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.layers import Closure

from .region import Region


def overlapping_area(region: Region, *, chord: float = 0.01) -> float:
    """By how much the area differs from that of the pieces' union round the shaft, mm**2; 0 below what `chord` (mm) tells."""
    import shapely

    if region.is_empty:
        return 0.0
    drawn = list(region.to_shapely(chord=chord).geoms)
    sound = bool(shapely.is_valid(drawn).all())
    closure = region.closure
    if sound and not _meets_itself(drawn, closure):
        return 0.0
    heights = closure.heights_of(shapely.get_coordinates(drawn))
    turn = closure.window(-0.5, 0.5, float(heights.min()) - 1.0, float(heights.max()) + 1.0)
    copies = []
    for polygon in drawn if sound else shapely.make_valid(drawn):
        for k in closure.copies_between(polygon.bounds, -0.5, 0.5):
            copies.append(closure.motion(k).shape(polygon).intersection(turn))
    excess = abs(region.area - float(shapely.union_all(copies).area))
    return excess if excess > 2.0 * chord * region.length else 0.0


def _meets_itself(drawn: list, closure: Closure) -> bool:
    """Whether polygons meet one another, or those wider than a turn themselves, a turn on."""
    import shapely

    turns = closure.beside
    copies = np.concatenate([closure.motion(k).shape(np.array(drawn)) for k in turns])
    one, other = shapely.STRtree(copies).query(drawn, predicate="intersects")
    if (one != other % len(drawn)).any():
        return True
    moved = one[np.array(turns)[other // len(drawn)] != 0]
    # a band's chart is a turn wide and ends where it begins
    return any(np.ptp(closure.turns_along(np.asarray(drawn[i].exterior.coords))) > 1.0 + 1e-9 for i in np.unique(moved))
