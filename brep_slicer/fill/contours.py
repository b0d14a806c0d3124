"""Contours: beads that follow the outline, one step-over apart.

In: a cell. Out: closed beads, polygons that err inwards by no more than the chord.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array
from brep_slicer.region import stitched_outlines

from .bead import Bead, BeadKind
from .inset import from_the_lowest, inset_piece, three_turns_moved
from .pattern import Cell, CellFill, Pattern


@dataclass(frozen=True, slots=True, kw_only=True)
class Contours(Pattern):
    """`count` contours from the outline inwards (None: as many as fit); `outwards` deposits the innermost first."""

    turns_along = True
    count: int | None = 1
    outwards: bool = False

    def fill(self, cell: Cell) -> CellFill:
        rounds: list[list[Bead]] = []
        inset = cell.inset
        while self.count is None or len(rounds) < self.count:
            rings = rings_at(cell, inset)
            if not rings:
                break
            rounds.append([Bead(points=r, kind=BeadKind.CONTOUR, piece=cell.index, closed=True) for r in rings])
            inset += cell.step_over
        notes: tuple[str, ...] = ()
        if self.count is not None and rounds and len(rounds) < self.count:
            notes = (f"only {len(rounds)} of {self.count} contours fit",)
        if self.outwards:
            rounds.reverse()
        return CellFill(beads=tuple(b for ring in rounds for b in ring), inset=inset, notes=notes)


def rings_at(cell: Cell, distance: float) -> list[Array]:
    """Closed lines (n, 2) at `distance` inside of the outline; on a full turn also those that go all the way round."""
    if not cell.piece.winds:
        inset = inset_piece(cell.piece, distance, chord=cell.chord)
        return [from_the_lowest(np.asarray(ring.coords)) for p in inset.polygons for ring in (p.exterior, *p.interiors)]
    period = cell.piece.outer[0].period
    cut = float(cell.piece.outer[0].curves[0].start[0])
    shape = three_turns_moved(cell.piece, distance, chord=cell.chord)
    # what is drawn there ends an inset before a turn on either side of the window
    found = stitched_outlines(shape, first=cut - 0.5 * period, period=period)
    round_lines = [_from_the_cut(points, cut, winding * period) for points, winding in found if winding]
    rings = [_in_the_window(from_the_lowest(points), cut, period) for points, winding in found if not winding]
    return sorted(round_lines, key=lambda points: float(points[:, 1].mean())) + rings


def _in_the_window(ring: Array, cut: float, period: float) -> Array:
    return ring - np.array([math.floor((ring[:, 0].min() - cut) / period) * period, 0.0])


def _from_the_cut(points: Array, cut: float, turn: float) -> Array:
    """A line that goes round by `turn` (mm, either way), run from kappa = `cut` or a turn on, where that is lowest."""
    steps = np.floor((np.sign(turn) * (points[:, 0] - cut)) / abs(turn))
    crossing = np.flatnonzero(np.diff(steps) > 0.0)
    level = cut + np.sign(turn) * steps[crossing + 1] * abs(turn)
    (k0, v0), (k1, v1) = points[crossing].T, points[crossing + 1].T
    heights = v0 + (v1 - v0) * (level - k0) / (k1 - k0)
    i = int(crossing[heights.argmin()])
    start = np.array([[level[heights.argmin()], heights.min()]])
    once = np.array([turn, 0.0])
    chain = np.concatenate([start, points[i + 1 : -1], points[: i + 1] + once, start + once])
    chain[:, 0] += (cut if turn > 0.0 else cut - turn) - chain[0, 0]
    return chain[np.append(True, np.hypot(*np.diff(chain, axis=0).T) > 1e-12)]
