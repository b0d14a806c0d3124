"""What building on one cylinder would mean: which metal it carries, and which it would leave out.

In: a Survey and a radius with its land. Out: a Ground.

Words: *through*, metal of one solid that goes on from inside of the radius to outside; *foot*, through metal that is one patch
on the cylinder; *cover*, another solid's metal that lies on the land; *place*, neighbouring stations that hold land;
*shoulder*, a foot that goes all the way round and has land on one side at most: a collar, a flange.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brep_slicer.groups import groups_of_pairs
from brep_slicer.maps import Array

from .lands import beyond
from .survey import COLUMNS, SAG, TURNED, Survey, connected_stretches

# A groove of no more than this depth (share of the radius) beside a foot is a relief, as for a grinding wheel.
RELIEF = 0.1
# A shoulder's metal is turned when no more than this share of it is loose (see Survey.loose_below).
LOOSE_SHARE = 0.1
# ... and it reaches this share of its height all round.
RIM = 0.9
# Land goes round at one place when no gap between its rays is wider than this share of a turn.
WIDEST_GAP = 0.15
# ... and what stands on it does when no gap is wider than this: two lobes are half a turn apart, a lug on a flange a whole one.
WIDEST_BETWEEN = 0.55


@dataclass(frozen=True, kw_only=True, eq=False)
class Ground:
    """What stands on `radius` (mm), whose land are the `faces`, (place of the solid, face), outside (or in a bore)."""

    survey: Survey
    radius: float
    faces: frozenset[tuple[int, int]]
    external: bool

    @property
    def _margin(self) -> float:
        return max(beyond(self.radius), SAG * self.radius)

    def _map(self, rays: Array) -> Array:
        flags = np.zeros(self.survey.shape[0] * COLUMNS, dtype=bool)
        flags[rays] = True
        return flags.reshape(self.survey.shape)

    @cached_property
    def on_land(self) -> Array:
        """(stretches,) that end on the land, or start from it in a bore."""
        s = self.survey.stretches
        return flagged(s.solid, s.last if self.external else s.first, self.faces)

    @cached_property
    def above(self) -> Array:
        """(stretches,) that reach beyond the radius."""
        return (self.survey.stretches.end > self.radius + self._margin) & ~(self.external & self.on_land)

    @cached_property
    def land(self) -> Array:
        """(stations, columns) where the land is."""
        return self._map(self.survey.stretches.ray[self.on_land])

    @cached_property
    def through(self) -> Array:
        """(stretches,) of metal that goes on through the radius."""
        s = self.survey.stretches
        return self.above & (s.start < self.radius - beyond(self.radius)) & ~((not self.external) & self.on_land)

    @cached_property
    def covers(self) -> Array:
        """(stretches,) of other solids that lie on the land, or reach into it."""
        s = self.survey.stretches
        if not self.external:
            return self.on_land
        under = np.full(len(self.survey.weights), -1)
        under[s.ray[self.on_land]] = s.solid[self.on_land]
        other = (under[s.ray] >= 0) & (under[s.ray] != s.solid) & self.survey.touching[under[s.ray], s.solid]
        return self.above & (s.start <= self.radius + self._margin) & other

    @cached_property
    def feet(self) -> tuple[Array, Array]:
        """(stations, columns) the number of the foot there, 0 for none; (feet + 1,) whether land is beside it."""
        number = labelled(self._map(self.survey.stretches.ray[self.through]))
        return number, self._beside_land(number)

    @cached_property
    def _bridged(self) -> Array:
        """The land with the reliefs and roundings beside it, which part it from what stands on it."""
        s = self.survey.stretches
        low, high = (1.0 - RELIEF) * self.radius, self.radius + self._margin
        groove = self._map(s.ray[(s.end >= low) & (s.end <= high)]) & ~self.land
        number = labelled(groove)
        size = np.bincount(number.ravel())
        beside = touching(number, self.land) & (size < int(self.land.sum()))
        beside[0] = False
        return self.land | beside[number]

    def _beside_land(self, number: Array) -> Array:
        return touching(number, self._bridged)

    @cached_property
    def carried(self) -> Array:
        """(stretches,) of metal beyond the radius that the land carries: connected to a foot beside it, or to a cover."""
        s = self.survey.stretches
        number, beside = self.feet
        beside = beside.copy()
        beside[0] = False
        roots = self.covers | (self.through & beside[number.ravel()[s.ray]])
        return self.reached(roots)

    @cached_property
    def pieces(self) -> Array:
        """(stretches,) the number of the connected metal beyond the radius, -1 inside."""
        return connected(self.survey, self.above, self.radius)

    def reached(self, roots: Array) -> Array:
        """(stretches,) of metal beyond the radius that is connected to flagged stretches."""
        known = np.unique(self.pieces[roots & self.above])
        return self.above & np.isin(self.pieces, known)

    def volume(self, flags: Array) -> float:
        """mm**3 beyond the radius of flagged stretches."""
        return float(self.survey.stretches.chosen(flags).volumes(self.survey.weights, inner=self.radius).sum())

    @cached_property
    def left_out(self) -> float:
        """mm**3 that building on it would lose: features inside of it, and those beyond it that it does not carry."""
        survey = self.survey
        inside = survey.loose_below(self.radius)
        if not self.external:
            inside = float(survey.stretches.volumes(survey.weights, outer=self.radius).sum())
        lost = survey.stretches.chosen(self.above & ~self.carried)
        return inside + float(survey.loose_volumes(lost, inner=self.radius).sum())

    def stock(self, radius: float) -> float:
        """mm**3 of turned metal between this land and a larger radius that stands on it all the way round: collars, the
        thicker part of a shaft; not a rim that hangs on spokes."""
        s = self.survey.stretches
        rows: Array = np.all(self.feet[0] > 0, axis=1)
        metal = s.chosen(self.through & rows[s.ray // COLUMNS])
        metal = replace(metal, start=np.maximum(metal.start, self.radius), end=np.minimum(metal.end, radius))
        metal = metal.chosen(metal.end > metal.start)
        loose = self.survey.loose_volumes(metal, inner=self.radius)
        return float((metal.volumes(self.survey.weights) - loose).sum())

    @cached_property
    def turned_only(self) -> bool:
        """Whether what the land carries is turned: collars, flanges, steps."""
        loose = self.survey.loose_volumes(self.survey.stretches.chosen(self.carried), inner=self.radius)
        return bool(loose.sum() <= LOOSE_SHARE * self.volume(self.carried))

    @cached_property
    def places(self) -> list[tuple[float, bool]]:
        """For each place: the area (mm**2) of land and feet there, and whether both the land and what stands on it go round."""
        holds: Array = np.any(self.land, axis=1)
        ground = self.land | (self.feet[0] > 0)
        out = []
        for first, last in runs(holds):
            area = self.radius * self.survey.weights.reshape(self.survey.shape)[first:last][ground[first:last]].sum()
            stands = self._map(self.survey.stretches.ray[self.carried])[first:last]
            goes_round = _widest_gap(self.land[first:last]) <= WIDEST_GAP and _widest_gap(stands) <= WIDEST_BETWEEN
            out.append((float(area), goes_round))
        return out

    def shoulders(self, solids: Iterable[int], *, turned: bool = True) -> list[tuple[int, int]]:
        """Stations (first, past the last) of feet of some solids (their places in the part) that stand.

        Such feet are metal all the way round, with land on one side at most, and what they carry is `turned`, if that is asked.
        """
        s = self.survey.stretches
        through = self.through & np.isin(s.solid, list(solids))
        number = labelled(self._map(s.ray[through]))
        out = []
        bridged: Array = np.any(self._bridged, axis=1)
        for foot in range(1, int(number.max(initial=0)) + 1):
            here = number == foot
            rows = np.flatnonzero(here.any(axis=1))
            first, last = int(rows[0]), int(rows[-1]) + 1
            full = here.all(axis=1)
            # what is not turned has to close the turn where it meets the land
            met = [
                row for row, beside in ((first, first - 1), (last - 1, last)) if 0 <= beside < len(bridged) and bridged[beside]
            ]
            if not full[rows if turned else met].all():
                continue
            if len(met) < 2 and (not turned or self._is_turned(through & here.ravel()[s.ray])):
                out.append((first, last))
        return out

    def _is_turned(self, roots: Array) -> bool:
        """Whether metal is turned, and out to its rim: teeth on a disc are little of it, a flange's holes as much."""
        metal = self.survey.stretches.chosen(roots)
        whole = float(metal.volumes(self.survey.weights, inner=self.radius).sum())
        if float(self.survey.loose_volumes(metal, inner=self.radius).sum()) > LOOSE_SHARE * whole:
            return False
        rim = np.zeros(COLUMNS)
        np.maximum.at(rim, metal.ray % COLUMNS, metal.end)
        return bool((rim >= self.radius + RIM * (rim.max() - self.radius)).mean() >= TURNED)


