"""OCCT's curves and surfaces as the plain values of `geometry`.

In: OCCT adaptors. Out: EdgeCurve and Surface values in the parametrisation of the adaptor. What has no such form (offsets,
parabolas, hyperbolas) is approximated by a B-spline in the same parameters; the error is appended to a list.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from OCP import GeomAbs
from OCP.GeomAbs import GeomAbs_C1, GeomAbs_C2, GeomAbs_CurveType, GeomAbs_SurfaceType

from brep_slicer.errors import KernelError
from brep_slicer.geometry import (
    BSplineEdge,
    BSplineSurface,
    ConicEdge,
    EdgeCurve,
    ElementarySurface,
    Extrusion,
    LineEdge,
    Revolution,
    Surface,
    SurfaceKind,
)
from brep_slicer.maps import TURN, Array

# Approximated curves and surfaces are asked to lie this near (mm): the accuracy of OCCT's own intersections.
APPROXIMATION = 1e-8
# ... and what they are held against: so many samples each way, which may lie no farther off than this, mm.
SAMPLES, WORST_APPROXIMATION = 11, 1e-5


# Directions are parallel to this (sine of the angle): what is left of a rigid motion's rounding.
PARALLEL = 1e-12


def _vector(thing: Any, dimension: int) -> Array:
    return np.array([thing.X(), thing.Y(), thing.Z()][:dimension] if dimension == 3 else [thing.X(), thing.Y()])


def curve_from_adaptor(adaptor: Any, dimension: int, errors: list[float]) -> EdgeCurve:
    """A curve in space (dimension 3) or in a face's parameters (2)."""
    kind = adaptor.GetType()
    if kind == GeomAbs_CurveType.GeomAbs_Line:
        line = adaptor.Line()
        return LineEdge(origin=_vector(line.Location(), dimension), direction=_vector(line.Direction(), dimension))
    if kind in (GeomAbs_CurveType.GeomAbs_Circle, GeomAbs_CurveType.GeomAbs_Ellipse):
        conic = adaptor.Circle() if kind == GeomAbs_CurveType.GeomAbs_Circle else adaptor.Ellipse()
        major, minor = (
            (conic.Radius(), conic.Radius())
            if kind == GeomAbs_CurveType.GeomAbs_Circle
            else (conic.MajorRadius(), conic.MinorRadius())
        )
        x = _vector(conic.XAxis().Direction(), dimension)
        y = _vector(conic.YAxis().Direction(), dimension)
        return ConicEdge(centre=_vector(conic.Location(), dimension), x=major * x, y=minor * y)
    if kind == GeomAbs_CurveType.GeomAbs_BSplineCurve:
        return _from_bspline(adaptor.BSpline(), dimension)
    if kind == GeomAbs_CurveType.GeomAbs_BezierCurve:
        return _from_bezier(adaptor.Bezier(), dimension)
    return _approximated(adaptor, dimension, errors)


def _approximated(adaptor: Any, dimension: int, errors: list[float]) -> EdgeCurve:
    if dimension == 3:
        from OCP.Approx import Approx_Curve3d

        work = Approx_Curve3d(adaptor, APPROXIMATION, GeomAbs_C2, 200, 12)
        done = work.HasResult()
    else:
        from OCP.Approx import Approx_Curve2d

        first, last = adaptor.FirstParameter(), adaptor.LastParameter()
        work = Approx_Curve2d(adaptor, first, last, APPROXIMATION, APPROXIMATION, GeomAbs_C2, 12, 200)
        done = work.HasResult()
    if not done:
        raise KernelError(f"an edge of kind {adaptor.GetType().name} cannot be read; convert the part to B-splines")
    errors.append(float(work.MaxError()) if dimension == 3 else 0.0)
    return _from_bspline(work.Curve(), dimension)


def _from_bspline(curve: Any, dimension: int) -> BSplineEdge:
    period = 0.0
    if curve.IsPeriodic():
        period = curve.Period()
        curve = curve.Copy()
        curve.SetNotPeriodic()
    count = curve.NbPoles()
    poles = np.array([_vector(curve.Pole(i), dimension) for i in range(1, count + 1)])
    weights = np.array([curve.Weight(i) for i in range(1, count + 1)]) if curve.IsRational() else None
    knots = _flat_knots(curve.NbKnots(), curve.Knot, curve.Multiplicity)
    return BSplineEdge(degree=curve.Degree(), knots=knots, poles=poles, weights=weights, period=period)


