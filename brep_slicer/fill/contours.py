"""Contours: beads that follow the outline, one step-over apart.

In: a cell. Out: closed beads, polygons that err inwards by no more than the chord.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array

from .bead import Bead, BeadKind
from .inset import from_the_lowest, inset_piece, three_turns_moved
from .pattern import Cell, CellFill, Pattern


@dataclass(frozen=True, slots=True, kw_only=True)
class Contours(Pattern):
    """`count` contours from the outline inwards (None: as many as fit); `outwards` deposits the innermost first."""

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
    shape = three_turns_moved(cell.piece, distance, chord=cell.chord)
    period = cell.piece.outer[0].period
    cut = float(cell.piece.outer[0].curves[0].start[0])
    return rings_of_three_turns(shape, cut, period)


def rings_of_three_turns(shape, cut: float, period: float) -> list[Array]:
    """The outlines of a geometry drawn over three turns, each once: closed rings, and lines that go all the way round."""
    out = []
    for polygon in getattr(shape, "geoms", [shape]):
        if polygon.is_empty or polygon.geom_type != "Polygon":
            continue
        for ring in (polygon.exterior, *polygon.interiors):
            points = np.asarray(ring.coords)
            low, high = points[:, 0].min(), points[:, 0].max()
            if high - low < 1.5 * period:
                if cut <= low < cut + period:
                    out.append(points)
            else:
                out += _round_lines(points, cut, period)
    return out


def _round_lines(points: Array, cut: float, period: float) -> list[Array]:
    """The lower and the upper side of a band drawn over three turns, one turn of each, from kappa = cut on."""
    a = points[:-1]
    middle = cut + 0.5 * period
    # rotate the ring so that it starts on its left end, and find where its two long sides cross the window's ends
    a = np.roll(a, -int(a[:, 0].argmin()), axis=0)
    ring = np.concatenate([a, a[:1]])
    out = []
    for way in (1.0, -1.0):
        start, stop = (cut, cut + period) if way > 0 else (cut + period, cut)
        x = way * (ring[:, 0] - start)
        enters = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
        y = way * (ring[:, 0] - stop)
        leaves = np.flatnonzero((y[:-1] < 0.0) & (y[1:] >= 0.0))
        for i in enters:
            later = leaves[leaves >= i]
            if not len(later):
                continue
            j = int(later[0])
            first, last = _at(ring, int(i), start), _at(ring, j, stop)
            last[1] = first[1]
            chain = np.concatenate([first[None], ring[i + 1 : j + 1], last[None]])
            if (way * np.diff(chain[:, 0])).sum() > 0.99 * period and abs(chain[:, 0].mean() - middle) < period:
                out.append(_distinct(chain))
                break
    return out


def _at(ring: Array, i: int, kappa: float) -> Array:
    share = (kappa - ring[i, 0]) / (ring[i + 1, 0] - ring[i, 0])
    return np.array([kappa, ring[i, 1] + share * (ring[i + 1, 1] - ring[i, 1])])


def _distinct(chain: Array) -> Array:
    keep = np.append(True, np.hypot(*np.diff(chain, axis=0).T) > 1e-12)
    return chain[keep]
