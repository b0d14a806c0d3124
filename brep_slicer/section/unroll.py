"""Curves of space that lie on a cylinder about the axis, unrolled.

In: an edge's 3D curve. Out: a Curve of its kind: straight lines along the axis and circles about it become lines, ellipses
become sinusoids, everything else a spline through its points.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.curves import Curve, LineCurve, SinusoidCurve
from brep_slicer.curves.spline import span_nodes, spline_through_nodes, straightened
from brep_slicer.geometry import ConicEdge, EdgeCurve, LineEdge
from brep_slicer.maps import TURN, Array

# A 3D curve counts as a straight line, a circle or an ellipse of the cylinder when its points agree to this (mm).
KIND_RESIDUAL = 1e-9


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
    return LineCurve.between((middle, p[0, 1]), (middle, p[1, 1]))


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
        return LineCurve.between((ends[0], height), (ends[1], height))
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
        made = spline_through_nodes(flat, share, residual=KIND_RESIDUAL)
        t = (breaks[:-1, None] + np.diff(breaks)[:, None] * between[None, :]).ravel()
        true = _near(_unrolled(curve.points(t), radius), made.points((t - first) / (last - first)), radius)
        error = np.abs(true - made.points((t - first) / (last - first))).reshape(len(breaks) - 1, -1).max(axis=1)
        bad = error > KIND_RESIDUAL
        if not bad.any():
            break
        breaks = np.sort(np.concatenate([breaks, 0.5 * (breaks[:-1] + breaks[1:])[bad]]))
    return straightened(made, KIND_RESIDUAL)


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
