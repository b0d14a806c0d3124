"""Zigzag: hatch lines joined at their ends into long continuous beads.

In: a cell. Out: one bead for each run of neighbouring lines whose ends can be joined without leaving the inset.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .bead import Bead, BeadKind
from .hatch import Hatch
from .inset import inset_piece
from .pattern import Cell, CellFill, Pattern
from .scanlines import directions


@dataclass(frozen=True, slots=True, kw_only=True)
class Zigzag(Pattern):
    """Parallel lines at `angle` (rad), laid without a stop from one to the next wherever the way between them is free."""

    turns_along = True
    angle: float = 0.0

    def fill(self, cell: Cell) -> CellFill:
        made = Hatch(angle=self.angle, both_ways=True).fill(cell)
        if len(made.beads) < 2 or cell.piece.winds:
            return replace(made, beads=tuple(_as_zigzag(b) for b in made.beads))
        inset = inset_piece(cell.piece, cell.inset, chord=cell.chord)
        free = _free_space(inset)
        assert made.angle is not None
        assert made.step_over is not None
        _, across = directions(made.angle)
        runs = [[made.beads[0].points]]
        for before, bead in zip(made.beads[:-1], made.beads[1:], strict=True):
            gap = abs(float((bead.points[0] - before.points[0]) @ across))
            neighbours = abs(gap - made.step_over) < 1e-6 * made.step_over
            if neighbours and _covers(free, before.points[-1], bead.points[0]):
                runs[-1].append(bead.points)
            else:
                runs.append([bead.points])
        beads = [Bead(points=np.concatenate(run), kind=BeadKind.ZIGZAG, piece=cell.index) for run in runs]
        return replace(made, beads=tuple(beads))


def _as_zigzag(bead: Bead) -> Bead:
    return Bead(points=bead.points, kind=BeadKind.ZIGZAG, piece=bead.piece, closed=bead.closed)


def _free_space(inset):
    """Where a bead's centre may go: the inset polygons, wider by the slack that they err inwards."""
    import shapely

    free = shapely.union_all(list(inset.polygons)).buffer(inset.slack, join_style="mitre")
    shapely.prepare(free)
    return free


def _covers(free, start: np.ndarray, end: np.ndarray) -> bool:
    import shapely

    return bool(shapely.covers(free, shapely.LineString([start, end])))
