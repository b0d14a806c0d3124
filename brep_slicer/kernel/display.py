"""A coarse triangulation of a solid, for pictures only: nothing of it gets into a plan.

In: an OCP solid, how far triangles may lie from it. Out: vertices with normals, triangles, sharp edges, as arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location

from brep_slicer.maps import Array

from .compat import as_face, sub_shapes
from .facets import DEFLECTION, Facets

# Faces that meet at less than this (cosine of 20 degrees) look like one.
SMOOTH = 0.94
# Neighbouring triangles' normals differ by no more than about this, rad: rounder is not seen on a page.
ANGLE = 0.4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DisplayMesh:
    """`points` and unit `normals` (n, 3), in the solid's frame, mm; `triangles` (m, 3), counter-clockwise from outside.

    `edges` (k, 2) are the pairs of points between which two faces meet at an angle. Faces share no points.
    """

    points: Array
    normals: Array
    triangles: Array
    edges: Array


def display_mesh(solid: Any, *, deflection: float, known: Facets | None = None) -> DisplayMesh:
    """Triangulate a copy of a solid to about `deflection` (mm); faces that OCCT cannot triangulate are left out.

    Facets that are `known` already do where they are no coarser than twice that.
    """
    if known is not None and deflection_of(known) <= 2.0 * deflection:
        return _with_normals(known.corners, known.triangles)
    # the caller's solid stays without a triangulation, which would be written along with it
    copy = BRepBuilderAPI_Copy(solid, True, False).Shape()
    BRepMesh_IncrementalMesh(copy, deflection, False, ANGLE, False)
    points: list[Array] = [np.zeros((0, 3))]
    triangles: list[Array] = [np.zeros((0, 3), dtype=int)]
    count = 0
    for shape in sub_shapes(copy, TopAbs_FACE):
        found = _face(as_face(shape))
        if found is not None:
            points.append(found[0])
            triangles.append(found[1] + count)
            count += len(found[0])
    return _with_normals(np.concatenate(points), np.concatenate(triangles))


def deflection_of(facets: Facets) -> float:
    """How far facets may lie from their faces, mm."""
    return DEFLECTION * float(np.linalg.norm(np.ptp(facets.corners, axis=0))) if len(facets.corners) else np.inf


def _face(face: Any) -> tuple[Array, Array] | None:
    """Points and triangles of one face, seen from outside of the solid."""
    place = TopLoc_Location()
    mesh = BRep_Tool.Triangulation_s(face, place)
    if mesh is None:
        return None
    nodes = [mesh.Node(i) for i in range(1, mesh.NbNodes() + 1)]
    points = np.array([(p.X(), p.Y(), p.Z()) for p in nodes])
    corners = np.array([mesh.Triangle(i).Get() for i in range(1, mesh.NbTriangles() + 1)], dtype=int).reshape(-1, 3) - 1
    if not place.IsIdentity():
        motion = place.Transformation()
        matrix = np.array([[motion.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])
        points = points @ matrix[:, :3].T + matrix[:, 3]
    return points, corners[:, ::-1] if face.Orientation() == TopAbs_REVERSED else corners


def _with_normals(points: Array, triangles: Array) -> DisplayMesh:
    """Normals at the points, from the triangles round them by area, and the edges where faces meet at an angle."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals: Array = np.stack(
        [np.bincount(triangles.ravel(), np.repeat(across[:, k], 3), minlength=len(points)) for k in range(3)], axis=1
    )
    normals = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    return DisplayMesh(points=points, normals=normals, triangles=triangles, edges=_sharp(points, triangles, across))


def _sharp(points: Array, triangles: Array, across: Array) -> Array:
    """Edges of faces (they bound one triangle of their face) beside which the triangles of two faces meet at an angle."""
    pairs = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    _, first, times = np.unique(pairs, axis=0, return_index=True, return_counts=True)
    outer = first[times == 1]
    if not len(outer):
        return np.zeros((0, 2), dtype=int)
    pairs, owner = pairs[outer], owner[outer]
    size = np.ptp(points, axis=0).max()
    middle = np.round((points[pairs[:, 0]] + points[pairs[:, 1]]) * (1e5 / max(size, 1e-300))).astype(np.int64)
    _, first, same = np.unique(middle, axis=0, return_index=True, return_inverse=True)
    unit = across[owner] / np.maximum(np.linalg.norm(across[owner], axis=1, keepdims=True), 1e-300)
    sums = np.stack([np.bincount(same.ravel(), unit[:, k]) for k in range(3)], axis=1)
    count = np.bincount(same.ravel())
    # the sum of two unit vectors at an angle a has the length 2 cos(a / 2)
    sharp = np.linalg.norm(sums, axis=1) < count * np.sqrt(0.5 * (1.0 + SMOOTH))
    return pairs[first[sharp | (count != 2)]]


__all__ = ["DisplayMesh", "display_mesh"]
