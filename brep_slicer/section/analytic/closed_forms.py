"""Faces whose level sets have a closed form: rulings along the axis, circles about it, sinusoids.

In: a face, its nodes, the radii. Out: FaceArcs: curves from node to node, and circles that meet no edge.

Words: *ruling*, a line kappa = const (planes, cylinders and extrusions parallel to the axis); *circle*, a line v = const
(planes across the axis, coaxial surfaces of revolution).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from brep_slicer.curves import ArcCurve, Curve, LineCurve, SinusoidCurve
from brep_slicer.field import SNAP
from brep_slicer.geometry import Brep, ElementarySurface, Extrusion, Face, Revolution, SurfaceKind
from brep_slicer.layers import CYLINDERS, Cones, LayerFamily, Planes, Sheet
from brep_slicer.maps import TURN, Array

from .face_nodes import FaceNodes, clusters, pair_along
from .profiles import places_on_profile

# Directions are parallel to this (sine of the angle): what is left of a rigid motion's rounding.
PARALLEL = 1e-12
# A plane whose normal has less than this along the axis is traced: v as a function of kappa would lose that many digits.
STEEP = 1e-3
# Lines of one layer nearer to each other than this (mm, or rad times mm) are one: above the noise of real edges.
SAME_LINE = 1e-5
# Nodes nearer to each other than this (rad) round the axis are at one place.
SAME_ANGLE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceArcs:
    """Curves on one face, each with its layer, start node and end node (-1 for closed ones), and the layers that failed."""

    curves: list[Curve] = field(default_factory=list)
    layer: list[int] = field(default_factory=list)
    start: list[int] = field(default_factory=list)
    end: list[int] = field(default_factory=list)
    failed: dict[int, str] = field(default_factory=dict)
    residual: dict[int, float] = field(default_factory=dict)

    def add(self, curve: Curve, layer: int, start: int, end: int) -> None:
        """One more."""
        self.curves.append(curve)
        self.layer.append(layer)
        self.start.append(start)
        self.end.append(end)

    def extend(self, other: FaceArcs) -> None:
        """All of another's."""
        for name in ("curves", "layer", "start", "end"):
            getattr(self, name).extend(getattr(other, name))
        self.failed.update(other.failed)
        self.residual.update(other.residual)


Solver = Callable[[Face, FaceNodes, Array], FaceArcs]


def closed_form_of(face: Face, family: LayerFamily) -> Solver | None:
    """The solver for a face's kind of surface and its place to the axis, or None if there is no closed form here.

    Spheres have a module of their own.
    """
    if family == CYLINDERS:
        return _form_on_cylinders(face)
    if isinstance(family, Cones) and is_round(face):
        return partial(_rings_on_cones, family)
    along = _generator(face)
    if isinstance(family, Planes) and along is not None and abs(float(along @ np.array(family.normal))) <= PARALLEL:
        return partial(_rulings_in_planes, family, along)
    return None


def _generator(face: Face) -> Array | None:
    """The direction (3,) of a cylinder's or an extrusion's rulings; None for other faces."""
    surface = face.surface
    if isinstance(surface, ElementarySurface) and surface.kind is SurfaceKind.CYLINDER:
        return np.asarray(surface.frame[2])
    if isinstance(surface, Extrusion):
        return np.asarray(surface.direction / np.linalg.norm(surface.direction))
    return None


def is_round(face: Face) -> bool:
    """Whether a face is part of a surface of revolution about the axis, planes across it among them."""
    surface = face.surface
    if isinstance(surface, ElementarySurface):
        across, off = float(np.hypot(*surface.frame[2, :2])), float(np.hypot(*surface.origin[:2]))
        if surface.kind is SurfaceKind.PLANE:
            return across <= PARALLEL
        return off <= 1e-9 and (across <= PARALLEL or surface.kind is SurfaceKind.SPHERE)
    if isinstance(surface, Revolution):
        return float(np.hypot(*surface.axis[:2])) <= PARALLEL and float(np.hypot(*surface.origin[:2])) <= 1e-9
    return False