def _widest_gap(flags: Array) -> float:
    """The widest gap between the columns of flagged rays, as a share of a turn; 1 where there are none."""
    angles = np.flatnonzero(np.any(flags, axis=0))
    if not len(angles):
        return 1.0
    return float(np.diff(np.append(angles, angles[0] + COLUMNS)).max()) / COLUMNS


def flagged(solid: Array, face: Array, faces: Iterable[tuple[int, int]]) -> Array:
    """Whether each (solid, face) is one of `faces`."""
    wide = int(face.max(initial=0)) + 2
    return np.isin(solid * wide + face, [place * wide + number for place, number in faces])


def runs(flags: Array) -> list[tuple[int, int]]:
    """(first, past the last) of every run of flags."""
    change = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in zip(change[::2], change[1::2], strict=True)]


def labelled(flags: Array) -> Array:
    """Connected patches of a map, numbered from 1, across the seam too; 0 elsewhere."""
    cell = np.cumsum(flags.ravel()).reshape(flags.shape) - 1
    beside = np.roll(flags, -1, axis=1) & flags
    above = flags[1:] & flags[:-1]
    a = np.concatenate([cell[beside], cell[:-1][above]])
    b = np.concatenate([np.roll(cell, -1, axis=1)[beside], cell[1:][above]])
    out = np.zeros(flags.shape, dtype=int)
    out[flags] = groups_of_pairs(int(flags.sum()), np.stack([a, b], axis=1)) + 1
    return out


def touching(number: Array, flags: Array) -> Array:
    """For each number of a map of patches, whether a flagged ray is beside one of its rays."""
    beside = np.zeros(int(number.max(initial=0)) + 1, dtype=bool)
    for shifted in (np.roll(flags, 1, axis=1), np.roll(flags, -1, axis=1)):
        beside[number[shifted]] = True
    beside[number[1:][flags[:-1]]] = True
    beside[number[:-1][flags[1:]]] = True
    return beside


def connected(survey: Survey, flags: Array, radius: float) -> Array:
    """(stretches,) the number of the connected metal beyond a radius that each flagged stretch belongs to, -1 for others."""
    chosen = survey.stretches.chosen(flags)
    beyond_it = replace(chosen, start=np.maximum(chosen.start, radius))
    out = np.full(len(flags), -1)
    out[flags] = connected_stretches(survey, beyond_it, slack=SAG * radius + beyond(radius))
    return out
