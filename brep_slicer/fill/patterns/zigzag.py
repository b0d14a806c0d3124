"""Zigzag: hatch lines joined at their ends into long continuous beads.

In: an area. Out: one bead for each run of neighbouring lines whose ends can be joined without leaving the inset.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from brep_slicer.process.parameter import parameter
from brep_slicer.process.taken import Taken

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea, Pattern
from ..tools.inset import inset_piece
from ..tools.parallel import ParallelLines, angle_on_layer
from ..tools.scanlines import directions


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Zigzag(Pattern):
    """Parallel lines at `angle_deg` (as in a hatch), laid without a stop from one to the next wherever the way is free."""

    name: ClassVar[str] = "zigzag"
    help: ClassVar[str] = "the lines of a hatch joined to one bead along the outline"
    turns_along: ClassVar[bool] = True

    angle_deg: Taken[tuple[float, ...], float | Sequence[float]] = parameter(
        (0.0,),
        unit="deg",
        many=True,
        options=("--angle",),
        help="Angle of the lines, counter-clockwise from the circumference; of several, layer by layer in turn",
    )
    angle_step_deg: float = parameter(0.0, unit="deg", help="The lines turn by so much from layer to layer")

    def fill(self, area: FillArea) -> AreaFill:
        angle = angle_on_layer(self.angle_deg, self.angle_step_deg, area.layer)
        made = ParallelLines(angle=angle, both_ways=True).fill(area)
        if len(made.beads) < 2 or area.piece.winds:
            return replace(made, beads=tuple(_as_zigzag(b) for b in made.beads))
        inset = inset_piece(area.piece, area.inset, chord=area.chord)
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
        beads = [Bead(points=np.concatenate(run), kind=BeadKind.ZIGZAG, piece=area.index) for run in runs]
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