def _form_on_cylinders(face: Face) -> Solver | None:
    surface = face.surface
    if isinstance(surface, ElementarySurface):
        across = float(np.hypot(*surface.frame[2, :2]))
        coaxial = across <= PARALLEL and float(np.hypot(*surface.origin[:2])) <= 1e-9
        if surface.kind is SurfaceKind.PLANE:
            return _on_plane(across, abs(float(surface.frame[2, 2])))
        if coaxial and surface.kind is not SurfaceKind.SPHERE:
            return _circles_of_revolution
        if surface.kind is SurfaceKind.CYLINDER and across <= PARALLEL:
            return _rulings_on_cylinder
    if isinstance(surface, Extrusion) and float(np.hypot(*surface.direction[:2])) <= PARALLEL:
        return _rulings_on_extrusion
    if isinstance(surface, Revolution):
        across, off = float(np.hypot(*surface.axis[:2])), float(np.hypot(*surface.origin[:2]))
        if across <= PARALLEL and off <= 1e-9:
            return _circles_of_revolution
    return None


def _on_plane(across: float, along: float) -> Solver | None:
    """By the components of a plane's normal across the axis and along it."""
    if across <= PARALLEL:
        return _circles_on_plane
    if along <= PARALLEL:
        return _rulings_on_plane
    return _sinusoids if along >= STEEP else None


def outward_normals(face: Face, uv: Array) -> Array:
    """Unit normals (n, 3) that point out of the solid."""
    _, su, sv = face.surface.derivatives(uv)
    normal = face.sign * np.cross(su, sv)
    return normal / np.maximum(np.linalg.norm(normal, axis=1), 1e-300)[:, None]


def _centre_normal(face: Face) -> Array:
    return outward_normals(face, face.box.mean(axis=0)[None, :])[0]


def _fail(arcs: FaceArcs, layers: Array, face: Face) -> None:
    for layer in layers.tolist():
        arcs.failed[layer] = f"the crossings on face {face.index} do not pair up"


def _rulings(face: Face, found: FaceNodes, radii: Array, component: Array, way: Array, theta: Array) -> FaceArcs:
    """Arcs along lines kappa = const; `way` (n,) is +1 where the section runs upwards, `theta` (n,) the line's angle."""
    pairs = pair_along(found, component, way * found.height, cyclic=False)
    arcs = FaceArcs()
    _fail(arcs, pairs.bad, face)
    kappa = radii[found.layer] * theta
    for i, j in zip(pairs.start.tolist(), pairs.end.tolist(), strict=True):
        curve = LineCurve.between((kappa[i], found.height[i]), (kappa[i], found.height[j]), face=face.index)
        arcs.add(curve, int(found.layer[i]), int(found.node[i]), int(found.node[j]))
    return arcs


def _two_lines(found: FaceNodes, radii: Array, middle: float, cosine: Array) -> tuple[Array, Array]:
    """Side (+1, -1) and angle of the two lines at middle +- acos(cosine)."""
    side = np.where(np.mod(found.theta - middle + np.pi, TURN) >= np.pi, 1.0, -1.0)
    return side, middle + side * np.arccos(np.clip(cosine, -1.0, 1.0))


