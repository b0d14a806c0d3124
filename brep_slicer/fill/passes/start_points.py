"""Closed beads: where they start, and how far they overlap themselves.

In: the beads of a layer. Out: the same beads with closed ones turned to another start and prolonged.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from brep_slicer.maps import Array, lengths_along

from ..bead import Bead

# Starts that are to be spread follow one another by this share of the ring: the golden section never repeats itself.
GOLDEN = 0.5 * (5.0**0.5 - 1.0)


def with_spread_starts(beads: Sequence[Bead], layer: int) -> tuple[Bead, ...]:
    """Closed rings start at other places from ring to ring and from layer to layer, so that no seam builds up."""
    return tuple(
        replace(bead, points=_from(bead.points, ((layer + i) * GOLDEN) % 1.0)) if _is_ring(bead) else bead
        for i, bead in enumerate(beads)
    )


def with_overlap(beads: Sequence[Bead], length: float) -> tuple[Bead, ...]:
    """Closed beads go on over their own start by `length` (mm)."""
    return tuple(_prolonged(bead, length) if bead.closed and length > 0.0 else bead for bead in beads)


def _is_ring(bead: Bead) -> bool:
    return bead.closed and bead.speed is None


def _from(points: Array, share: float) -> Array:
    along = lengths_along(points)
    at = share * along[-1]
    first = np.array([[np.interp(at, along, points[:, k]) for k in (0, 1)]])
    after = int(np.searchsorted(along, at, side="right"))
    # round the shaft the end lies whole turns from the start
    turns = points[-1] - points[0]
    return np.concatenate([first, points[after:-1], points[:after] + turns, first + turns])


def _prolonged(bead: Bead, length: float) -> Bead:
    points = bead.points
    along = lengths_along(points)
    length = min(length, 0.5 * float(along[-1]))
    more = int(np.searchsorted(along, length))
    shift = points[-1] - points[0]
    last = np.array([[np.interp(length, along, points[:, k]) for k in (0, 1)]])
    speed = None if bead.speed is None else np.concatenate([bead.speed, bead.speed[1 : more + 1]])
    return replace(bead, points=np.concatenate([points, points[1:more] + shift, last + shift]), speed=speed)
