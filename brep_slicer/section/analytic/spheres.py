"""Spheres in any position: where a cylinder cuts one is known, whatever way its poles and its seam lie.

In: a face on a sphere, its nodes, the radii. Out: FaceArcs: curves from node to node, and whole ones that meet no edge.

Words: *oval*, the section of a sphere that the cylinder leaves on one side, w**2 = 4 R d sin((h + x) / 2) sin((h - x) / 2) at
the angle x from the centre's own, the height w over it, d the centre's distance from the axis; *ring*, one of the two that go
round the axis where the sphere holds the whole cylinder.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from brep_slicer.curves import Curve, LineCurve, QuadricCurve
from brep_slicer.field import SNAP
from brep_slicer.geometry import ElementarySurface, Face
from brep_slicer.geometry.trimming import trimming_of
from brep_slicer.maps import TURN, Array

from .closed_forms import SAME_ANGLE, FaceArcs, arcs_round, outward_normals
from .face_nodes import FaceNodes, pair_along

# A centre as near to the axis as this (mm) lies on it: rings are circles there.
ON_AXIS = 1e-9
# Beyond this share of an oval's half width its points are placed by their height, which loses no digits there.
STEEP_FROM = 0.7
# Points by which a curve that meets no edge is held against the face's outline; Newton's steps to an oval's end.
SAMPLES, STEPS = 48, 8


class _Sphere:
    """A face's sphere about the axis: `d` and `phi` of its centre, `z`, `r`; `out` is +1 where the metal is inside of it."""

    def __init__(self, face: Face) -> None:
        surface = face.surface
        assert isinstance(surface, ElementarySurface)
        self.face, self.surface, self.origin = face, surface, surface.origin
        self.d, self.phi = float(np.hypot(*self.origin[:2])), float(np.arctan2(self.origin[1], self.origin[0]))
        self.z, self.r = float(self.origin[2]), surface.radius
        middle = face.box.mean(axis=0)[None]
        self.out = float(np.sign((surface.points(middle)[0] - self.origin) @ outward_normals(face, middle)[0]))

    def meets(self, radii: Array) -> NDArray[np.bool_]:
        """Which layers (n,) cut it: the one-sided limit from outside."""
        return (radii < self.d + self.r - SNAP) & (radii > self.d - self.r + SNAP)

    def rings(self, radii: Array) -> NDArray[np.bool_]:
        """Which of the layers that cut it are rings; where two meet in a point they count as an oval."""
        return radii + self.d <= self.r - (SNAP if self.d > ON_AXIS else 0.0)

    def half_width(self, radii: Array) -> Array:
        """h of ovals, rad."""
        below = (self.r - (radii - self.d)) * (self.r + (radii - self.d))
        beyond = (radii + self.d - self.r) * (radii + self.d + self.r)
        return 2.0 * np.arctan2(np.sqrt(np.maximum(below, 0.0)), np.sqrt(np.maximum(beyond, 0.0)))

    def _quadric(self, radius: float) -> dict:
        c = np.zeros(5)
        c[0] = (radius - self.r) * (radius + self.r) + self.d**2
        c[1:3] = -2.0 * radius * self.origin[:2]
        return {"a": 1.0, "b": np.zeros(3), "c": c, "radius": radius, "lift": self.z, "face": self.face.index}

    def oval(self, radius: float, p0: float, p1: float) -> QuadricCurve:
        """From one angle of the fold to another."""
        fold = (radius * self.phi, radius * float(self.half_width(np.array([radius]))[0]))
        return QuadricCurve(**self._quadric(radius), branch=1, range=(p0, p1), fold=fold)

    def ring(self, radius: float, side: float, theta0: float, theta1: float) -> Curve:
        """The upper (side +1) or the lower ring, from one angle to another."""
        ends = (radius * theta0, radius * theta1)
        if self.d <= ON_AXIS:
            v = self.z + side * float(np.sqrt(max((self.r - radius) * (self.r + radius), 0.0)))
            return LineCurve.between((ends[0], v), (ends[1], v), face=self.face.index)
        return QuadricCurve(**self._quadric(radius), branch=int(side), range=ends)

    def contains(self, curve: Curve, radius: float, sides: Array) -> bool:
        """Whether a curve that meets none of the face's edges lies on the face, by the radii of its loops (n,), mm.

        An oval parts the sphere: where all loops lie inside of R, what is outside is on the face as its farthest point is.
        """
        if (sides <= radius + SNAP).all() and radius + self.d > self.r:
            away = np.array([np.cos(self.phi), np.sin(self.phi), 0.0])
            uv = self.surface.parameters((self.origin + self.r * away)[None])
            uv[:, 0] = np.mod(uv[:, 0] - self.face.box[0, 0], TURN) + self.face.box[0, 0]
            return not len(sides) or bool(trimming_of(self.face).contains(uv + 1e-9)[0])
        flat = curve.points(np.linspace(0.0, 1.0, SAMPLES, endpoint=False))
        theta = flat[:, 0] / radius
        uv = self.surface.parameters(np.stack([radius * np.cos(theta), radius * np.sin(theta), flat[:, 1]], axis=1))
        uv[:, 0] = np.mod(uv[:, 0] - self.face.box[0, 0], TURN) + self.face.box[0, 0]
        return trimming_of(self.face).surely_contains(uv, np.full(2, self.r))


