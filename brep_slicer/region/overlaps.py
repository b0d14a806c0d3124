"""A section that lies over itself: a thread wider than its pitch, a solid whose faces run through one another.

In: a region. Out: how much of its area is counted more than once.

An engine cannot tell: each curve is where face and cylinder meet, and all of them close. It is a fault of the solid.
"""

from __future__ import annotations

import numpy as np

from .region import Region


def overlapping_area(region: Region, *, chord: float = 0.01) -> float:
    """By how much the area differs from that of the pieces' union round the shaft, mm**2; 0 below what `chord` (mm) tells."""
    import shapely
    import shapely.affinity

    if region.is_empty:
        return 0.0
    drawn = list(region.to_shapely(chord=chord).geoms)
    sound = bool(shapely.is_valid(drawn).all())
    if sound and not _meets_itself(drawn, region.period):
        return 0.0
    half = 0.5 * region.period
    low, high = min(p.bounds[1] for p in drawn) - 1.0, max(p.bounds[3] for p in drawn) + 1.0
    turn = shapely.box(-half, low, half, high)
    lifts = []
    for polygon in drawn if sound else shapely.make_valid(drawn):
        k0, _, k1, _ = polygon.bounds
        for k in range(int(np.floor((k0 + half) / region.period)), int(np.floor((k1 + half) / region.period)) + 1):
            lifts.append(shapely.affinity.translate(polygon, -k * region.period).intersection(turn))
    excess = abs(region.area - float(shapely.union_all(lifts).area))
    return excess if excess > 2.0 * chord * region.length else 0.0


def _meets_itself(drawn: list, period: float) -> bool:
    """Whether polygons meet one another, or those wider than a turn themselves, a turn on."""
    import shapely

    lifts = np.array([shapely.affinity.translate(polygon, k * period) for k in (-1, 0, 1) for polygon in drawn])
    one, other = shapely.STRtree(lifts).query(drawn, predicate="intersects")
    widths = np.diff(shapely.bounds(drawn)[:, ::2], axis=1)[:, 0]
    # a band's chart is a turn wide and ends where it begins
    return bool(np.any((one != other % len(drawn)) | ((other // len(drawn) != 1) & (widths[one] > period * (1.0 + 1e-9)))))
