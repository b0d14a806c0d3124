"""What each face of a solid says about an axis: the lines that it is turned, or swept like a screw, about.

In: a solid. Out: one AxisVote per face that has an axis (or a centre), in the file's frame, weighted by its area.

Words: *vote*, a line and an area; *recognised*, a surface stored as a B-spline that is a cylinder, cone, sphere or torus
in truth; *screw motion*, a turn with a shift along the axis: surfaces of revolution and helicoids are swept by one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import (
    GeomAbs_Cone,
    GeomAbs_Cylinder,
    GeomAbs_Plane,
    GeomAbs_Sphere,
    GeomAbs_SurfaceOfRevolution,
    GeomAbs_Torus,
)
from OCP.gp import gp_Cone, gp_Cylinder, gp_Pnt, gp_Pnt2d, gp_Sphere, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.IntTools import IntTools_FClass2d
from OCP.ShapeAnalysis import ShapeAnalysis_CanonicalRecognition
from OCP.TopAbs import TopAbs_FACE, TopAbs_IN, TopAbs_ON, TopAbs_REVERSED

from .compat import as_face, sub_shapes

# A B-spline counts as a cylinder, cone or sphere when it lies this near to one (mm): the accuracy that CAD systems export.
RECOGNITION_GAP = 1e-4
# Normals fit a screw motion when the residual of the fit (mm, root mean square) is this small against the face's size ...
SCREW_FIT = 1e-4
# ... and the second-best motion is this many times worse: a plane or a sphere is moved into itself by several.
SCREW_DISTINCT = 30.0
# A face is asked whether it is a cylinder, cone or sphere only where the residual is below this: on the smallest ones the gap
# allowed turns normals by about as much.
NEARLY_SCREW = 0.05
# Points a side that a face is fitted on; where its trimming leaves fewer than so many of them, there are more a side.
SIDE, FEW, FINE_SIDE = 8, 24, 12
ELEMENTARY = (GeomAbs_Cylinder, GeomAbs_Cone, GeomAbs_Torus, GeomAbs_Sphere, GeomAbs_SurfaceOfRevolution)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisVote:
    """One face's say: `point` and `direction` (3,) in mm, its `area` (mm**2), what it `is`.

    `radius` is that of a cylinder (mm), else None; `outward` tells a boss (+1) from a bore (-1); `direction` is None for a
    sphere, which votes for a centre only. `turn` is the angle (rad) that the face covers about the line, 0 where that is not
    known. `exact` votes come from a surface that the file stores as turned; the others are fitted.
    """

    face: int
    point: np.ndarray
    direction: np.ndarray | None
    area: float
    kind: str
    radius: float | None = None
    outward: int = 0
    turn: float = 0.0
    exact: bool = False


def axis_votes(solid: Any) -> list[AxisVote]:
    """The votes of a solid's faces, in the order of the faces."""
    votes = []
    for index, shape in enumerate(sub_shapes(solid, TopAbs_FACE)):
        face = as_face(shape)
        surface = BRepAdaptor_Surface(face, True)
        vote = _elementary(index, surface, face)
        if vote is not None and vote.direction is not None:
            vote = replace(vote, turn=float(surface.LastUParameter() - surface.FirstUParameter()))
        if vote is None and surface.GetType() != GeomAbs_Plane:
            vote = _fitted(index, surface, face)
        if vote is not None:
            votes.append(vote)
    return votes


def surface_kinds(solid: Any) -> dict[str, int]:
    """How many faces there are of each kind of surface."""
    counts: dict[str, int] = {}
    for shape in sub_shapes(solid, TopAbs_FACE):
        name = BRepAdaptor_Surface(as_face(shape), True).GetType().name.removeprefix("GeomAbs_")
        counts[name] = counts.get(name, 0) + 1
    return counts


def area_of(face: Any) -> float:
    """A face's area, mm**2."""
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face, properties)
    return abs(float(properties.Mass()))


def _xyz(thing: Any) -> np.ndarray:
    return np.array([thing.X(), thing.Y(), thing.Z()])


def _vote(index: int, kind: str, axis: Any, area: float, **more: Any) -> AxisVote:
    direction = _xyz(axis.Direction())
    return AxisVote(face=index, point=_xyz(axis.Location()), direction=direction, area=area, kind=kind, **more)


def _elementary(index: int, surface: Any, face: Any) -> AxisVote | None:
    kind = surface.GetType()
    if kind not in ELEMENTARY:
        return None
    area = area_of(face)
    if kind == GeomAbs_Cylinder:
        return _cylinder_vote(index, surface.Cylinder(), area, _outward(surface, face), exact=True)
    if kind == GeomAbs_Cone:
        return _vote(index, "cone", surface.Cone().Axis(), area, exact=True)
    if kind == GeomAbs_Torus:
        return _vote(index, "torus", surface.Torus().Axis(), area, exact=True)
    if kind == GeomAbs_Sphere:
        centre = _xyz(surface.Sphere().Location())
        return AxisVote(face=index, point=centre, direction=None, area=area, kind="sphere")
    if kind == GeomAbs_SurfaceOfRevolution:
        return _vote(index, "revolution", surface.AxeOfRevolution(), area, exact=True)
    return None


