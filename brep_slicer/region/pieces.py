"""Connected parts of a region, each bounded by loops.

In: loops that were nested. Out: Piece values with exact areas.

Words: *copy*, the same piece a whole number of turns away; *to wind*, to go all the way round the shaft.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.layers import Closure, Sheet
from brep_slicer.wording import counted


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Piece:
    """A connected part of a region.

    `outer` is one loop of winding 0, run counter-clockwise, or, on a full band, two: the lower edge (winding +1) and the
    upper edge (winding -1). `holes` run clockwise and lie in the same chart: inside of the outer loop, or within one turn
    from the start of the lower edge.
    """

    outer: tuple[Loop, ...]
    holes: tuple[Loop, ...] = ()

    def __repr__(self) -> str:
        turn = ", full turn" if self.winds else ""
        holes = counted(len(self.holes), "hole")
        return f"Piece({self.sheet.label}: {self.area():.6g} mm2, outline {self.length():.6g} mm, {holes}{turn})"

    @property
    def winds(self) -> bool:
        """Whether the piece goes all the way round."""
        return len(self.outer) == 2

    @property
    def sheet(self) -> Sheet:
        """The sheet that it lies on."""
        return self.outer[0].sheet

    @property
    def closure(self) -> Closure:
        """The motion from a piece to its next copy."""
        return self.sheet.closure

    @property
    def cut(self) -> float:
        """Where the chart of a full turn is cut, in turns: where its lower edge begins."""
        return float(self.closure.turns_of(self.outer[0].curves[0].start))

    @property
    def beside(self) -> tuple[int, ...]:
        """The turns by which what lies in a full turn is moved to have it beside that, too; (0,) of other pieces."""
        return self.closure.beside if self.winds else (0,)

    @property
    def radius(self) -> float:
        """Radius of the cylinder, mm."""
        return self.sheet.radius

    @property
    def loops(self) -> tuple[Loop, ...]:
        """Outer loops first, then holes."""
        return self.outer + self.holes

    def area(self) -> float:
        """Exact area from the curves, mm**2."""
        return sum(loop.signed_area() for loop in self.loops)

    def first_moment(self) -> float:
        """Integral of v over the piece, mm**3: -1/2 sum of the integrals of v**2 dkappa (Green)."""
        return -0.5 * sum(loop.moment(2) for loop in self.loops)

    def length(self) -> float:
        """Length of the whole boundary, mm."""
        return sum(loop.length() for loop in self.loops)

    def bounds(self) -> tuple[float, float, float, float]:
        """(kappa_min, v_min, kappa_max, v_max) of the outer loops, mm."""
        boxes = np.array([loop.bounds() for loop in self.outer])
        return (*boxes[:, :2].min(axis=0).tolist(), *boxes[:, 2:].max(axis=0).tolist())

    def moved(self, turns: int) -> Piece:
        """The copy `turns` turns further on."""
        return Piece(
            outer=tuple(loop.moved(turns) for loop in self.outer), holes=tuple(loop.moved(turns) for loop in self.holes)
        )

    def on_sheet(self, sheet: Sheet) -> Piece:
        """The piece of the same angles on another cylinder."""
        return Piece(
            outer=tuple(loop.on_sheet(sheet) for loop in self.outer), holes=tuple(loop.on_sheet(sheet) for loop in self.holes)
        )