def _from_bezier(curve: Any, dimension: int) -> BSplineEdge:
    count = curve.NbPoles()
    poles = np.array([_vector(curve.Pole(i), dimension) for i in range(1, count + 1)])
    weights = np.array([curve.Weight(i) for i in range(1, count + 1)]) if curve.IsRational() else None
    return BSplineEdge(degree=count - 1, knots=_bezier_knots(count - 1), poles=poles, weights=weights)


def _bezier_knots(degree: int) -> Array:
    return np.repeat([0.0, 1.0], degree + 1)


def _flat_knots(count: int, knot: Any, multiplicity: Any) -> Array:
    return np.repeat([knot(i) for i in range(1, count + 1)], [multiplicity(i) for i in range(1, count + 1)])


_ELEMENTARY = {
    GeomAbs_SurfaceType.GeomAbs_Plane: (SurfaceKind.PLANE, "Plane"),
    GeomAbs_SurfaceType.GeomAbs_Cylinder: (SurfaceKind.CYLINDER, "Cylinder"),
    GeomAbs_SurfaceType.GeomAbs_Cone: (SurfaceKind.CONE, "Cone"),
    GeomAbs_SurfaceType.GeomAbs_Sphere: (SurfaceKind.SPHERE, "Sphere"),
    GeomAbs_SurfaceType.GeomAbs_Torus: (SurfaceKind.TORUS, "Torus"),
}


def surface_from_adaptor(adaptor: Any, bounds: tuple[float, float, float, float], errors: list[float]) -> Surface:
    """A face's surface in the frame of the adaptor; what has no form of its own is read within `bounds` (u0, u1, v0, v1)."""
    kind = adaptor.GetType()
    if kind in _ELEMENTARY:
        return _elementary(adaptor, *_ELEMENTARY[kind])
    if kind == GeomAbs_SurfaceType.GeomAbs_BSplineSurface:
        return _bspline_surface(adaptor.BSpline())
    if kind == GeomAbs_SurfaceType.GeomAbs_BezierSurface:
        return _bezier_surface(adaptor.Bezier())
    if kind == GeomAbs_SurfaceType.GeomAbs_SurfaceOfExtrusion:
        basis = adaptor.BasisCurve()
        curve = curve_from_adaptor(basis, 3, errors)
        return Extrusion(curve=curve, direction=_vector(adaptor.Direction(), 3), period=_period(basis))
    if kind == GeomAbs_SurfaceType.GeomAbs_SurfaceOfRevolution:
        basis, axis = adaptor.BasisCurve(), adaptor.AxeOfRevolution()
        return Revolution(
            curve=curve_from_adaptor(basis, 3, errors),
            origin=_vector(axis.Location(), 3),
            axis=_vector(axis.Direction(), 3),
            period=_period(basis),
        )
    return _approximated_surface(adaptor, bounds, errors)


def centred(surface: Surface, noise: float) -> Surface:
    """The surface with its own axis on the frame's, if it lies within `noise` (mm) of it and is parallel."""
    if isinstance(surface, Revolution):
        axis = surface.axis
    elif isinstance(surface, ElementarySurface) and surface.kind is not SurfaceKind.PLANE:
        axis = np.array([0.0, 0.0, 1.0]) if surface.kind is SurfaceKind.SPHERE else surface.frame[2]
    else:
        return surface
    if not 0.0 < float(np.hypot(*surface.origin[:2])) <= noise or float(np.hypot(*axis[:2])) > PARALLEL:
        return surface
    return replace(surface, origin=surface.origin * np.array([0.0, 0.0, 1.0]))


def _period(basis: Any) -> float:
    if basis.GetType() in (GeomAbs.GeomAbs_Circle, GeomAbs.GeomAbs_Ellipse):
        return TURN
    return basis.Period() if basis.IsPeriodic() else 0.0


