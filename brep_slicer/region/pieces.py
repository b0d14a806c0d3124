"""Connected parts of a region, each bounded by loops.

In: loops that were nested. Out: Piece values with exact areas.

Words: *lift*, a copy a whole number of turns away; *to wind*, to go all the way round the shaft.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.curves import Loop
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
        return f"Piece(R {self.radius:.6g} mm: {self.area():.6g} mm2, outline {self.length():.6g} mm, {holes}{turn})"

    @property
    def winds(self) -> bool:
        """Whether the piece goes all the way round."""
        return len(self.outer) == 2

    @property
    def radius(self) -> float:
        """Radius of the cylinder, mm."""
        return self.outer[0].radius

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

    def shifted(self, turns: int) -> Piece:
        """The lift `turns` turns further on."""
        return Piece(
            outer=tuple(loop.shifted(turns) for loop in self.outer),
            holes=tuple(loop.shifted(turns) for loop in self.holes),
        )

    def on_radius(self, radius: float) -> Piece:
        """The piece of the same angles on another cylinder."""
        return Piece(
            outer=tuple(loop.on_radius(radius) for loop in self.outer),
            holes=tuple(loop.on_radius(radius) for loop in self.holes),
        )
