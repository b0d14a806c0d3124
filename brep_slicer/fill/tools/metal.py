"""The metal of beads, as the area that it fills to the layer's thickness.

In: beads, the step-over, the bead's width. Out: areas in mm**2: t times them is the volume.

A bead lays t d per length at the usual speed, more where it is slower, and 3 pi w / 32 of its length more beyond each of its
ends, which are round (`proof.deposit` says why). As in the toolpath, each segment has one speed, the mean of those at its two
points; a round end is laid at the speed of the segment that it ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array

from ..bead import Bead
from .within import Within

# The round end of a bead with a parabola's section holds as much metal as this length of it (in widths): pi / 16 / (2 / 3).
ROUND_END = 3.0 * math.pi / 32.0
# A bead turns sharply by more than this (rad).
SHARP = 0.3
# Beads are told from one another by this much, mm, where they are laid out in a row.
APART = 1e6
# What of a bead lies within its piece is asked this often, in half widths.
SAMPLE = 0.4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Courses:
    """Beads as arrays: where each one's `points` (N, 2) begin (`first`) and end (`last`) among all, the `steps` (N,) from point
    to point (0 after a bead's last), and the lengths that its two round ends hold (`ends`, (n, 2), mm)."""

    points: Array
    first: Array
    last: Array
    steps: Array
    ends: Array

    def metal(self, speed: Array, step_over: float) -> Array:
        """The metal of each bead over t, (n,), mm**2, at speed factors (N,) at all points."""
        amount = amounts_of_segments(speed)
        lengths = np.add.reduceat(self.steps * amount, self.first)
        return step_over * (lengths + self.ends[:, 0] * amount[self.first] + self.ends[:, 1] * amount[self.last - 1])

    def _along(self) -> Array:
        """Where each point lies along its bead, (N,), mm, each bead far behind the one before."""
        before = np.cumsum(self.steps) - self.steps
        far: Array = before + APART * (np.cumsum(np.isin(np.arange(len(before)), self.first)) - 1.0)
        return far

    def _corners(self) -> NDArray[np.intp]:
        """The points at which a bead turns sharply; where one that closes begins and ends, too."""
        way = np.diff(self.points, axis=0)
        way = np.divide(way, self.steps[:-1, None], out=np.zeros_like(way), where=self.steps[:-1, None] > 0.0)
        sharp = np.append(True, np.append(np.einsum("ij,ij->i", way[1:], way[:-1]) < np.cos(SHARP), True))
        sharp[self.first] = sharp[self.last] = self.ends[:, 0] == 0.0
        return np.flatnonzero(sharp)

    def within(self, piece: Within) -> Courses:
        """The same with what of steps and ends lies within a piece's outline."""
        own = np.repeat(np.arange(len(self.first)), self.last - self.first + 1)
        near = ~piece.clears(np.split(self.points, self.first[1:]))
        if not near.any():
            return self
        some = np.flatnonzero((self.steps > 0.0) & near[own])
        cuts = np.ceil(self.steps[some] / (SAMPLE * piece.half)).astype(int)
        of = np.repeat(np.arange(len(some)), cuts)
        share = (np.arange(len(of)) - np.repeat(np.cumsum(cuts) - cuts, cuts) + 0.5) / cuts[of]
        way = self.points[some + 1] - self.points[some]
        along = self._along()
        at = along[some][of] + share * self.steps[some][of]
        corners = along[self._corners()]
        next_one = np.searchsorted(corners, at)
        padded = np.concatenate([[-np.inf], corners, [np.inf]])
        turns = np.minimum(at - padded[next_one], padded[next_one + 1] - at) < piece.half
        ways = (way / self.steps[some][:, None])[of]
        inside = piece.shares(self.points[some][of] + share[:, None] * way[of], ways, turns)
        steps = self.steps.copy()
        steps[some] *= np.bincount(of, weights=inside, minlength=len(some)) / cuts
        ends = self.ends.copy()
        for side, (tip, before) in enumerate(((self.first, self.first + 1), (self.last, self.last - 1))):
            open_ends = np.flatnonzero((ends[:, side] > 0.0) & near)
            out = self.points[tip[open_ends]] - self.points[before[open_ends]]
            length = np.hypot(*out.T)[:, None]
            ends[open_ends, side] *= piece.ends(self.points[tip[open_ends]], out / np.where(length > 0.0, length, 1.0))
        return replace(self, steps=steps, ends=ends)


def amounts_of_segments(speed: Array) -> Array:
    """Metal per length over t d on the way from each point (n,) to the next, by their speed factors; the last point's is 1."""
    return np.append(2.0 / (speed[1:] + speed[:-1]), 1.0)


def courses_of(points: Sequence[Array], closed: Sequence[bool], width: float) -> Courses:
    """The courses of beads through `points`, of which those that are `closed` have no ends."""
    last = np.cumsum([len(p) for p in points]) - 1
    flat = np.concatenate(points)
    steps = np.hypot(*np.diff(flat, axis=0, append=flat[-1:]).T)
    steps[last] = 0.0
    first = np.append(0, last[:-1] + 1)
    ends = np.where(closed, 0.0, ROUND_END * width)
    return Courses(points=flat, first=first, last=last, steps=steps, ends=np.stack([ends, ends], axis=1))


def metal_of(beads: Sequence[Bead], *, step_over: float, width: float, within: Within | None = None) -> Array:
    """The metal of each bead over t, (n,), mm**2; with `within`, what of it lies within a piece's outline."""
    if not beads:
        return np.zeros(0)
    courses = courses_of([bead.points for bead in beads], [bead.closed for bead in beads], width)
    courses = courses if within is None else courses.within(within)
    plain = all(bead.speed is None for bead in beads)
    speed = np.ones(len(courses.steps)) if plain else np.concatenate([_factors(bead) for bead in beads])
    return courses.metal(speed, step_over)


def _factors(bead: Bead) -> Array:
    return np.ones(len(bead.points)) if bead.speed is None else bead.speed