def arcs_on_sphere(face: Face, found: FaceNodes, radii: Array, edged: set[int], sides: Array) -> FaceArcs:
    """All arcs of all layers on a sphere; in the layers `edged` its whole outline is the section already.

    `sides` (loops,) are the effective radii of one vertex of each of its loops.
    """
    sphere, arcs = _Sphere(face), FaceArcs()
    meets, rings = sphere.meets(radii), sphere.rings(radii)
    reason = f"the crossings on face {face.index} do not pair up"
    arcs.failed.update({layer: reason for layer in found.layer[~meets[found.layer]].tolist()})
    arcs.failed.update({layer: reason for layer in edged if rings[layer]})
    side = np.where(found.height >= sphere.z, 1.0, -1.0)
    round_ones = meets[found.layer] & rings[found.layer]
    if round_ones.any():
        _add_rings(sphere, found.select(round_ones), radii, side[round_ones], arcs)
    ovals = meets[found.layer] & ~rings[found.layer]
    if ovals.any():
        _add_ovals(sphere, found.select(ovals), radii, arcs)
    busy = set(zip(found.layer.tolist(), np.where(rings[found.layer], side, 0.0).tolist(), strict=True))
    for layer in sorted(set(np.flatnonzero(meets).tolist()) - edged - set(arcs.failed)):
        for which in (1.0, -1.0) if rings[layer] else (0.0,):
            if (layer, which) not in busy:
                _add_whole(sphere, float(radii[layer]), layer, which, sides, arcs)
    return arcs


def _add_rings(sphere: _Sphere, found: FaceNodes, radii: Array, side: Array, arcs: FaceArcs) -> None:
    def make(layer: int, row: int, theta0: float, theta1: float) -> Curve:
        return sphere.ring(float(radii[layer]), float(side[row]), theta0, theta1)

    arcs.extend(arcs_round(sphere.face, found, radii, side, -sphere.out * side, make))


def _add_ovals(sphere: _Sphere, found: FaceNodes, radii: Array, arcs: FaceArcs) -> None:
    p = _angle_of_fold(sphere, found, radii[found.layer])
    # the fold's angle runs clockwise, the outline of metal within the sphere counter-clockwise
    way = -sphere.out
    pairs = pair_along(found, np.zeros(len(found)), np.mod(way * p, TURN), cyclic=True)
    for layer in pairs.bad.tolist():
        arcs.failed[layer] = f"the crossings on face {sphere.face.index} do not pair up"
    turn = np.mod(way * (p[pairs.end] - p[pairs.start]), TURN)
    turn = np.where(turn > TURN - SAME_ANGLE, 0.0, turn)
    turn = np.where(found.node[pairs.start] == found.node[pairs.end], TURN, turn)
    for i, j, angle in zip(pairs.start.tolist(), pairs.end.tolist(), turn.tolist(), strict=True):
        layer = int(found.layer[i])
        curve = sphere.oval(float(radii[layer]), float(p[i]), float(p[i] + way * angle))
        arcs.add(curve, layer, int(found.node[i]), int(found.node[j]))


def _angle_of_fold(sphere: _Sphere, found: FaceNodes, radius: Array) -> Array:
    """p (n,) of nodes on ovals, x = -h cos p: by x in the middle, towards the ends by the height, which keeps its digits."""
    h, w = sphere.half_width(radius), found.height - sphere.z
    x = np.mod(found.theta - sphere.phi + np.pi, TURN) - np.pi
    middle = np.arccos(np.clip(-x / h, -1.0, 1.0))
    # the way in from the nearer end: sin(delta / 2) sin(h - delta / 2) = w**2 / (4 R d)
    product, delta = w * w / (4.0 * radius * sphere.d), np.clip(h - np.abs(x), 0.0, h)
    for _ in range(STEPS):
        slope = 0.5 * np.sin(h - delta)
        step = (np.sin(0.5 * delta) * np.sin(h - 0.5 * delta) - product) / np.where(slope > 0.0, slope, np.inf)
        delta = np.clip(delta - step, 0.0, h)
    from_end = 2.0 * np.arcsin(np.sqrt(np.clip(0.5 * delta / h, 0.0, 1.0)))
    upper = np.where(np.abs(x) <= STEEP_FROM * h, middle, np.where(x < 0.0, from_end, np.pi - from_end))
    return np.where(w >= 0.0, upper, TURN - upper)


def _add_whole(sphere: _Sphere, radius: float, layer: int, side: float, sides: Array, arcs: FaceArcs) -> None:
    """An oval (side 0) or a ring that meets no edge, if it lies on the face."""
    if side == 0.0:
        ends = (TURN, 0.0) if sphere.out > 0.0 else (0.0, TURN)
        curve: Curve = sphere.oval(radius, *ends)
    else:
        curve = sphere.ring(radius, side, 0.0, -sphere.out * side * TURN)
    if sphere.contains(curve, radius, sides):
        arcs.add(curve, layer, -1, -1)
