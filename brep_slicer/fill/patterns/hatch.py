"""Hatch: parallel straight beads at an exact step-over and any angle.

In: areas. Out: beads that end at the area's inset from the exact outline; on a full turn they close on themselves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from brep_slicer.process.parameter import parameter
from brep_slicer.process.taken import Taken

from ..pattern import AreaFill, FillArea, Pattern
from ..tools.parallel import ParallelLines, angle_on_layer


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Hatch(Pattern):
    """Parallel beads at `angle_deg` (degrees, counter-clockwise from +kappa seen from outside), one way or both ways.

    Of several angles each layer has the next one, and all turn by `angle_step_deg` from layer to layer. With `stretch` (a share
    of the step-over), spacings may be that much wider or narrower so that the outermost lines lie at the inset on both sides.
    """

    name: ClassVar[str] = "hatch"
    help: ClassVar[str] = "parallel lines, exactly a step-over apart"
    turns_along: ClassVar[bool] = True

    angle_deg: Taken[tuple[float, ...], float | Sequence[float]] = parameter(
        (0.0,),
        unit="deg",
        many=True,
        options=("--angle",),
        help="Angle of the lines, counter-clockwise from the circumference; of several, layer by layer in turn",
    )
    angle_step_deg: float = parameter(0.0, unit="deg", help="The lines turn by so much from layer to layer")
    both_ways: bool = parameter(True, options=("--both-ways/--one-way",), help="Every second line is laid backwards")
    stretch: float = parameter(
        0.0,
        least=0.0,
        below=0.5,
        help="By what share of d spacings may differ from it so that a piece's width is filled exactly",
    )

    def fill(self, area: FillArea) -> AreaFill:
        return self.fill_all([area])[0]

    def fill_all(self, areas: Sequence[FillArea]) -> list[AreaFill]:
        """All pieces of a layer at once."""
        if not areas:
            return []
        angle = angle_on_layer(self.angle_deg, self.angle_step_deg, areas[0].layer)
        return ParallelLines(angle=angle, both_ways=self.both_ways, stretch=self.stretch).fill_all(areas)