def _rulings_on_plane(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    normal = _centre_normal(face)
    assert isinstance(face.surface, ElementarySurface)
    distance = float(normal @ face.surface.origin)
    middle = float(np.arctan2(normal[1], normal[0]))
    side, theta = _two_lines(found, radii, middle, distance / radii[found.layer])
    # T_v = n . e_theta = -sin(theta - middle)
    return _rulings(face, found, radii, side, -side, theta)


def _rulings_on_cylinder(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    surface = face.surface
    assert isinstance(surface, ElementarySurface)
    r = radii[found.layer]
    offset = float(np.hypot(*surface.origin[:2]))
    middle = float(np.arctan2(surface.origin[1], surface.origin[0]))
    side, theta = _two_lines(found, radii, middle, (r * r + offset**2 - surface.radius**2) / (2.0 * r * offset))
    centre = face.box.mean(axis=0)[None, :]
    away = surface.points(centre)[0] - surface.origin
    outward = np.sign(away[:2] @ outward_normals(face, centre)[0, :2])
    return _rulings(face, found, radii, side, outward * side, theta)


def _rulings_on_extrusion(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    surface = face.surface
    assert isinstance(surface, Extrusion)
    # the ruling is solved on the face: edges lie off it, by up to their tolerance, and so would its theta
    places = places_on_profile(surface.curve, face.box[:, 0], found.uv[:, 0], found.layer, radii[found.layer])
    normal = outward_normals(face, np.stack([places.parameter, found.uv[:, 1]], axis=1))
    theta = np.arctan2(places.point[:, 1], places.point[:, 0])
    along = -np.sin(theta) * normal[:, 0] + np.cos(theta) * normal[:, 1]
    return _rulings(face, found, radii, places.number, np.sign(along), theta)


def _rulings_in_planes(family: Planes, along: Array, face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    """Rulings in layers that are planes parallel to them."""
    surface, level = face.surface, radii[found.layer]
    points = surface.points(found.uv)
    if isinstance(surface, Extrusion):
        component = places_on_profile(surface.curve, face.box[:, 0], found.uv[:, 0], found.layer, level, family).number
    else:
        assert isinstance(surface, ElementarySurface)
        x, y = surface.frame[:2] @ np.array(family.normal)
        component = np.where(np.mod(found.uv[:, 0] - np.arctan2(y, x), TURN) < np.pi, 1.0, -1.0)
    # the section runs along T = grad c x n
    way = np.sign(np.cross(np.array(family.normal), outward_normals(face, found.uv)) @ along)
    pairs = pair_along(found, component, way * (points @ along), cyclic=False)
    arcs = FaceArcs()
    _fail(arcs, pairs.bad, face)
    flat = family.flat_from_space(points, 0.0)
    for i, j in zip(pairs.start.tolist(), pairs.end.tolist(), strict=True):
        arcs.add(
            LineCurve(p0=flat[i], p1=flat[j], face=face.index), int(found.layer[i]), int(found.node[i]), int(found.node[j])
        )
    return arcs


def arcs_round(face: Face, found: FaceNodes, radii: Array, component: Array, way: Array, make) -> FaceArcs:
    """Arcs along curves that go round the axis; `way` (n,) is +1 where theta rises along the section."""
    pairs = pair_along(found, component, way * found.theta, cyclic=True)
    arcs = FaceArcs()
    _fail(arcs, pairs.bad, face)
    turn = np.mod(way[pairs.start] * (found.theta[pairs.end] - found.theta[pairs.start]), TURN)
    # two nodes at one place (a corner that the layer just touches) are no full turn apart, whatever rounding says
    turn = np.where(turn > TURN - SAME_ANGLE, 0.0, turn)
    turn = np.where(found.node[pairs.start] == found.node[pairs.end], TURN, turn)
    theta0 = found.theta[pairs.start]
    theta1 = theta0 + way[pairs.start] * turn
    for k, (i, j) in enumerate(zip(pairs.start.tolist(), pairs.end.tolist(), strict=True)):
        layer = int(found.layer[i])
        arcs.add(make(layer, i, float(theta0[k]), float(theta1[k])), layer, int(found.node[i]), int(found.node[j]))
    return arcs


def _line_at(face: Face, radii: Array, height: Array):
    def make(layer: int, row: int, theta0: float, theta1: float) -> Curve:
        r, v = float(radii[layer]), float(height[row])
        return LineCurve.between((r * theta0, v), (r * theta1, v), face=face.index)

    return make


def _circles_on_plane(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    surface = face.surface
    assert isinstance(surface, ElementarySurface)
    way = -np.sign(_centre_normal(face)[2])
    height = np.full(len(found), surface.origin[2])
    return arcs_round(face, found, radii, np.zeros(len(found)), np.full(len(found), way), _line_at(face, radii, height))


def _rings_on_cones(family: Cones, face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    """Rings about the axis on layers that are cones: arcs about the apex."""
    component, height = _clustered(found)
    normal, points = outward_normals(face, found.uv), face.surface.points(found.uv)
    # T = grad c x n runs along theta where n points to smaller heights
    up = family.along_generators(points, normal)
    way = -np.sign(up)

    def make(layer: int, row: int, theta0: float, theta1: float) -> Curve:
        return ring_on_cone(family.sheet(float(radii[layer])), float(height[row]), theta0 / TURN, theta1 / TURN, face.index)

    return arcs_round(face, found, radii, component, way, make)


def ring_on_cone(sheet: Sheet, height: float, first: float, last: float, face: int) -> ArcCurve:
    """The ring at a height of a cone's sheet, from `first` to `last` (turns)."""
    closure, way = sheet.closure, math.copysign(1.0, last - first)
    round_once = float(closure.ring_lengths(np.array(height)))
    heading = closure.heading_of_ring(first) + (0.0 if way > 0.0 else math.pi)
    return ArcCurve(
        origin=closure.at(np.array(first), np.array(height)),
        heading=heading,
        size=round_once * abs(last - first),
        curvature=-way * closure.angle / round_once,
        face=face,
    )


def _circles_of_revolution(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    surface, uv = face.surface, found.uv
    if isinstance(surface, Revolution):
        places = places_on_profile(surface.curve, face.box[:, 1], uv[:, 1], found.layer, radii[found.layer])
        component, height = places.number, places.point[:, 2]
        uv = np.stack([uv[:, 0], places.parameter], axis=1)
    elif surface.kind is SurfaceKind.TORUS:
        component, height, v = _on_torus(face, found, radii)
        uv = np.stack([uv[:, 0], v], axis=1)
    else:
        component, height = _heights(face, found, radii)
    way = -np.sign(outward_normals(face, uv)[:, 2])
    return arcs_round(face, found, radii, component, way, _line_at(face, radii, height))


def _heights(face: Face, found: FaceNodes, radii: Array) -> tuple[Array, Array]:
    """Which circle of its layer each node lies on, and the circle's height: by the profile where it has a formula."""
    surface, r = face.surface, radii[found.layer]
    assert isinstance(surface, ElementarySurface)
    if surface.kind is SurfaceKind.CYLINDER:
        return _clustered(found)
    base, up = surface.origin[2], surface.frame[2, 2]
    # on the other nappe, beyond the apex, the cone's own radius is negative
    rises = [(side * r - surface.radius) / np.tan(surface.half_angle) for side in (1.0, -1.0)]
    return _nearest(base + up * np.stack(rises), found.height)


def _on_torus(face: Face, found: FaceNodes, radii: Array) -> tuple[Array, Array, Array]:
    """The same, and the circle's own v: of the face's own circles the nearest, for where a fillet is tangent to the layer its
    surface has another one just as near on the far side of its edge."""
    surface, r = face.surface, radii[found.layer]
    assert isinstance(surface, ElementarySurface)
    # a torus may be so thick that it crosses its own axis: its inner part has the profile -(major + minor cos v)
    cosines = [(side * r - surface.radius) / surface.minor for side in (1.0, -1.0)]
    v = np.stack([way * np.arccos(np.clip(c, -1.0, 1.0)) for c in cosines for way in (1.0, -1.0)])
    heights = surface.origin[2] + surface.frame[2, 2] * surface.minor * np.sin(v)
    first, last = face.box[:, 1]
    inside = np.mod(v - first + SAME_ANGLE, TURN) <= last - first + 2.0 * SAME_ANGLE
    away = np.where(inside | ~inside.any(axis=0), np.abs(heights - found.height), np.inf)
    nearest, rows = away.argmin(axis=0), np.arange(len(r))
    return nearest, heights[nearest, rows], v[nearest, rows]


def _clustered(found: FaceNodes) -> tuple[Array, Array]:
    """Nodes of about one height on one circle, at the height of its first node: one line v = const."""
    component = clusters(found.layer, found.height, SAME_LINE)
    _, first, where = np.unique(component, return_index=True, return_inverse=True)
    return component, found.height[first][where]


def _nearest(heights: Array, z: Array) -> tuple[Array, Array]:
    """Of several heights (m, n) the number and the value of the one next to each z (n,)."""
    nearest = np.abs(heights - z).argmin(axis=0)
    return nearest, heights[nearest, np.arange(len(z))]


def _sinusoids(face: Face, found: FaceNodes, radii: Array) -> FaceArcs:
    normal = _centre_normal(face)
    way = -np.sign(normal[2])

    def make(layer: int, row: int, theta0: float, theta1: float) -> Curve:
        return sinusoid_on_plane(face, float(radii[layer]), theta0, theta1)

    return arcs_round(face, found, radii, np.zeros(len(found)), np.full(len(found), way), make)


def sinusoid_on_plane(face: Face, radius: float, theta0: float, theta1: float) -> SinusoidCurve:
    """The section of an oblique plane with the cylinder, from theta0 to theta1."""
    assert isinstance(face.surface, ElementarySurface)
    a, b, n = _centre_normal(face)
    c = float(_centre_normal(face) @ face.surface.origin)
    coefficients = np.array([c / n, -a * radius / n, -b * radius / n])
    return SinusoidCurve(coefficients=coefficients, radius=radius, range=(radius * theta0, radius * theta1), face=face.index)


def loops_on_planes(
    brep: Brep, face: Face, radii: Array, busy: set[int], level: Array, vertex_rho: Array, family: LayerFamily
) -> FaceArcs:
    """Circles and sinusoids that lie on a plane face and meet none of its edges, in the layers that are not `busy`.

    The curve at R lies on the face if the face's loops outside of R wind round the axis (an outline without a hole inside
    of R, or one hole less than outlines).
    """
    arcs = FaceArcs()
    normal = _centre_normal(face)
    if (
        not isinstance(face.surface, ElementarySurface)
        or face.surface.kind is not SurfaceKind.PLANE
        or abs(normal[2]) <= PARALLEL
        or len(busy) == len(radii)
    ):
        return arcs
    loops = [_lowest_and_winding(brep, loop, level, vertex_rho) for loop in face.loops]
    if not any(winding for _, winding in loops):
        return arcs
    for layer, radius in enumerate(radii.tolist()):
        if layer in busy:
            continue
        around = sum(winding for low, winding in loops if low > radius + SNAP)
        if around == 0:
            continue
        way = -np.sign(normal[2])
        if isinstance(family, Cones) and family != CYLINDERS:
            sheet = family.sheet(radius)
            rho = (radius - math.sin(family.half_angle) * float(face.surface.origin[2])) / math.cos(family.half_angle)
            # beyond the apex there is no sheet
            if rho <= 0.0:
                continue
            height = float(family.heights(np.array([rho, 0.0, float(face.surface.origin[2])])))
            arcs.add(ring_on_cone(sheet, height, 0.0, float(way), face.index), layer, -1, -1)
            continue
        curve = sinusoid_on_plane(face, radius, 0.0, way * TURN)
        if np.hypot(*curve.coefficients[1:]) <= 1e-12 * radius:
            v = float(face.surface.origin[2])
            arcs.add(LineCurve.between((0.0, v), (way * TURN * radius, v), face=face.index), layer, -1, -1)
        else:
            arcs.add(curve, layer, -1, -1)
    return arcs


def _lowest_and_winding(brep: Brep, loop, level: Array, vertex_rho: Array) -> tuple[float, int]:
    """Lowest effective radius of a loop's vertices and level edges, and how often it goes round the axis."""
    radii, theta = [], []
    for use in loop:
        edge = brep.edges[use.edge]
        radii += [vertex_rho[v] for v in edge.vertices]
        if np.isfinite(level[use.edge]):
            radii.append(level[use.edge])
        if edge.curve is None:
            continue
        t = np.linspace(edge.first, edge.last, 65)
        p = edge.curve.points(t if use.forward else t[::-1])
        theta.append(np.arctan2(p[:, 1], p[:, 0]))
    chain = np.concatenate(theta) if theta else np.zeros(1)
    total = np.unwrap(np.append(chain, chain[0]))
    return min(radii), round(float(total[-1] - total[0]) / TURN)
