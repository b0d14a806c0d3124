"""Curves of space that lie on a layer's sheet, unrolled.

In: an edge's 3D curve. Out: a Curve of its kind: on a cylinder, straight lines along the axis and circles about it become
lines, ellipses become sinusoids; everything else a spline through its points, or a line where those lie on one.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.curves import Curve, LineCurve, SinusoidCurve
from brep_slicer.curves.spline import span_nodes, spline_through_nodes, straightened
from brep_slicer.geometry import ConicEdge, EdgeCurve, LineEdge
from brep_slicer.layers import CYLINDERS, Sheet

# A 3D curve counts as a straight line, a circle or an ellipse of the cylinder when its points agree to this (mm).
KIND_RESIDUAL = 1e-9


def curve_on_sheet(curve: EdgeCurve, first: float, last: float, sheet: Sheet, *, forward: bool) -> Curve:
    """Unroll a 3D curve that lies on a sheet, keeping its kind where it has one."""
    made = None
    if sheet.family == CYLINDERS and isinstance(curve, LineEdge):
        made = _ruling(curve, first, last, sheet)
    elif sheet.family == CYLINDERS and isinstance(curve, ConicEdge):
        made = _conic(curve, first, last, sheet)
    if made is None:
        made = _sampled_curve(curve, first, last, sheet)
    return made if forward else made.reversed()


def _ruling(curve: LineEdge, first: float, last: float, sheet: Sheet) -> Curve:
    p = sheet.flat_along(curve.points(np.array([first, last])))
    middle = float(p[:, 0].mean())
    return LineCurve.between((middle, p[0, 1]), (middle, p[1, 1]))


def _conic(curve: ConicEdge, first: float, last: float, sheet: Sheet) -> Curve | None:
    """A circle about the axis (a line v = const) or an ellipse in an oblique plane (a sinusoid)."""
    points, radius = curve.points(np.linspace(first, last, 17)), sheet.radius
    off = np.abs(sheet.family.value(points) - radius).max()
    if off > max(KIND_RESIDUAL, 1e-12 * radius) * 100.0:
        return None
    flat = sheet.flat_along(points)
    ends = (float(flat[0, 0]), float(flat[-1, 0]))
    normal = np.cross(curve.x, curve.y)
    normal = normal / np.linalg.norm(normal)
    if abs(abs(normal[2]) - 1.0) < 1e-15:
        height = float(curve.centre[2])
        return LineCurve.between((ends[0], height), (ends[1], height))
    a, b, n = normal
    coefficients = (float(normal @ curve.centre) / n, -a * radius / n, -b * radius / n)
    return SinusoidCurve(coefficients=np.array(coefficients), radius=radius, range=ends)


def _sampled_curve(curve: EdgeCurve, first: float, last: float, sheet: Sheet) -> Curve:
    """Bezier spans of degree 7 through points of the curve, halved until the points between agree too."""
    breaks = curve.breaks(first, last)
    nodes = span_nodes(7)
    between = 0.5 * (nodes[:-1] + nodes[1:])
    for _ in range(8):
        t = breaks[:-1, None] + np.diff(breaks)[:, None] * nodes[None, :]
        # neighbouring spans meet in one point
        flat = sheet.flat_along(curve.points(t.ravel())).reshape(len(breaks) - 1, len(nodes), 2)
        flat[1:, 0] = flat[:-1, -1]
        made = spline_through_nodes(flat, (breaks - first) / (last - first), residual=KIND_RESIDUAL)
        t = (breaks[:-1, None] + np.diff(breaks)[:, None] * between[None, :]).ravel()
        guide = made.points((t - first) / (last - first))
        true = sheet.flat_from_space(curve.points(t))
        true = sheet.closure.moved(true, sheet.closure.nearest_turns(true, guide))
        bad = np.abs(true - guide).reshape(len(breaks) - 1, -1).max(axis=1) > KIND_RESIDUAL
        if not bad.any():
            break
        breaks = np.sort(np.concatenate([breaks, 0.5 * (breaks[:-1] + breaks[1:])[bad]]))
    return straightened(made, KIND_RESIDUAL)
