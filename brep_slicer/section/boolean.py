"""The `boolean` engine: OCCT's common of a cylinder face and a solid, unrolled from its 3D curves.

In: a solid in the axis frame and a radius. Out: closed loops of unrolled curves, with a certificate.

Words: *step*, how far beside a critical radius the solid is cut instead (the one-sided limit cannot be taken here);
*second cut*, the same section in two half-turns, whose areas must add up.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from brep_slicer.curves import Loop
from brep_slicer.errors import LayerError
from brep_slicer.layers import cylinder
from brep_slicer.maps import TURN, Array

from .certificate import Certificate, Engine
from .chain import Arc, loops_from_arcs
from .stepped import moved_by_step
from .unroll import curve_on_sheet

# OCCT's booleans are wrong within about 1e-6 mm of a coincident face: stay ten times farther away, five at least.
COINCIDENCE_STEP = 1e-5
# A critical radius this little above a radius is the same; and how far outwards a gap between critical radii is looked for, mm.
COINCIDENT, FARTHEST = 1e-9, 5e-5
# What OCCT aims at for its intersection curves, mm; an edge whose tolerance says more is believed.
INTERSECTION_RESIDUAL = 1e-7
# OCCT widens an edge's tolerance until it holds what it has made. Beyond the larger of this (mm) and so many times the file's
# own it has gone astray, and a check that allows for it allows anything.
WIDEST, FILES_OWN = 1e-3, 2.0
# Where the cylinder face is cut open (rad); any angle will do that no edge of the part follows, and OCCT may fail at one.
SEAMS = (0.4142, 2.2361, 4.1231)
# Two areas may differ by the tolerance of every edge along its length, in each of the two cuts.
CUTS = 2.0
# The second cut that tells how fast an outline moves lies on by at least this share of the first one's step.
LEAST_ON = 0.25


def section_by_boolean(solid: Any, radius: float, *, critical: Array, gap: float = 0.0) -> tuple[list[Loop], Certificate]:
    """Cut one solid.

    Parameters
    ----------
    solid : TopoDS_Solid
        In the axis frame, mm.
    radius : float
        Radius of the cut, mm.
    critical : ndarray, shape (n,)
        The solid's critical radii, mm; near one of them the cut steps aside, and says how far that moves the outline.
    gap : float
        The solid's largest gap between an edge and its faces, mm: gaps in the outline may be that wide, too.

    Raises
    ------
    LayerError
        If the boolean fails, or its checks do, wherever the cylinder face is cut open.
    """
    used = clear_radius(radius, critical)
    loops, certificate = _cut(solid, used, gap)
    loops = [loop.on_sheet(cylinder(radius)) for loop in loops]
    if used == radius:
        return loops, certificate
    if not loops and np.any((critical > radius + COINCIDENT) & (critical < used)):
        raise LayerError(f"what the section at radius {radius:.9g} mm holds ends before the next radius that OCCT can cut at")
    farther = _farther(radius, used, critical)
    far = [loop.on_sheet(cylinder(radius)) for loop in _cut(solid, farther, gap)[0]]
    moved = moved_by_step(loops, far, (abs(used - radius), abs(farther - radius)))
    return loops, replace(certificate, residual=max(certificate.residual, moved), coincident=True)


def _farther(radius: float, used: float, critical: Array) -> float:
    """A radius that tells how fast the outline moves: twice as far out as `used`, or as far as the next critical one lets it.

    Raises
    ------
    LayerError
        If OCCT cannot cut far enough on: how far the outline has moved is not known then.
    """
    out = math.copysign(1.0, used - radius)
    beyond = out * (np.asarray(critical, dtype=float) - used)
    room = float(beyond[beyond > 0.0].min(initial=math.inf)) - 0.5 * COINCIDENCE_STEP
    on = min(abs(used - radius), room)
    if on < LEAST_ON * abs(used - radius):
        raise LayerError(f"how far a step to {used:.9g} mm moves the section at radius {radius:.9g} mm cannot be told")
    return used + out * on


def _cut(solid: Any, radius: float, gap: float) -> tuple[list[Loop], Certificate]:
    """One cut, at the first seam at which its checks hold."""
    reason = ""
    for seam in SEAMS:
        try:
            return _cut_once(solid, radius, seam, gap)
        except LayerError as error:
            reason = str(error)
    raise LayerError(reason)


def _cut_once(solid: Any, used: float, seam: float, gap: float) -> tuple[list[Loop], Certificate]:
    """One cut of the whole turn, its seam at the angle `seam` (rad), checked against two half-turns."""
    from brep_slicer.kernel.booleans import common_with_cylinder, height_range, largest_tolerance

    low, high = height_range(solid)
    margin = 1.0 + 0.01 * (high - low)
    heights = (low - margin, high + margin)
    whole = common_with_cylinder(solid, used, seam=seam, turn=TURN, heights=heights)
    tolerance = max([INTERSECTION_RESIDUAL, *(u.tolerance for u in whole.uses)])
    widest = max(WIDEST, FILES_OWN * max(gap, largest_tolerance(solid)))
    if tolerance > widest:
        raise LayerError(f"OCCT's boolean lets its section at radius {used:g} mm lie {tolerance:.3g} mm from the faces")
    arcs = [
        Arc(curve=curve_on_sheet(u.curve, u.first, u.last, cylinder(used), forward=u.forward), start=u.start, end=u.end)
        for u in whole.uses
    ]
    loops = loops_from_arcs(cylinder(used), arcs)
    area, length = sum(loop.signed_area() for loop in loops), sum(loop.length() for loop in loops)
    halves = sum(
        common_with_cylinder(solid, used, seam=seam + 1.0 + k * math.pi, turn=math.pi, heights=heights).area for k in (0, 1)
    )
    jog = max((loop.jog() for loop in loops), default=0.0)
    if jog > widest:
        raise LayerError(f"the outline of OCCT's boolean gapes by {jog:.3g} mm at radius {used:g} mm, the file's edges by less")
    allowed = CUTS * length * (tolerance + jog) + 1e-9 * area
    differs = max(abs(halves - area), abs(whole.area - area))
    checks: dict[str, bool | float | str] = {
        "area_of_half_turns_differs_mm2": halves - area,
        "area_of_occt_face_differs_mm2": whole.area - area,
        "edge_tolerance_mm": tolerance,
    }
    if differs > allowed:
        raise LayerError(
            f"OCCT's boolean contradicts itself at radius {used:g} mm: {area:.6g} mm2 in its outline,"
            f" {whole.area:.6g} in its faces, {halves:.6g} in two half-turns"
        )
    strip = differs / length if length else 0.0
    return loops, Certificate(engine=Engine.BOOLEAN, residual=tolerance, jog=jog, checks=checks, contradiction=strip)


def clear_radius(radius: float, critical: Array) -> float:
    """The radius to cut at: the nearest in the same gap between critical radii that is far enough from both of its ends.

    At a critical radius that is the gap outside of it. Where the gap is too narrow for OCCT, the next one outwards that is not.

    Raises
    ------
    LayerError
        If there is none near.
    """
    levels = np.unique(np.concatenate([[-np.inf], np.asarray(critical, dtype=float), [np.inf]]))
    gap = int(np.searchsorted(levels, radius + COINCIDENT, side="right")) - 1
    for low, high in zip(levels[gap:-1], levels[gap + 1 :], strict=True):
        if low > radius + FARTHEST:
            break
        if high - low >= COINCIDENCE_STEP:
            if low + 0.5 * COINCIDENCE_STEP <= radius <= high - 0.5 * COINCIDENCE_STEP:
                return radius
            margin = min(COINCIDENCE_STEP, 0.5 * (high - low))
            return float(np.clip(radius, low + margin, high - margin))
    raise LayerError(f"critical radii stand too close together at radius {radius:.9g} mm for OCCT's boolean")
