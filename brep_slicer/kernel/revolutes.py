"""What each face of a solid says about an axis: the lines that it is turned, or swept like a screw, about.

In: a solid. Out: one AxisVote per face that has an axis (or a centre), in the file's frame, weighted by its area.

Words: *vote*, a line and an area; *recognised*, a surface stored as a B-spline that is a cylinder, cone, sphere or torus
in truth; *screw motion*, a turn with a shift along the axis: surfaces of revolution and helicoids are swept by one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepClass import BRepClass_FaceClassifier
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
from OCP.ShapeAnalysis import ShapeAnalysis_CanonicalRecognition
from OCP.TopAbs import TopAbs_FACE, TopAbs_IN, TopAbs_ON, TopAbs_REVERSED

from .compat import as_face, sub_shapes

# A B-spline counts as a cylinder, cone or sphere when it lies this near to one (mm): the accuracy that CAD systems export.
RECOGNITION_GAP = 1e-4
# Normals fit a screw motion when the residual of the fit (mm, root mean square) is this small against the face's size ...
SCREW_FIT = 1e-4
# ... and the second-best motion is this many times worse: a plane or a sphere is moved into itself by several.
SCREW_DISTINCT = 30.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisVote:
    """One face's say: `point` and `direction` (3,) in mm, its `area` (mm**2), what it `is`.

    `radius` is that of a cylinder (mm), else None; `outward` tells a boss (+1) from a bore (-1); `direction` is None for a
    sphere, which votes for a centre only. `turn` is the angle (rad) that a cylinder's face covers. `exact` votes come from a
    surface that the file stores as turned; the others are fitted.
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
        area = area_of(face)
        vote = _elementary(index, surface, area, face) or _recognised(index, surface, area, face)
        if vote is None and surface.GetType() != GeomAbs_Plane:
            vote = _screw(index, surface, area, face)
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


def _elementary(index: int, surface: Any, area: float, face: Any) -> AxisVote | None:
    kind = surface.GetType()
    if kind == GeomAbs_Cylinder:
        return _cylinder_vote(index, surface.Cylinder(), area, surface, face, exact=True)
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


def _cylinder_vote(index: int, cylinder: Any, area: float, surface: Any, face: Any, *, exact: bool = False) -> AxisVote:
    axis = cylinder.Axis()
    points, normals = sampled(surface, face)
    arm = points - _xyz(axis.Location())
    direction = _xyz(axis.Direction())
    across = arm - np.outer(arm @ direction, direction)
    outward = int(np.sign((across * normals).sum()))
    turn = _covered_turn(across, direction)
    return _vote(index, "cylinder", axis, area, radius=float(cylinder.Radius()), outward=outward, turn=turn, exact=exact)


def _covered_turn(across: np.ndarray, direction: np.ndarray) -> float:
    """The angle round the axis that sampled points cover: a turn less the widest gap between them."""
    helper = np.eye(3)[np.abs(direction).argmin()]
    e1 = np.cross(direction, helper)
    e2 = np.cross(direction, e1)
    angle = np.sort(np.arctan2(across @ e2, across @ e1))
    gaps = np.diff(np.append(angle, angle[0] + 2.0 * np.pi))
    widest = float(gaps.max())
    return 2.0 * np.pi if widest < 0.7 else 2.0 * np.pi - widest


def _recognised(index: int, surface: Any, area: float, face: Any) -> AxisVote | None:
    if surface.GetType() == GeomAbs_Plane:
        return None
    recognition = ShapeAnalysis_CanonicalRecognition(face)
    cylinder, cone, sphere = gp_Cylinder(), gp_Cone(), gp_Sphere()
    if recognition.IsCylinder(RECOGNITION_GAP, cylinder):
        return _cylinder_vote(index, cylinder, area, surface, face)
    if recognition.IsCone(RECOGNITION_GAP, cone):
        return _vote(index, "cone", cone.Axis(), area)
    if recognition.IsSphere(RECOGNITION_GAP, sphere):
        centre = _xyz(sphere.Location())
        return AxisVote(face=index, point=centre, direction=None, area=area, kind="sphere")
    return None


def sampled(surface: Any, face: Any, count: int = 12, *, strict: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Points on the face (inside of its trimming where any are, or always if `strict`) and outward normals, each (n, 3)."""
    bounds = (surface.FirstUParameter(), surface.LastUParameter(), surface.FirstVParameter(), surface.LastVParameter())
    inside = BRepClass_FaceClassifier()
    sign = -1.0 if face.Orientation() == TopAbs_REVERSED else 1.0
    steps = (np.arange(count) + 0.5) / count
    points, along_u, along_v, held = [], [], [], []
    point, du, dv = gp_Pnt(), gp_Vec(), gp_Vec()
    for u in bounds[0] + steps * (bounds[1] - bounds[0]):
        for v in bounds[2] + steps * (bounds[3] - bounds[2]):
            surface.D1(float(u), float(v), point, du, dv)
            points.append((point.X(), point.Y(), point.Z()))
            along_u.append((du.X(), du.Y(), du.Z()))
            along_v.append((dv.X(), dv.Y(), dv.Z()))
            inside.Perform(face, gp_Pnt2d(float(u), float(v)), 1e-9)
            held.append(inside.State() in (TopAbs_IN, TopAbs_ON))
    normals = np.cross(along_u, along_v)
    size = np.linalg.norm(normals, axis=1)
    chosen = np.array(held) if strict or any(held) else np.ones(len(points), dtype=bool)
    chosen &= size > 0.0
    return np.array(points)[chosen], sign * normals[chosen] / size[chosen, None]


def _screw(index: int, surface: Any, area: float, face: Any) -> AxisVote | None:
    """Fit the screw motion whose velocity c' + c x p is tangent to the face: c.(p x n) + c'.n = 0 in least squares."""
    points, normals = sampled(surface, face)
    if len(points) < 8:
        return None
    centre = points.mean(axis=0)
    size = float(np.abs(points - centre).max())
    arm = (points - centre) / size
    rows = np.hstack([np.cross(arm, normals), normals])
    _, values, motions = np.linalg.svd(rows / np.sqrt(len(rows)), full_matrices=False)
    motion = motions[-1]
    turn = float(np.linalg.norm(motion[:3]))
    if values[-1] > SCREW_FIT or values[-2] < SCREW_DISTINCT * max(values[-1], 1e-9) or turn < 0.05:
        return None
    direction = motion[:3] / turn
    foot = np.cross(motion[:3], motion[3:]) / turn**2
    return AxisVote(face=index, point=centre + size * foot, direction=direction, area=area, kind="screw")