def _cylinder_vote(index: int, cylinder: Any, area: float, outward: int, *, exact: bool = False) -> AxisVote:
    return _vote(index, "cylinder", cylinder.Axis(), area, radius=float(cylinder.Radius()), outward=outward, exact=exact)


def _outward(surface: Any, face: Any) -> int:
    """+1 where the metal is inside of a cylinder's face, -1 in a bore: its natural normal points away from the axis if its
    frame is right-handed."""
    sign = 1 if surface.Cylinder().Position().Direct() else -1
    return -sign if face.Orientation() == TopAbs_REVERSED else sign


def _outward_by_normals(cylinder: Any, points: np.ndarray, normals: np.ndarray) -> int:
    direction = _xyz(cylinder.Axis().Direction())
    arm = points - _xyz(cylinder.Axis().Location())
    across = arm - np.outer(arm @ direction, direction)
    return int(np.sign((across * normals).sum()))


def _fitted(index: int, surface: Any, face: Any) -> AxisVote | None:
    """The vote of a face that is not stored as turned: a recognised one, or the screw motion that moves it into itself."""
    points, normals, area = sampled(surface, face, SIDE)
    if len(points) < FEW:
        points, normals, area = sampled(surface, face, FINE_SIDE)
    if len(points) < 8:
        return None
    centre = points.mean(axis=0)
    size = float(np.abs(points - centre).max())
    arm = (points - centre) / size
    rows = np.hstack([np.cross(arm, normals), normals])
    _, values, motions = np.linalg.svd(rows / np.sqrt(len(rows)), full_matrices=False)
    # what no motion moves into itself is no cylinder, cone or sphere either
    found = _recognised(index, face, points, normals) if values[-1] < NEARLY_SCREW else None
    # (the area of a screw's face only weighs its vote: the sum over the points is good to some per cent and costs nothing)
    return found or _screw(index, area, values, motions[-1], centre, size)


def _recognised(index: int, face: Any, points: np.ndarray, normals: np.ndarray) -> AxisVote | None:
    recognition = ShapeAnalysis_CanonicalRecognition(face)
    cylinder, cone, sphere = gp_Cylinder(), gp_Cone(), gp_Sphere()
    if recognition.IsCylinder(RECOGNITION_GAP, cylinder):
        return _cylinder_vote(index, cylinder, area_of(face), _outward_by_normals(cylinder, points, normals))
    if recognition.IsCone(RECOGNITION_GAP, cone):
        return _vote(index, "cone", cone.Axis(), area_of(face))
    if recognition.IsSphere(RECOGNITION_GAP, sphere):
        return AxisVote(face=index, point=_xyz(sphere.Location()), direction=None, area=area_of(face), kind="sphere")
    return None


def sampled(surface: Any, face: Any, count: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Points on the face (inside of its trimming where any are) and outward normals, each (n, 3); their cells' area, mm**2."""
    bounds = (surface.FirstUParameter(), surface.LastUParameter(), surface.FirstVParameter(), surface.LastVParameter())
    inside = IntTools_FClass2d(face, 1e-9)
    sign = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
    steps = (np.arange(count) + 0.5) / count
    points, along_u, along_v, held = [], [], [], []
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for u in (bounds[0] + steps * (bounds[1] - bounds[0])).tolist():
        for v in (bounds[2] + steps * (bounds[3] - bounds[2])).tolist():
            surface.D1(u, v, point, du, dv)
            points.append((point.X(), point.Y(), point.Z()))
            along_u.append((du.X(), du.Y(), du.Z()))
            along_v.append((dv.X(), dv.Y(), dv.Z()))
            held.append(inside.Perform(gp_Pnt2d(u, v)) in (TopAbs_IN, TopAbs_ON))
    normals = np.cross(along_u, along_v)
    size = np.linalg.norm(normals, axis=1)
    chosen = np.array(held) if any(held) else np.ones(len(points), dtype=bool)
    chosen &= size > 0.0
    cell = (bounds[1] - bounds[0]) * (bounds[3] - bounds[2]) / count**2
    return np.array(points)[chosen], sign * normals[chosen] / size[chosen, None], float(size[chosen].sum()) * cell


def _screw(index: int, area: float, values: np.ndarray, motion: np.ndarray, centre: np.ndarray, size: float) -> AxisVote | None:
    """The screw motion whose velocity c' + c x p is tangent to the face: c.(p x n) + c'.n = 0 in least squares."""
    turn = float(np.linalg.norm(motion[:3]))
    if values[-1] > SCREW_FIT or values[-2] < SCREW_DISTINCT * max(values[-1], 1e-9) or turn < 0.05:
        return None
    direction = motion[:3] / turn
    foot = np.cross(motion[:3], motion[3:]) / turn**2
    return AxisVote(face=index, point=centre + size * foot, direction=direction, area=area, kind="screw")
