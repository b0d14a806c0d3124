"""The metal of beads, as the area that it fills to the layer's thickness.

In: beads, the step-over, the bead's width. Out: areas in mm**2: t times them is the volume.

A bead lays t d per length at the usual speed, more where it is slower, and 3 pi w / 32 of its length more beyond each of its
ends, which are round (`proof.deposit` says why).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array

from .bead import Bead

# The round end of a bead with a parabola's section holds as much metal as this length of it (in widths): pi / 16 / (2 / 3).
ROUND_END = 3.0 * math.pi / 32.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Courses:
    """Beads as arrays: where each one's points begin (`first`) and end (`last`) among all, the `steps` (N,) from point to point
    (0 after a bead's last), and the length that its two round ends hold each (`ends`, mm)."""

    first: Array
    last: Array
    steps: Array
    ends: Array

    def metal(self, speed: Array, step_over: float) -> Array:
        """The metal of each bead over t, (n,), mm**2, at speed factors (N,) at all points."""
        # the toolpath lays a segment at the mean of the speeds at its ends
        mean = 0.5 * (speed + np.append(speed[1:], speed[-1]))
        lengths = np.add.reduceat(self.steps / mean, self.first)
        return step_over * (lengths + self.ends * (1.0 / speed[self.first] + 1.0 / speed[self.last]))


def courses_of(points: Sequence[Array], closed: Sequence[bool], width: float) -> Courses:
    """The courses of beads through `points`, of which those that are `closed` have no ends."""
    last = np.cumsum([len(p) for p in points]) - 1
    flat = np.concatenate(points)
    steps = np.hypot(*np.diff(flat, axis=0, append=flat[-1:]).T)
    steps[last] = 0.0
    first = np.append(0, last[:-1] + 1)
    return Courses(first=first, last=last, steps=steps, ends=np.where(closed, 0.0, ROUND_END * width))


def metal_of(beads: Sequence[Bead], *, step_over: float, width: float) -> Array:
    """The metal of each bead over t, (n,), mm**2."""
    if not beads:
        return np.zeros(0)
    courses = courses_of([bead.points for bead in beads], [bead.closed for bead in beads], width)
    plain = all(bead.speed is None for bead in beads)
    speed = np.ones(len(courses.steps)) if plain else np.concatenate([_factors(bead) for bead in beads])
    return courses.metal(speed, step_over)


def _factors(bead: Bead) -> Array:
    return np.ones(len(bead.points)) if bead.speed is None else bead.speed
