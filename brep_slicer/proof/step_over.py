"""Step-over between neighbouring beads, measured as geodesics on the points that a toolpath emits.

In: a toolpath, its axis. Out: for each layer the distances from points of beads to the nearest other bead.

A cylinder is developable: the geodesic distance of two of its points is the distance of (R theta, z) in the plane. theta and z
are taken from the emitted x, y, z; nothing of the plan is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.layers import CYLINDERS, Closure, cylinder
from brep_slicer.maps import Array, lengths_along
from brep_slicer.substrate.axis import Axis
from brep_slicer.toolpath import Toolpath

# Along a bead, distances are measured this often (shares of it).
SAMPLES = np.linspace(0.1, 0.9, 9)
# Pairs of places and segments that are worked on at once, and places that a tree is asked for: what bounds the memory.
AT_ONCE, PLACES_AT_ONCE = 1_000_000, 20_000


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StepOver:
    """Distances (n,) in mm from places along beads to the nearest neighbouring bead, where a perpendicular meets one.

    `between` (n, 2) are the numbers of the two beads, as the toolpath has them.
    """

    spacings: Array
    between: NDArray[np.int64]

    @property
    def lowest(self) -> float:
        """The smallest, mm (nan if there is none)."""
        return float(self.spacings.min()) if len(self.spacings) else float("nan")

    @property
    def highest(self) -> float:
        """The largest, mm (nan if there is none)."""
        return float(self.spacings.max()) if len(self.spacings) else float("nan")


def step_over_of(toolpath: Toolpath, axis: Axis, layer: int, *, within: float | None = None) -> StepOver:
    """Measure one layer: from each bead to the nearest other one, or to its own neighbouring turn.

    `within` (mm) leaves out what is farther apart, and is quicker for it.
    """
    mine = (toolpath.layer == layer) & (toolpath.deposits | np.roll(toolpath.deposits & (toolpath.layer == layer), -1))
    points, of = axis.axis_from_file(toolpath.points[mine]), toolpath.bead[mine]
    cuts = np.flatnonzero(np.diff(of)) + 1
    # a single point is no bead
    runs = [(int(run[0]), part) for run, part in zip(np.split(of, cuts), np.split(points, cuts), strict=True) if len(run) > 1]
    if not runs:
        return StepOver(spacings=np.zeros(0), between=np.zeros((0, 2), dtype=np.int64))
    # judged by where the points are, not by what they were meant to be
    sheet = cylinder(float(CYLINDERS.value(runs[0][1]).mean()))
    beads = [sheet.flat_along(part) for _, part in runs]
    numbers = np.array([number for number, _ in runs])
    places = np.concatenate([_places_along(points) for points in beads])
    number = np.repeat(numbers, len(SAMPLES))
    reach = np.inf if within is None else within
    a, b, owner = _copies(beads, sheet.closure, places, reach)
    gaps, nearest = _gaps(places, number, a, b, numbers[owner], within)
    met = np.isfinite(gaps) & (gaps < reach)
    return StepOver(spacings=gaps[met], between=np.stack([number, nearest], axis=1)[met].astype(np.int64))


def _copies(beads: list[Array], closure: Closure, places: Array, reach: float) -> tuple[Array, Array, Array]:
    """From, to (n, 2) and bead (n,) of every segment and its copies whole turns away that come near any of the places."""
    a = np.concatenate([points[:-1] for points in beads])
    b = np.concatenate([points[1:] for points in beads])
    of = np.repeat(np.arange(len(beads)), [len(points) - 1 for points in beads])
    own = np.array([_turns(points, closure) for points in beads])[of]
    low, high = places.min(axis=0) - reach, places.max(axis=0) + reach
    parts = []
    for turns in range(-own.max(), own.max() + 1):
        starts, ends = closure.moved(a, turns), closure.moved(b, turns)
        near = ((np.maximum(starts, ends) >= low) & (np.minimum(starts, ends) <= high)).all(axis=1) & (abs(turns) <= own)
        parts.append((starts[near], ends[near], of[near]))
    starts, ends, owners = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    return starts, ends, owners


def _turns(points: Array, closure: Closure) -> int:
    return 0 if closure.is_open else 1 + int(np.ceil(np.abs(closure.turns_along(points)).max()))


def _places_along(points: Array) -> Array:
    along = lengths_along(points)
    at = SAMPLES * along[-1]
    return np.stack([np.interp(at, along, points[:, k]) for k in (0, 1)], axis=1)


def _gaps(places: Array, number: Array, a: Array, b: Array, owner: Array, within: float | None) -> tuple[Array, Array]:
    """Distance (n,) from each place to the nearest segment of another bead that a perpendicular meets (else inf), and whose."""
    import shapely

    best, whose = np.full(len(places), np.inf), np.full(len(places), np.iinfo(np.int64).max)
    tree = None if within is None else shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))
    step = max(1, AT_ONCE // max(1, len(a))) if tree is None else PLACES_AT_ONCE
    for first in range(0, len(places), step):
        part = np.arange(first, min(first + step, len(places)))
        if tree is None:
            which, segment = np.repeat(part, len(a)), np.tile(np.arange(len(a)), len(part))
        else:
            # the tree's word on a distance is rounded
            which, segment = tree.query(shapely.points(places[part]), predicate="dwithin", distance=1.000001 * (within or 0.0))
            which = part[which]
        d, off = (b - a)[segment], places[which] - a[segment]
        share = np.einsum("ij,ij->i", off, d) / np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
        gap = np.hypot(*(off - np.clip(share, 0.0, 1.0)[:, None] * d).T)
        # a foot at a bead's end is no perpendicular; joints between a bead's own segments are none either
        square = (share >= -1e-9) & (share <= 1.0 + 1e-9) & ((owner[segment] != number[which]) | (gap > 1e-3))
        which, gap, of = which[square], gap[square], owner[segment[square]]
        np.minimum.at(best, which, gap)
        # of beads as near as each other the first
        nearest = gap == best[which]
        np.minimum.at(whose, which[nearest], of[nearest])
    return best, whose
