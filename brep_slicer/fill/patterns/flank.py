"""Flank-following beads: parallel to the long edges of a piece, as the paper's experiment laid them.

In: an area. Out: hatch beads in the direction of the piece's flanks: kappa = const on a spur tooth, the helix on a helical one.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from brep_slicer.errors import InputError
from brep_slicer.maps import Array, lengths_along
from brep_slicer.process.parameter import parameter
from brep_slicer.region import Piece

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.inset import inset_piece, parts_of
from ..tools.metal import ROUND_END
from ..tools.parallel import ParallelLines
from .skeleton import Skeleton

# Two flanks are parallel when their directions differ by less than this (rad).
PARALLEL = 1e-6

# Flanks are followed by so many points.
SAMPLES = 257
# An outline has a corner where it turns by more than this at a point.
CORNER = math.radians(30.0)
# A stretch whose ends are nearer to each other than this share of its length goes round something.
HARDLY_BENT = 0.85


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class FlankFollowing(Pattern):
    """Beads along the flanks, found from the section's own two longest edges; `both_ways` as in a hatch.

    Where the flanks are not parallel, the beads pass over from the one to the other, evenly spaced between `closest` and
    `widest` times the step-over: where they would come nearer, all but those along the flanks end, and fewer go on. Beads along
    the skeleton fill what stays bare, as at the tips of a blade.
    """

    name: ClassVar[str] = "flank"
    help: ClassVar[str] = "lines along the piece's two long edges, as the flanks of a tooth"
    turns_along: ClassVar[bool] = True

    both_ways: bool = parameter(True, options=("--both-ways/--one-way",), help="Every second line is laid backwards")
    closest: float = parameter(
        0.75, above=0.0, most=1.0, help="Where flanks come nearer, beads are so many times the step-over apart at least"
    )
    widest: float = parameter(1.25, least=1.0, help="And so many times at most, 1.5 times the closest at least")

    def __post_init__(self) -> None:
        Pattern.__post_init__(self)
        if self.widest < 1.5 * self.closest:
            raise InputError(
                f"widest is {self.widest:g} and closest {self.closest:g}; widest must be 1.5 times closest at least"
            )

    def fill(self, area: FillArea) -> AreaFill:
        angle, spread = flank_direction(area.piece)
        if not area.piece.winds and (spread > PARALLEL or not _straight(area.piece)):
            return self._passing_over(area, angle)
        made = ParallelLines(angle=angle, both_ways=self.both_ways).fill(area)
        beads = tuple(replace(b, kind=BeadKind.FLANK) for b in made.beads)
        return replace(made, beads=beads)

    def _passing_over(self, area: FillArea, angle: float) -> AreaFill:
        inset = inset_piece(area.piece, area.inset, chord=area.chord)
        beads: list[Bead] = []
        changes = 0
        for room in inset.polygons:
            first, second = _flanks(np.asarray(room.exterior.coords), angle)
            # the outermost beads run along its border; it lies inside of where they may be by the slack
            room = room.buffer(0.1 * inset.slack)
            zones = _zones(_gaps(np.hypot(*(second - first).T) / area.step_over, self.closest, self.widest))
            changes += len(zones) - 1
            for j, line in enumerate(_lines(first, second, zones, area.width)):
                found = [
                    np.asarray(p.coords) for p in parts_of(line.intersection(room), "LineString") if p.length > area.step_over
                ]
                back = self.both_ways and j % 2 == 1
                beads += [Bead(points=p[::-1] if back else p, kind=BeadKind.FLANK, piece=area.index) for p in found]
        beads += Skeleton().fill(replace(area, laid=(*area.laid, *beads))).beads
        notes = ("beads end and fewer go on where its flanks come nearer",) if changes else ()
        return AreaFill(beads=tuple(beads), inset=area.inset, angle=angle, step_over=area.step_over, notes=notes)


def _lines(first: Array, second: Array, zones: list[tuple[int, int, int]], width: float) -> list:
    """Lines from one flank to the other: along both flanks as far as there is room for two, and those that pass over between.

    Each zone has so many spacings; a line that ends at another zone is shortened there by what its round end lays beyond it.
    """
    whole: list[tuple[int, int]] = []
    inner: list[tuple[int, int, float]] = []
    for begin, end, gaps in zones:
        if gaps == 0:
            inner.append((begin, end, 0.5))
            continue
        inner += [(begin, end, j / gaps) for j in range(1, gaps)]
        whole = [*whole[:-1], (whole[-1][0], end)] if whole and whole[-1][1] == begin else [*whole, (begin, end)]
    runs = [(a, b, 0.0) for a, b in whole] + sorted(inner, key=lambda run: run[2]) + [(a, b, 1.0) for a, b in whole]
    last = len(first) - 1
    return [
        _without_ends((1.0 - share) * first[a : b + 1] + share * second[a : b + 1], (a > 0, b < last), width)
        for a, b, share in runs
    ]


def _without_ends(points: Array, cuts: tuple[bool, bool], width: float):
    """A line shorter at the ends where other beads begin, by what the round end of a bead lays beyond it."""
    from shapely import LineString
    from shapely.ops import substring

    line = LineString(points)
    return substring(line, cuts[0] * ROUND_END * width, max(line.length - cuts[1] * ROUND_END * width, 0.0))


def _straight(piece: Piece) -> bool:
    """Whether a piece's two longest edges are straight lines."""
    curves = [curve for loop in piece.outer for curve in loop.curves]
    longest = sorted(curves, key=lambda c: c.length())[-2:]
    return all(c.length() - math.dist(c.start, c.end) <= PARALLEL**2 * c.length() for c in longest)


