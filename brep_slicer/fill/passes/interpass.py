"""No bead beside one that is still hot: an order that gives neighbours time to cool.

In: beads with the time that each takes. Out: the same beads in another order, and how long the worst neighbour had.

Words: *neighbours*, beads that come within 1.5 step-overs of each other; *rest*, the time from a bead's end to the start of a
neighbour.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array

from ..bead import Bead

# Beads nearer to each other than this many step-overs are neighbours.
NEAR = 1.5


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CooledOrder:
    """`beads` in their new order; the `shortest_rest` (s) between neighbours (inf: none); how many are laid `too_soon`."""

    beads: tuple[Bead, ...]
    shortest_rest: float
    too_soon: int


def in_cool_order(beads: Sequence[Bead], *, step_over: float, rest: float, speed: float, travel_speed: float) -> CooledOrder:
    """Lay the nearest bead whose neighbours have all rested for `rest` (s); if there is none, the one that has rested longest.

    `speed` and `travel_speed` in mm/s tell the time; nothing waits.
    """
    if not beads:
        return CooledOrder(beads=(), shortest_rest=float("inf"), too_soon=0)
    near = _neighbours(beads, NEAR * step_over)
    takes = np.array([bead.length() for bead in beads]) / speed
    starts, ends = (np.array([bead.points[k] for bead in beads]) for k in (0, -1))
    finished = np.full(len(beads), -np.inf)
    left = np.ones(len(beads), dtype=bool)
    order: list[int] = []
    here, now, shortest, soon = starts[0], 0.0, np.inf, 0
    while left.any():
        rows = np.flatnonzero(left)
        gap = np.hypot(*(starts[rows] - here).T)
        rested = now + gap / travel_speed - np.array([finished[near[i]].max(initial=-np.inf) for i in rows])
        ready = rested >= rest
        k = int(np.where(ready, gap, np.inf).argmin()) if ready.any() else int(rested.argmax())
        shortest, soon = min(shortest, float(rested[k])), soon + int(not ready[k])
        chosen = int(rows[k])
        order.append(chosen)
        left[chosen] = False
        now += float(gap[k]) / travel_speed + float(takes[chosen])
        finished[chosen], here = now, ends[chosen]
    return CooledOrder(beads=tuple(beads[i] for i in order), shortest_rest=shortest, too_soon=soon)


def _neighbours(beads: Sequence[Bead], reach: float) -> list[Array]:
    """For each bead the numbers of those that come within `reach` (mm) of it."""
    import shapely

    lines = [shapely.LineString(bead.points) for bead in beads]
    pairs = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=reach)
    pairs = pairs[:, pairs[0] != pairs[1]]
    order = np.argsort(pairs[0], kind="stable")
    cuts = np.searchsorted(pairs[0][order], np.arange(1, len(lines)))
    return list(np.split(pairs[1][order], cuts))
