"""Both engines behind one function: who cuts, who is asked next, and when nobody is believed.

In: a CutSolid, radii, the engine asked for. Out: each radius's loops with their certificate, or the reason why there are none.

The analytic engine cuts all radii at once. Where it does not vouch for one, the boolean is asked, and what it says is held
against the surface integral: near tangencies OCCT's common may be empty or partial, and its own checks, all by one routine,
agree. If it is not believed either, the analytic engine is asked a little farther out.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from brep_slicer.curves import Loop, with_apex
from brep_slicer.errors import LayerError
from brep_slicer.layers import CYLINDERS
from brep_slicer.maps import Array

from .analytic import IN_NOISE, sections_by_analysis
from .boolean import COINCIDENCE_STEP, clear_radius, section_by_boolean
from .certificate import Certificate, Engine, check_error
from .cut_solid import CutSolid
from .oracle import area_and_turnover, area_of_level, areas_of_ramps, flux_ramps
from .stepped import moved_by_step

Found = tuple[list[Loop], Certificate] | LayerError
# How far outside of a radius the analytic engine is asked again, mm: beyond the noise of tangencies, within the boolean's step.
# Of two that it vouches for the nearer one is taken; the other one tells how far it has moved.
STEPS = np.array([1e-7, 1e-6, 1e-5, 2e-5])
# The quick surface integral is good to this share of a solid's largest section; the exact one judges what differs by more.
QUICK = 1e-3
# Solids of so few faces are judged by the exact one at once.
FEW_FACES = 30
# Panels of the exact one; its two results tell what it is good for. An area may differ by so many times that, and by a share of
# what the integral adds and takes away: kinks that the panels do not know of.
PANELS, NOISE, SHARE = (6, 9), 4.0, 5e-3
# It looks for rho = R on every face in a hundred steps: on radii smaller than this share of the solid's reach it has no say.
NEAR_AXIS = 0.01


class SurfaceIntegral:
    """Areas (mm**2) of one solid's sections by the surface integral, each computed once, however often it is asked for."""

    def __init__(self, solid: CutSolid) -> None:
        self.solid = solid
        self._exact: dict[tuple[float, int], tuple[float, float]] = {}

    def quick(self, radii: Array) -> Array:
        """To about four digits of the largest section."""
        return areas_of_ramps(self._ramps, radii)

    def exact(self, radius: float, panels: int) -> tuple[float, float]:
        """`area_and_turnover`."""
        key = radius, panels
        if key not in self._exact:
            self._exact[key] = area_and_turnover(self.solid.brep, radius, panels=panels)
        return self._exact[key]

    @cached_property
    def _ramps(self) -> tuple[Array, Array, Array]:
        return flux_ramps(self.solid.brep, level=self.solid.stretches.face_level)