def _elementary(adaptor: Any, kind: SurfaceKind, getter: str) -> ElementarySurface:
    surface = getattr(adaptor, getter)()
    position = surface.Position()
    frame = np.stack([_vector(getattr(position, name)(), 3) for name in ("XDirection", "YDirection", "Direction")])
    radius = minor = half_angle = 0.0
    if kind is SurfaceKind.TORUS:
        radius, minor = surface.MajorRadius(), surface.MinorRadius()
    elif kind is SurfaceKind.CONE:
        radius, half_angle = surface.RefRadius(), surface.SemiAngle()
    elif kind is not SurfaceKind.PLANE:
        radius = surface.Radius()
    return ElementarySurface(
        kind=kind,
        origin=_vector(position.Location(), 3),
        frame=frame,
        radius=radius,
        minor=minor,
        half_angle=half_angle,
    )


def _bspline_surface(surface: Any) -> BSplineSurface:
    period = [0.0, 0.0]
    if surface.IsUPeriodic() or surface.IsVPeriodic():
        period = [
            surface.UPeriod() if surface.IsUPeriodic() else 0.0,
            surface.VPeriod() if surface.IsVPeriodic() else 0.0,
        ]
        surface = surface.Copy()
        surface.SetUNotPeriodic()
        surface.SetVNotPeriodic()
    poles, weights = _grid(surface)
    return BSplineSurface(
        degrees=(surface.UDegree(), surface.VDegree()),
        knots_u=_flat_knots(surface.NbUKnots(), surface.UKnot, surface.UMultiplicity),
        knots_v=_flat_knots(surface.NbVKnots(), surface.VKnot, surface.VMultiplicity),
        poles=poles,
        weights=weights,
        period=(period[0], period[1]),
    )


def _bezier_surface(surface: Any) -> BSplineSurface:
    poles, weights = _grid(surface)
    degrees = (surface.UDegree(), surface.VDegree())
    return BSplineSurface(
        degrees=degrees,
        knots_u=_bezier_knots(degrees[0]),
        knots_v=_bezier_knots(degrees[1]),
        poles=poles,
        weights=weights,
    )


def _grid(surface: Any) -> tuple[Array, Array | None]:
    rows, columns = range(1, surface.NbUPoles() + 1), range(1, surface.NbVPoles() + 1)
    poles = np.array([[_vector(surface.Pole(i, j), 3) for j in columns] for i in rows])
    if not (surface.IsURational() or surface.IsVRational()):
        return poles, None
    return poles, np.array([[surface.Weight(i, j) for j in columns] for i in rows])


def _approximated_surface(adaptor: Any, bounds: tuple[float, float, float, float], errors: list[float]) -> BSplineSurface:
    from OCP.Geom import Geom_RectangularTrimmedSurface
    from OCP.GeomConvert import GeomConvert_ApproxSurface

    surface = Geom_RectangularTrimmedSurface(adaptor.Surface().Surface().Transformed(adaptor.Trsf()), *bounds)
    # C1: asked for C2 it leaves errors of micrometres that it does not tell
    work = GeomConvert_ApproxSurface(surface, APPROXIMATION, GeomAbs_C1, GeomAbs_C1, 12, 12, 400, 1)
    if not work.HasResult():
        raise KernelError(f"a face of kind {adaptor.GetType().name} cannot be read; convert the part to B-splines")
    made = _bspline_surface(work.Surface())
    grid = np.meshgrid(np.linspace(bounds[0], bounds[1], SAMPLES), np.linspace(bounds[2], bounds[3], SAMPLES))
    u, v = (x.ravel() for x in grid)
    truth = np.array([_vector(adaptor.Value(*uv), 3) for uv in zip(u.tolist(), v.tolist(), strict=True)])
    off = float(np.abs(made.points(np.stack([u, v], axis=1)) - truth).max())
    if not off <= WORST_APPROXIMATION:
        raise KernelError(
            f"a face of kind {adaptor.GetType().name} can be read to {off:.1g} mm only; convert the part to B-splines"
        )
    errors.append(max(float(work.MaxError()), off))
    return made
