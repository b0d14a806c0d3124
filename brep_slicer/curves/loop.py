"""Closed chains of unrolled curves.

In: curves that follow one another with the material on their left. Out: Loop values with exact integrals.

Words: *winding*, how often a loop goes round the shaft (0, or +-1 on a full band); *copy*, the same loop whole turns away, by
the closure of its sheet; *jog*, the gap between one curve's end and the next one's start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from brep_slicer.layers import Closure, Sheet
from brep_slicer.maps import Array
from brep_slicer.wording import counted

from .base import Curve, integrated
from .line import LineCurve


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Loop:
    """A closed chain of `curves` in the plane of a `sheet`, material on the left, kappa continuous.

    A loop of winding w ends at the copy of its start that lies w turns on.
    """

    curves: tuple[Curve, ...]
    sheet: Sheet
    winding: int = 0
    _moments: dict[int, float] = field(init=False, repr=False, default_factory=dict)
    _known: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def __repr__(self) -> str:
        turn = f", winding {self.winding:+d}" if self.winding else ""
        curves = counted(len(self.curves), "curve")
        return f"Loop({self.sheet.label}: {curves}, {self.length():.6g} mm, {self.signed_area():.6g} mm2{turn})"

    @property
    def radius(self) -> float:
        """Radius of the cylinder that it lies on, mm."""
        return self.sheet.radius

    @property
    def is_apex(self) -> bool:
        """Whether the loop is a cone's apex, a point that goes round the axis: what bounds a region that holds it."""
        first = self.curves[0]
        return bool(self.winding) and len(self.curves) == 1 and bool((first.start == first.end).all())

    @property
    def closure(self) -> Closure:
        """The motion from a loop to its next copy."""
        return self.sheet.closure

    def signed_area(self) -> float:
        """Area to the left of the loop, above v = 0 where it winds, in mm**2: -integral of v dkappa (Green)."""
        if self.winding and not self.closure.is_translation:
            return self._area_above_ring()
        return -self.moment(1)

    def _area_above_ring(self) -> float:
        """The same where copies are turned: the integral of a form that is one for every copy, jogs by straight segments."""
        if self.is_apex:
            height = float(self.closure.heights_of(self.curves[0].start))
            return -self.winding * height * (self.closure.length + 0.5 * self.closure.angle * height)
        ends, following = self._joints()
        jogs = [LineCurve(p0=a, p1=b) for a, b in zip(ends, following, strict=True)]
        return -sum(integrated(self.closure.swept_area, curve) for curve in (*self.curves, *jogs))

    def moment(self, power: int) -> float:
        """Integral of v**power dkappa once round, in mm**(power + 1); jogs are closed by straight segments."""
        if power not in self._moments:
            ends, following = self._joints()
            lines = np.array([isinstance(curve, LineCurve) for curve in self.curves])
            starts = np.concatenate([following[-1:], following[:-1]])
            starts[0] = self.closure.moved(starts[0], -self.winding)
            a, b = np.concatenate([ends, starts[lines]]), np.concatenate([following, ends[lines]])
            mean = sum(a[:, 1] ** i * b[:, 1] ** (power - i) for i in range(power + 1)) / (power + 1)
            curved = sum(curve.moment(power) for curve in self.curves if not isinstance(curve, LineCurve))
            self._moments[power] = curved + float(np.sum((b[:, 0] - a[:, 0]) * mean))
        return self._moments[power]

    def length(self) -> float:
        """Length in mm."""
        if "length" not in self._known:
            self._known["length"] = sum(curve.length() for curve in self.curves)
        return self._known["length"]

    def jog(self) -> float:
        """Largest gap between one curve's end and the next one's start, in mm."""
        ends, starts = self._joints()
        return float(np.hypot(*(starts - ends).T).max())

    def _joints(self) -> tuple[Array, Array]:
        """Each curve's end, and the start of the one that follows it, (n, 2)."""
        if "joints" not in self._known:
            self._known["joints"] = self._find_joints()
        return self._known["joints"]

    def _find_joints(self) -> tuple[Array, Array]:
        starts = np.array([curve.start for curve in self.curves])
        ends = np.array([curve.end for curve in self.curves])
        following = np.concatenate([starts[1:], starts[:1]])
        following[-1] = self.closure.moved(following[-1], self.winding)
        return ends, following

    def bounds(self) -> tuple[float, float, float, float]:
        """(kappa_min, v_min, kappa_max, v_max) in mm."""
        if "bounds" not in self._known:
            self._known["bounds"] = self._find_bounds()
        return self._known["bounds"]

    def _find_bounds(self) -> tuple[float, float, float, float]:
        # of a loop that winds the first point is not where the last one ends, but whole turns from there
        ends = np.concatenate([*self._joints(), self.curves[0].start[None]])
        curved = [curve.bounds() for curve in self.curves if not isinstance(curve, LineCurve)]
        boxes = np.array([(*ends.min(axis=0), *ends.max(axis=0)), *curved])
        return (*boxes[:, :2].min(axis=0).tolist(), *boxes[:, 2:].max(axis=0).tolist())

    def sample(self, chord: float) -> Array:
        """Points (n, 2) once round, within `chord` (mm) of the curves; the first is repeated (a turn on) at the end."""
        known = self._known.get("sample")
        if known is None or known[0] != chord:
            parts = [curve.sample(chord)[:-1] for curve in self.curves]
            first = self.closure.moved(parts[0][0], self.winding)
            points = np.concatenate([*parts, first[None, :]])
            points.flags.writeable = False
            known = self._known["sample"] = chord, points
        return known[1]

    def moved(self, turns: int) -> Loop:
        """The copy `turns` turns further on."""
        if turns == 0:
            return self
        motion = self.closure.motion(turns)
        return Loop(curves=tuple(curve.moved(motion) for curve in self.curves), sheet=self.sheet, winding=self.winding)

    def raised(self, dv: float) -> Loop:
        """The loop moved by `dv` mm along v."""
        return Loop(curves=tuple(curve.raised(dv) for curve in self.curves), sheet=self.sheet, winding=self.winding)

    def reversed(self) -> Loop:
        """The loop run through the other way: the material changes sides."""
        return Loop(
            curves=tuple(curve.reversed() for curve in reversed(self.curves)),
            sheet=self.sheet,
            winding=-self.winding,
        )

    def on_sheet(self, sheet: Sheet) -> Loop:
        """The loop of the same angles on another cylinder."""
        moved = tuple(curve.on_radius(self.radius, sheet.radius) for curve in self.curves)
        return Loop(curves=moved, sheet=sheet, winding=self.winding)


def with_apex(sheet: Sheet, loops: Sequence[Loop]) -> list[Loop]:
    """Loops on a sheet, with a cone's apex where one more than pair up goes round: what they bound holds the apex."""
    winding = sum(loop.winding for loop in loops)
    if sheet.closure.is_translation or abs(winding) != 1:
        return list(loops)
    point = LineCurve(p0=sheet.closure.apex, p1=sheet.closure.apex)
    return [*loops, Loop(curves=(point,), sheet=sheet, winding=-winding)]
