"""Sections given back as faces on their exact cylinder.

In: loops of one piece in the plane (kappa, v). Out: TopoDS faces whose parameters are (kappa / R, v).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.Geom import Geom_CylindricalSurface
from OCP.Geom2d import Geom2d_BSplineCurve, Geom2d_Line
from OCP.gp import gp_Ax3, gp_Dir2d, gp_Pnt2d
from OCP.ShapeFix import ShapeFix_Shape

from brep_slicer.curves import Curve, LineCurve, Loop, SplineCurve
from brep_slicer.curves.spline import span_nodes, spline_through_nodes
from brep_slicer.errors import LayerError

from .compat import array_of_integers, array_of_points_2d, array_of_reals, as_face

# Sinusoids and quadrics become B-splines this near to themselves, mm; gaps wider than JOINED are bridged by a segment.
NEAR, DEGREE, MOST_SPANS, JOINED = 1e-9, 7, 1024, 1e-7


def face_on_cylinder(radius: float, outer: Loop, holes: tuple[Loop, ...]) -> Any:
    """A TopoDS_Face in the axis frame, bounded by loops that do not wind.

    Raises
    ------
    LayerError
        If OCCT does not make a valid face of them.
    """
    surface = Geom_CylindricalSurface(gp_Ax3(), radius)
    made = BRepBuilderAPI_MakeFace(surface, _wire(surface, outer), True)
    for hole in holes:
        made.Add(_wire(surface, hole))
    if not made.IsDone():
        raise LayerError(f"OCCT makes no face of the section at radius {radius:g} mm")
    face = made.Face()
    BRepLib.BuildCurves3d_s(face, NEAR)
    BRepLib.SameParameter_s(face, 1e-7, True)
    if not BRepCheck_Analyzer(face).IsValid():
        fix = ShapeFix_Shape(face)
        fix.Perform()
        face = as_face(fix.Shape())
    if not BRepCheck_Analyzer(face).IsValid():
        raise LayerError(f"OCCT makes no valid face of the section at radius {radius:g} mm")
    return face


def _wire(surface: Any, loop: Loop) -> Any:
    maker = BRepBuilderAPI_MakeWire()
    curves: list[Curve] = []
    for curve, after in zip(loop.curves, loop.curves[1:] + loop.curves[:1], strict=True):
        curves.append(curve)
        if float(np.hypot(*(after.start - curve.end))) > JOINED:
            curves.append(LineCurve(p0=curve.end, p1=after.start))
    for curve in curves:
        maker.Add(_edge(surface, curve, loop.radius))
    if not maker.IsDone():
        raise LayerError(f"OCCT joins no wire of an outline at radius {loop.radius:g} mm")
    return maker.Wire()


def _edge(surface: Any, curve: Curve, radius: float) -> Any:
    scale = np.array([1.0 / radius, 1.0])
    if isinstance(curve, LineCurve):
        a, b = curve.p0 * scale, curve.p1 * scale
        size = float(np.hypot(*(b - a)))
        line = Geom2d_Line(gp_Pnt2d(*a.tolist()), gp_Dir2d(*((b - a) / size).tolist()))
        return BRepBuilderAPI_MakeEdge(line, surface, 0.0, size).Edge()
    spline = curve if isinstance(curve, SplineCurve) else _as_spline(curve)
    return BRepBuilderAPI_MakeEdge(_geom2d(spline, scale), surface).Edge()


def _geom2d(spline: SplineCurve, scale: np.ndarray) -> Any:
    degree, spans = spline.coefficients.shape[1] - 1, len(spline.coefficients)
    poles = np.concatenate([spline.coefficients[0, :1], spline.coefficients[:, 1:].reshape(-1, 2)]) * scale
    multiplicities = [degree + 1, *([degree] * (spans - 1)), degree + 1]
    return Geom2d_BSplineCurve(
        array_of_points_2d(poles), array_of_reals(spline.breaks), array_of_integers(multiplicities), degree
    )


def _as_spline(curve: Curve) -> SplineCurve:
    """Bezier spans through points of a curve, more of them until they agree in between."""
    x, count = span_nodes(DEGREE), 4
    while True:
        breaks = np.linspace(0.0, 1.0, count + 1)
        at = breaks[:-1, None] + np.diff(breaks)[:, None] * x
        made = spline_through_nodes(curve.points(at.ravel()).reshape(count, DEGREE + 1, 2), breaks)
        between = (0.5 * (at[:, 1:] + at[:, :-1])).ravel()
        if np.hypot(*(made.points(between) - curve.points(between)).T).max() <= NEAR or count >= MOST_SPANS:
            return made
        count *= 2
