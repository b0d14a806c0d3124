"""The metal of beads, as the area that it fills to the layer's thickness.

In: beads, the step-over, the bead's width. Out: areas in mm**2: t times them is the volume.

A bead lays t d per length at the usual speed, more where it is slower, and 3 pi w / 32 of its length more beyond each of its
ends, which are round (`proof.deposit` says why).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from brep_slicer.maps import Array

from .bead import Bead

# The round end of a bead with a parabola's section holds as much metal as this length of it (in widths): pi / 16 / (2 / 3).
ROUND_END = 3.0 * math.pi / 32.0


def metal_of(beads: Sequence[Bead], *, step_over: float, width: float) -> Array:
    """The metal of each bead over t, (n,), mm**2."""
    if not beads:
        return np.zeros(0)
    counts = np.array([len(bead.points) for bead in beads])
    points = np.concatenate([bead.points for bead in beads])
    plain = all(bead.speed is None for bead in beads)
    speed = np.ones(len(points)) if plain else np.concatenate([_factors(bead) for bead in beads])
    last = np.cumsum(counts) - 1
    first = last - counts + 1
    steps = np.hypot(*np.diff(points, axis=0, append=points[-1:]).T)
    # the toolpath lays a segment at the mean of the speeds at its ends
    mean = 0.5 * (speed + np.append(speed[1:], speed[-1]))
    share = steps / mean
    share[last] = 0.0
    lengths = np.add.reduceat(share, first)
    ends = np.where([bead.closed for bead in beads], 0.0, ROUND_END * width * (1.0 / speed[first] + 1.0 / speed[last]))
    return step_over * (lengths + ends)


def _factors(bead: Bead) -> Array:
    return np.ones(len(bead.points)) if bead.speed is None else bead.speed
