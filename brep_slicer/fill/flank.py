"""Flank-following beads: parallel to the long edges of a piece, as the paper's experiment laid them.

In: a cell. Out: hatch beads in the direction of the piece's flanks: kappa = const on a spur tooth, the helix on a helical one.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array
from brep_slicer.region import Piece

from .bead import Bead, BeadKind
from .hatch import Hatch
from .inset import inset_piece, parts_of
from .pattern import Cell, CellFill, Pattern

# Two flanks are parallel when their directions differ by less than this (rad).
PARALLEL = 1e-6


# The round end of a bead with a parabola's section holds as much metal as this length of it (in widths): pi / 16 / (2 / 3).
ROUND_END = 3.0 * math.pi / 32.0
# Flanks are followed by so many points.
SAMPLES = 129


@dataclass(frozen=True, slots=True, kw_only=True)
class FlankFollowing(Pattern):
    """Beads along the flanks, found from the section's own two longest edges; `both_ways` as in a hatch.

    Where the flanks are not parallel, the beads pass over from the one to the other, evenly spaced between `closest` and
    `widest` times the step-over: where they would come nearer, all end, and fewer go on.
    """

    both_ways: bool = True
    closest: float = 0.75
    widest: float = 1.25

    def __post_init__(self) -> None:
        if not 0.0 < self.closest <= 1.0 <= self.widest or self.widest < 1.5 * self.closest:
            raise ValueError("closest must be in (0, 1], widest at least 1 and at least 1.5 times closest")

    def fill(self, cell: Cell) -> CellFill:
        angle, spread = flank_direction(cell.piece)
        if spread > PARALLEL and not cell.piece.winds:
            return self._passing_over(cell, angle)
        made = Hatch(angle=angle, both_ways=self.both_ways).fill(cell)
        beads = tuple(replace(b, kind=BeadKind.FLANK) for b in made.beads)
        return replace(made, beads=beads)

    def _passing_over(self, cell: Cell, angle: float) -> CellFill:
        import shapely

        first, second = _flanks(cell, angle)
        inset = inset_piece(cell.piece, cell.inset, chord=cell.chord)
        room = shapely.union_all(list(inset.polygons))
        zones = _zones(_gaps(np.hypot(*(second - first).T) / cell.step_over, self.closest, self.widest))
        beads: list[Bead] = []
        for begin, end, gaps in zones:
            cuts = (begin > 0, end < SAMPLES - 1)
            for j in range(gaps + 1):
                share = j / gaps if gaps else 0.5
                line = _without_ends((1.0 - share) * first[begin : end + 1] + share * second[begin : end + 1], cuts, cell.width)
                parts = parts_of(line.intersection(room), "LineString")
                found = [np.asarray(p.coords) for p in parts if p.length > cell.step_over]
                back = self.both_ways and j % 2 == 1
                beads += [Bead(points=p[::-1] if back else p, kind=BeadKind.FLANK, piece=cell.index) for p in found]
        notes = (f"beads end and fewer go on at {len(zones) - 1} places along its flanks",) if len(zones) > 1 else ()
        return CellFill(beads=tuple(beads), inset=cell.inset, angle=angle, step_over=cell.step_over, notes=notes)


def _without_ends(points: Array, cuts: tuple[bool, bool], width: float):
    """A line shorter at the ends where other beads begin, by what the round end of a bead lays beyond it."""
    from shapely import LineString
    from shapely.ops import substring

    line = LineString(points)
    return substring(line, cuts[0] * ROUND_END * width, max(line.length - cuts[1] * ROUND_END * width, 0.0))


def _flanks(cell: Cell, angle: float) -> tuple[Array, Array]:
    """The two longest edges moved inwards by the inset and a hair, (SAMPLES, 2) each, both run in the direction `angle`."""
    curves = [curve for loop in cell.piece.outer for curve in loop.curves]
    longest = sorted(curves, key=lambda c: c.length())[-2:]
    out, along = [], np.array([math.cos(angle), math.sin(angle)])
    for curve in longest:
        s = np.linspace(0.0, 1.0, SAMPLES)
        p, d = curve.points(s), curve.derivatives(s)
        # the piece lies on the left of its outline; the inset polygons err inwards by three chords at most
        p = p + (cell.inset + 3.0 * cell.chord) * np.stack([-d[:, 1], d[:, 0]], axis=1) / np.hypot(d[:, 0], d[:, 1])[:, None]
        out.append(p if float((p[-1] - p[0]) @ along) > 0.0 else p[::-1])
    return out[0], out[1]


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
