"""The `boolean` engine: OCCT's common of a cylinder face and a solid, unrolled from its 3D curves.

In: a solid in the axis frame and a radius. Out: closed loops of unrolled curves, with a certificate.

Words: *step*, how far outside of a coincident face the solid is cut instead (the one-sided limit cannot be taken here);
*second cut*, the same section in two half-turns, whose areas must add up.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from brep_slicer.curves import Curve, LineCurve, Loop, SinusoidCurve
from brep_slicer.curves.spline import span_nodes, spline_through_nodes
from brep_slicer.errors import LayerError
from brep_slicer.geometry import ConicEdge, EdgeCurve, LineEdge
from brep_slicer.maps import TURN, Array

from .certificate import Certificate, Engine
from .chain import Arc, loops_from_arcs

# OCCT's booleans are wrong within about 1e-6 mm of a coincident face (DESIGN section 4): stay ten times farther away.
COINCIDENCE_STEP = 1e-5
# What OCCT aims at for its intersection curves, mm; an edge whose tolerance says more is believed.
INTERSECTION_RESIDUAL = 1e-7
# Two areas may differ by the tolerance of every edge along its length, in each of the two cuts.
CUTS = 2.0
# A 3D curve counts as a straight line, a circle or an ellipse of the cylinder when its points agree to this (mm).
KIND_RESIDUAL = 1e-9


def section_by_boolean(solid: Any, radius: float, *, critical: Array, seam: float = 0.4142) -> tuple[list[Loop], Certificate]:
    """Cut one solid.

    Parameters
    ----------
    solid : TopoDS_Solid
        In the axis frame, mm.
    radius : float
        Radius of the cut, mm.
    critical : ndarray, shape (n,)
        The solid's critical radii, mm; near one of them the cut steps outwards.
    seam : float
        Angle (rad) of the cylinder face's own seam; any will do that no edge of the part follows.

    Raises
    ------
    LayerError
        If the boolean fails, or its checks do.
    """
    from brep_slicer.kernel.booleans import common_with_cylinder, height_range

    used, residual = _clear_radius(radius, critical)
    low, high = height_range(solid)
    margin = 1.0 + 0.01 * (high - low)
    heights = (low - margin, high + margin)
    whole = common_with_cylinder(solid, used, seam=seam, turn=TURN, heights=heights)
    arcs = [
        Arc(curve=curve_on_cylinder(u.curve, u.first, u.last, used, forward=u.forward), start=u.start, end=u.end)
        for u in whole.uses
    ]
    loops = loops_from_arcs(used, arcs)
    area, length = sum(loop.signed_area() for loop in loops), sum(loop.length() for loop in loops)
    halves = sum(
        common_with_cylinder(solid, used, seam=seam + 1.0 + k * math.pi, turn=math.pi, heights=heights).area for k in (0, 1)
    )
    tolerance = max((u.tolerance for u in whole.uses), default=INTERSECTION_RESIDUAL)
    jog = max((loop.jog() for loop in loops), default=0.0)
    allowed = CUTS * length * (max(tolerance, INTERSECTION_RESIDUAL) + jog) + 1e-9 * area
    checks: dict[str, bool | float | str] = {
        "area_of_half_turns_mm2": halves - area,
        "area_of_occt_face_mm2": whole.area - area,
        "tolerances_unchanged": True,
    }
    if abs(halves - area) > allowed or abs(whole.area - area) > allowed:
        raise LayerError(
            f"OCCT's boolean contradicts itself at radius {radius:g} mm: {area:.6g} mm2 in its outline,"
            f" {whole.area:.6g} in its faces, {halves:.6g} in two half-turns"
        )
    certificate = Certificate(
        engine=Engine.BOOLEAN, residual=max(residual, tolerance), jog=jog, checks=checks, coincident=used != radius
    )
    return [loop.on_radius(radius) for loop in loops], certificate


def _clear_radius(radius: float, critical: Array) -> tuple[float, float]:
    """The radius to cut at, and the residual: stepped outwards until no critical radius is near."""
    used = radius
    while np.any(np.abs(np.asarray(critical) - used) < 0.5 * COINCIDENCE_STEP):
        used += COINCIDENCE_STEP
    return used, math.sqrt(2.0 * radius * (used - radius)) if used != radius else INTERSECTION_RESIDUAL


def curve_on_cylinder(curve: EdgeCurve, first: float, last: float, radius: float, *, forward: bool) -> Curve:
    """Unroll a 3D curve that lies on the cylinder of `radius`, keeping its kind where it has one."""
    made = None
    if isinstance(curve, LineEdge):
        made = _ruling(curve, first, last, radius)
    elif isinstance(curve, ConicEdge):
        made = _conic(curve, first, last, radius)
    if made is None:
        made = _sampled_curve(curve, first, last, radius)
    return made if forward else made.reversed()


def _unrolled(points: Array, radius: float) -> Array:
    theta = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    return np.stack([radius * theta, points[:, 2]], axis=1)


def _ruling(curve: LineEdge, first: float, last: float, radius: float) -> Curve:
    p = _unrolled(curve.points(np.array([first, last])), radius)
    middle = float(p[:, 0].mean())
    return LineCurve(p0=(middle, p[0, 1]), p1=(middle, p[1, 1]))


def _conic(curve: ConicEdge, first: float, last: float, radius: float) -> Curve | None:
    """A circle about the axis (a line v = const) or an ellipse in an oblique plane (a sinusoid)."""
    points = curve.points(np.linspace(first, last, 17))
    off = np.abs(np.hypot(points[:, 0], points[:, 1]) - radius).max()
    if off > max(KIND_RESIDUAL, 1e-12 * radius) * 100.0:
        return None
    flat = _unrolled(points, radius)
    ends = (float(flat[0, 0]), float(flat[-1, 0]))
    normal = np.cross(curve.x, curve.y)
    normal = normal / np.linalg.norm(normal)
    if abs(abs(normal[2]) - 1.0) < 1e-15:
        height = float(curve.centre[2])
        return LineCurve(p0=(ends[0], height), p1=(ends[1], height))
    a, b, n = normal
    coefficients = (float(normal @ curve.centre) / n, -a * radius / n, -b * radius / n)
    return SinusoidCurve(coefficients=np.array(coefficients), radius=radius, range=ends)


def _sampled_curve(curve: EdgeCurve, first: float, last: float, radius: float) -> Curve:
    """Bezier spans of degree 7 through points of the curve, halved until the points between agree too."""
    breaks = curve.breaks(first, last)
    nodes = span_nodes(7)
    between = 0.5 * (nodes[:-1] + nodes[1:])
    for _ in range(8):
        t = (breaks[:-1, None] + np.diff(breaks)[:, None] * nodes[None, :]).ravel()
        flat = _unrolled(curve.points(t), radius).reshape(len(breaks) - 1, len(nodes), 2)
        flat = _joined(flat, radius)
        share = (breaks - first) / (last - first)
        made = spline_through_nodes(flat, share, residual=INTERSECTION_RESIDUAL)
        t = (breaks[:-1, None] + np.diff(breaks)[:, None] * between[None, :]).ravel()
        true = _near(_unrolled(curve.points(t), radius), made.points((t - first) / (last - first)), radius)
        error = np.abs(true - made.points((t - first) / (last - first))).reshape(len(breaks) - 1, -1).max(axis=1)
        bad = error > KIND_RESIDUAL
        if not bad.any():
            break
        breaks = np.sort(np.concatenate([breaks, 0.5 * (breaks[:-1] + breaks[1:])[bad]]))
    return _straight(made)


def _joined(flat: Array, radius: float) -> Array:
    """Spans unwrapped one after the other (points are dense enough that neighbours are less than half a turn apart)."""
    chain = flat.reshape(-1, 2).copy()
    chain[:, 0] = radius * np.unwrap(chain[:, 0] / radius)
    out = chain.reshape(flat.shape)
    out[1:, 0] = out[:-1, -1]
    return out


def _near(points: Array, guide: Array, radius: float) -> Array:
    period = TURN * radius
    points = points.copy()
    points[:, 0] += period * np.round((guide[:, 0] - points[:, 0]) / period)
    return points


def _straight(curve: Curve) -> Curve:
    """A spline whose control points lie on a straight line is that line."""
    p = curve.coefficients.reshape(-1, 2)
    along = p[-1] - p[0]
    size = float(np.hypot(*along))
    if size == 0.0:
        return curve
    off = np.abs(along[0] * (p[:, 1] - p[0, 1]) - along[1] * (p[:, 0] - p[0, 0])) / size
    forward = np.diff(p @ along) >= -KIND_RESIDUAL * size
    if off.max() <= 10.0 * KIND_RESIDUAL and forward.all():
        return LineCurve(p0=p[0], p1=p[-1])
    return curve