class SolidSections:
    """The sections of one solid at `radii` (mm, increasing), by the engine asked for and by who is asked after it.

    `judge` is the solid's surface integral, if there is one already.
    """

    def __init__(
        self, solid: CutSolid, radii: Sequence[float], engine: Engine, *, judge: SurfaceIntegral | None = None
    ) -> None:
        self.solid, self.radii, self.engine = solid, np.asarray(radii, dtype=float), engine
        self.judge = judge or SurfaceIntegral(solid)
        self.ahead = sections_by_analysis(solid, self.radii) if engine is Engine.ANALYTIC else None

    def section(self, i: int) -> Found:
        """At radius number i, in the axis frame; a fallback is cut when it is asked for."""
        return self._in_place(self._section(i))

    def fallback(self, i: int, reason: str) -> Found:
        """At radius number i by who is asked next, because of a `reason` not to believe the engine; in the axis frame."""
        return self._in_place(self._fallback(i, reason))

    def _in_place(self, found: Found) -> Found:
        """What was cut near the origin, where it belongs."""
        lift = self.solid.brep.lift
        if lift == 0.0 or isinstance(found, LayerError):
            return found
        return [loop.raised(lift) for loop in found[0]], found[1]

    def _section(self, i: int) -> Found:
        if self.ahead is None:
            return self._fallback(i, "")
        found = self.ahead[i]
        if isinstance(found, LayerError):
            return self._fallback(i, str(found))
        loops, certificate = found
        radius = float(self.radii[i])
        try:
            check_error(certificate, radius)
            if IN_NOISE in certificate.checks:
                return loops, self._agreed(i, radius, loops, certificate, certificate.residual)
        except LayerError as error:
            return self._fallback(i, str(error))
        return found

    def beside(self, radius: float) -> SolidSections:
        """The same solid at another radius (mm), judged by the same surface integral."""
        return SolidSections(self.solid, [radius], self.engine, judge=self.judge)

    def _fallback(self, i: int, reason: str) -> Found:
        """The boolean's section if the surface integral agrees, else the analytic one a little farther out."""
        solid, radius = self.solid, float(self.radii[i])
        if solid.family != CYLINDERS:
            return self._farther_out(i, reason)
        try:
            gap = float(solid.gaps.max(initial=0.0))
            loops, certificate = section_by_boolean(solid.wrapped, radius, critical=solid.critical.radii, gap=gap)
            check_error(certificate, radius)
            used = clear_radius(radius, solid.critical.radii)
            tolerance = float(certificate.checks["edge_tolerance_mm"])
            return loops, self._agreed(i, used, loops, replace(certificate, fallback=reason), tolerance)
        except LayerError as error:
            reason = f"{error}; before that: {reason}" if reason else str(error)
        return self._farther_out(i, reason)

    def _farther_out(self, i: int, reason: str) -> Found:
        """The analytic section a little farther out, where two such steps vouch for it."""
        solid, radius = self.solid, float(self.radii[i])
        outside = sections_by_analysis(solid, radius + STEPS)
        vouched = [
            (step, *found) for step, found in zip(STEPS.tolist(), outside, strict=True) if not isinstance(found, LayerError)
        ]
        for (step, cut, certificate), (farther, beyond, _) in itertools.pairwise(vouched):
            loops, far = ([loop.on_sheet(solid.family.sheet(radius)) for loop in found] for found in (cut, beyond))
            stated = max(certificate.residual, moved_by_step(loops, far, (step, farther)))
            believed = replace(certificate, residual=stated, fallback=reason)
            try:
                check_error(believed, radius)
                return loops, self._agreed(i, radius + step, loops, believed, certificate.residual)
            except LayerError:
                continue
        return LayerError(reason)

    @cached_property
    def _quick(self) -> Array:
        """Areas (mm**2) by the quick surface integral at all radii, all a boolean's step farther out."""
        return self.judge.quick(self.radii + COINCIDENCE_STEP)

    def _agreed(self, i: int, used: float, loops: list[Loop], certificate: Certificate, tolerance: float) -> Certificate:
        """The certificate with the surface integral's word.

        Raises
        ------
        LayerError
            If the areas at the radius `used` (mm) differ by more than the integral is good for, and `tolerance` (mm).
        """
        if self.solid.family != CYLINDERS:
            return self._agreed_of_family(used, loops, certificate, tolerance)
        if used < NEAR_AXIS * self.solid.critical.highest:
            return certificate
        area = sum(loop.signed_area() for loop in loops)
        scale = max(float(np.abs(self._quick).max()), abs(area))
        differs = float(self._quick[i]) - area
        if len(self.solid.brep.faces) <= FEW_FACES or abs(differs) > QUICK * scale:
            length = sum(loop.length() for loop in loops)
            edge = length * max(tolerance, certificate.jog)
            fine, turnover = self.judge.exact(used, PANELS[0])
            noise = SHARE * turnover
            if abs(fine - area) > noise + edge:
                coarse, (fine, turnover) = fine, self.judge.exact(used, PANELS[1])
                noise = NOISE * abs(fine - coarse) + SHARE * turnover
            differs = fine - area
            if abs(differs) > noise + edge:
                raise LayerError(
                    f"the {certificate.engine.value} section at radius {used:.9g} mm has {area:.6g} mm2, the surface integral"
                    f" says {fine:.6g}"
                )
            if length:
                strip = max(abs(differs) - noise, 0.0) / length
                certificate = replace(certificate, contradiction=max(certificate.contradiction, strip))
                check_error(certificate, used)
        return replace(certificate, checks={**certificate.checks, "surface_integral_differs_mm2": differs})

    def _agreed_of_family(self, used: float, loops: list[Loop], certificate: Certificate, tolerance: float) -> Certificate:
        """The same for layers that are no cylinders, by the integral of their family."""
        family = self.solid.family
        area = sum(loop.signed_area() for loop in with_apex(family.sheet(used), loops))
        length = sum(loop.length() for loop in loops)
        coarse, fine = (area_of_level(self.solid.brep, used, family, panels=panels) for panels in PANELS)
        if abs(fine - area) > NOISE * abs(fine - coarse) + length * max(tolerance, certificate.jog):
            raise LayerError(f"the section at {family.label(used)} has {area:.6g} mm2, the surface integral says {fine:.6g}")
        return replace(certificate, checks={**certificate.checks, "surface_integral_differs_mm2": fine - area})
