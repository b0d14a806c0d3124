"""Closed chains of unrolled curves, and the pieces that they bound.

In: curves that follow one another with the material on their left. Out: Loop and Piece values with exact areas.

Words: *winding*, how often a loop goes round the shaft (0, or +-1 on a full band); *lift*, one of a loop's copies in the
universal cover, a whole number of turns apart; *jog*, the gap between one curve's end and the next one's start.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.curves import Curve
from brep_slicer.maps import TURN, Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """A closed chain of `curves` on a cylinder of `radius` (mm), material on the left, kappa continuous.

    A loop of winding w ends at its start plus (w * 2 * pi * radius, 0).
    """

    curves: tuple[Curve, ...]
    radius: float
    winding: int = 0

    @property
    def period(self) -> float:
        """Length of one turn, 2 * pi * radius, in mm."""
        return TURN * self.radius

    def signed_area(self) -> float:
        """Area to the left of the loop above v = 0, -integral of v dkappa, in mm**2 (Green)."""
        return -self.moment(1)

    def moment(self, power: int) -> float:
        """Integral of v**power dkappa once round, in mm**(power + 1); jogs are closed by straight segments."""
        ends, starts = self._joints()
        bridges = (starts[:, 0] - ends[:, 0]) * sum(
            ends[:, 1] ** i * starts[:, 1] ** (power - i) for i in range(power + 1)
        ) / (power + 1)
        return sum(curve.moment(power) for curve in self.curves) + float(np.sum(bridges))

    def length(self) -> float:
        """Length in mm."""
        return sum(curve.length() for curve in self.curves)

    def jog(self) -> float:
        """Largest gap between one curve's end and the next one's start, in mm."""
        ends, starts = self._joints()
        return float(np.hypot(*(starts - ends).T).max())

    def _joints(self) -> tuple[Array, Array]:
        """Each curve's end, and the start of the one that follows it, (n, 2)."""
        starts = np.array([curve.start for curve in self.curves])
        ends = np.array([curve.end for curve in self.curves])
        following = np.roll(starts, -1, axis=0)
        following[-1, 0] += self.winding * self.period
        return ends, following

    def bounds(self) -> tuple[float, float, float, float]:
        """(kappa_min, v_min, kappa_max, v_max) in mm."""
        boxes = np.array([curve.bounds() for curve in self.curves])
        return (*boxes[:, :2].min(axis=0).tolist(), *boxes[:, 2:].max(axis=0).tolist())

    def sample(self, chord: float) -> Array:
        """Points (n, 2) once round, within `chord` (mm) of the curves; the first is repeated (a turn on) at the end."""
        parts = [curve.sample(chord)[:-1] for curve in self.curves]
        first = parts[0][0] + np.array([self.winding * self.period, 0.0])
        return np.concatenate([*parts, first[None, :]])

    def shifted(self, turns: int) -> Loop:
        """The lift `turns` turns further on."""
        if turns == 0:
            return self
        moved = tuple(curve.shifted(turns * self.period) for curve in self.curves)
        return Loop(curves=moved, radius=self.radius, winding=self.winding)

    def reversed(self) -> Loop:
        """The loop run through the other way: the material changes sides."""
        return Loop(
            curves=tuple(curve.reversed() for curve in reversed(self.curves)),
            radius=self.radius,
            winding=-self.winding,
        )

    def on_radius(self, radius: float) -> Loop:
        """The loop of the same angles on another cylinder."""
        moved = tuple(curve.on_radius(self.radius, radius) for curve in self.curves)
        return Loop(curves=moved, radius=radius, winding=self.winding)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Piece:
    """A connected part of a region.

    `outer` is one loop of winding 0, run counter-clockwise, or, on a full band, two: the lower edge (winding +1) and the
    upper edge (winding -1). `holes` run clockwise and lie in the same chart: inside of the outer loop, or within one turn
    from the start of the lower edge.
    """

    outer: tuple[Loop, ...]
    holes: tuple[Loop, ...] = ()

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