def _flanks(ring: Array, angle: float) -> tuple[Array, Array]:
    """The two flanks of a closed ring, (SAMPLES, 2) each, evenly along them and both run in the direction `angle`.

    They are its two longest stretches between corners, if those lie opposite; else, as on a blade, which has its corners at its
    tips or none, the two ways from one of the two places that are farthest apart to the other.
    """
    ring = ring[:-1] if np.array_equal(ring[0], ring[-1]) else ring
    corners = np.flatnonzero(np.abs(_turns(ring)) > CORNER)
    sides = _cut(ring, corners) if len(corners) > 1 else []
    longest = sorted(sides, key=lambda p: float(lengths_along(p)[-1]))[-2:]
    if not _opposite(longest):
        hull = np.unique(_hull(ring))
        apart = np.linalg.norm(ring[hull][:, None] - ring[hull][None], axis=2)
        longest = _cut(ring, np.sort(hull[list(np.unravel_index(apart.argmax(), apart.shape))]))
    forward = [float((p[-1] - p[0]) @ (math.cos(angle), math.sin(angle))) for p in longest]
    first, second = (_evenly(longest[i]) for i in ((0, 1) if forward[0] > forward[1] else (1, 0)))
    return first, second[::-1]


def _turns(ring: Array) -> Array:
    """By how much a closed ring turns at each of its points, rad."""
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    return np.arctan2(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0], (before * after).sum(axis=1))


def _cut(ring: Array, places: Array) -> list[Array]:
    """The stretches of a closed ring between some of its points."""
    turned = np.roll(ring, -int(places[0]), axis=0)
    chain = np.concatenate([turned, turned[:1]])
    marks = [*(places - places[0]).tolist(), len(ring)]
    return [chain[a : b + 1] for a, b in itertools.pairwise(marks)]


def _opposite(sides: list[Array]) -> bool:
    """Whether two stretches of a ring, each hardly bent and none much shorter, run against each other."""
    if len(sides) < 2:
        return False
    chords = np.array([p[-1] - p[0] for p in sides])
    spans, lengths = np.hypot(*chords.T), np.array([lengths_along(p)[-1] for p in sides])
    bent = (spans < HARDLY_BENT * lengths).any()
    return not bent and lengths[0] > 0.5 * lengths[1] and float(chords[0] @ chords[1]) < -0.5 * float(spans.prod())


def _hull(ring: Array) -> NDArray[np.int64]:
    from scipy.spatial import ConvexHull

    return np.asarray(ConvexHull(ring).vertices, dtype=np.int64)


def _evenly(points: Array) -> Array:
    along = lengths_along(points)
    at = np.linspace(0.0, along[-1], SAMPLES)
    return np.stack([np.interp(at, along, points[:, k]) for k in (0, 1)], axis=1)


def _gaps(width: Array, closest: float, widest: float) -> NDArray[np.int64]:
    """How many spacings each place along the flanks has (width in step-overs): changed as seldom as the bounds allow."""
    out, begin = np.zeros(len(width), dtype=np.int64), 0
    while begin < len(width):
        now = float(width[begin])
        best, reach = 0, begin + 1
        for n in range(max(1, math.ceil(now / widest)), math.floor(now / closest) + 1):
            kept = (width[begin:] >= closest * n) & (width[begin:] <= widest * n)
            end = begin + (len(kept) if kept.all() else int(kept.argmin()))
            if (end, -abs(now - n)) > (reach, -abs(now - best)):
                best, reach = n, end
        out[begin:reach] = best
        begin = reach
    return out


def _zones(gaps: NDArray[np.int64]) -> list[tuple[int, int, int]]:
    """(first row, last row, spacings) of stretches with the same number of spacings; neighbours share a row."""
    cuts = [0, *(np.flatnonzero(np.diff(gaps)) + 1).tolist(), len(gaps) - 1]
    return [(a, b, int(gaps[a])) for a, b in itertools.pairwise(cuts) if b > a]


def flank_direction(piece: Piece) -> tuple[float, float]:
    """Direction (rad, in (-pi/2, pi/2]) of a piece's two longest edges, and the angle between the two (rad)."""
    curves = [curve for loop in piece.outer for curve in loop.curves]
    lengths = [curve.length() for curve in curves]
    longest = np.argsort(lengths)[::-1][:2]
    angles = []
    for i in longest:
        along = curves[int(i)].end - curves[int(i)].start
        angles.append(math.atan2(along[1], along[0]))
    # directions of lines, not of arrows: the mean is taken on the doubled angles
    doubled = [complex(math.cos(2.0 * a), math.sin(2.0 * a)) for a in angles]
    mean = 0.5 * math.atan2(sum(doubled).imag, sum(doubled).real)
    spread = abs(math.remainder(angles[0] - angles[-1], math.pi))
    return (mean if mean > -0.5 * math.pi + 1e-15 else 0.5 * math.pi), spread
