"""A solid as plane triangles, to look at it along many rays, and to judge its bulk: for choices, never for a layer.

In: a solid. Out: numpy arrays of corners and triangles, and of which face each triangle is.

Words: *facet*, a triangle whose corners lie on its face.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.BRepMesh import BRepMesh_IncrementalMesh
from OCP.gp import gp_Pnt2d
from OCP.IntTools import IntTools_FClass2d
from OCP.TopAbs import TopAbs_FACE, TopAbs_IN, TopAbs_ON, TopAbs_REVERSED, TopAbs_VERTEX
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopLoc import TopLoc_Location

from .compat import as_face, as_vertex, indexed_map, sub_shapes

# How far a facet may leave its face: this share of the solid's diagonal, and this angle (rad) between neighbours; shares of
# metal are then good to a few in a thousand.
DEFLECTION, ANGLE = 2e-3, 0.25
# Cells a side on a face that OCCT's mesher leaves out.
GRID = 64


class Facets(NamedTuple):
    """Facets of a solid.

    Attributes
    ----------
    corners : ndarray, shape (n, 3)
        Points in the solid's frame, mm.
    triangles : ndarray, shape (m, 3)
        Numbers of corners, counter-clockwise as seen from outside.
    faces : ndarray, shape (m,)
        The number of each triangle's face, in OCCT's order.
    """

    corners: np.ndarray
    triangles: np.ndarray
    faces: np.ndarray

    def turned(self) -> Facets:
        """Seen from the other side."""
        return self._replace(triangles=self.triangles[:, ::-1])

    def bulk(self) -> tuple[float, float]:
        """(volume in mm**3, negative where the triangles look inwards; area in mm**2)."""
        middle = self.corners.mean(axis=0) if len(self.corners) else np.zeros(3)
        a, b, c = (self.corners[self.triangles[:, k]] - middle for k in range(3))
        across = np.cross(b - a, c - a)
        return float((a * across).sum()) / 6.0, 0.5 * float(np.linalg.norm(across, axis=1).sum())


def facets_of(solid: Any) -> Facets:
    """Facets of a solid."""
    # of a copy, whose triangulation is thrown away: OCCT's boxes and booleans take account of one that a shape carries
    copied = BRepBuilderAPI_Copy(solid, False, False).Shape()
    BRepMesh_IncrementalMesh(copied, DEFLECTION * max(diagonal_of(copied), 1e-9), False, ANGLE, False)
    numbers = indexed_map()
    TopExp.MapShapes_s(copied, TopAbs_FACE, numbers)
    corners, triangles, faces = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], [np.zeros(0, dtype=int)]
    count = 0
    walk = TopExp_Explorer(copied, TopAbs_FACE)
    while walk.More():
        face = as_face(walk.Current())
        walk.Next()
        points, table = _triangulation(face) or _grid(face)
        corners.append(points)
        triangles.append(count + (table[:, ::-1] if face.Orientation() == TopAbs_REVERSED else table))
        faces.append(np.full(len(table), numbers.FindIndex(face) - 1))
        count += len(points)
    return Facets(np.concatenate(corners), np.concatenate(triangles), np.concatenate(faces))


def diagonal_of(shape: Any) -> float:
    """Length of a shape's box from corner to corner, mm."""
    box = Bnd_Box()
    BRepBndLib.AddClose_s(shape, box)
    low, high = box.CornerMin(), box.CornerMax()
    return float(np.linalg.norm([high.X() - low.X(), high.Y() - low.Y(), high.Z() - low.Z()]))


def _triangulation(face: Any) -> tuple[np.ndarray, np.ndarray] | None:
    """OCCT's own, counter-clockwise about the surface's normal; None where the mesher has left the face out."""
    place = TopLoc_Location()
    found = BRep_Tool.Triangulation_s(face, place)
    if found is None:
        return None
    nodes = [found.Node(i) for i in range(1, found.NbNodes() + 1)]
    if not place.IsIdentity():
        nodes = [node.Transformed(place.Transformation()) for node in nodes]
    table = np.array([found.Triangle(i).Get() for i in range(1, found.NbTriangles() + 1)], dtype=int).reshape(-1, 3) - 1
    return np.array([(p.X(), p.Y(), p.Z()) for p in nodes]).reshape(-1, 3), table


def _grid(face: Any) -> tuple[np.ndarray, np.ndarray]:
    """A face that the mesher cannot do (a boundary that does not close in its parameters): cells of its box that lie in it."""
    surface = BRepAdaptor_Surface(face, True)
    u = np.linspace(surface.FirstUParameter(), surface.LastUParameter(), GRID + 1)
    v = np.linspace(surface.FirstVParameter(), surface.LastVParameter(), GRID + 1)
    points = np.array([(p.X(), p.Y(), p.Z()) for p in (surface.Value(a, b) for a in u.tolist() for b in v.tolist())])
    classifier, inside = IntTools_FClass2d(face, 1e-9), []
    for a in 0.5 * (u[:-1] + u[1:]):
        for b in 0.5 * (v[:-1] + v[1:]):
            inside.append(classifier.Perform(gp_Pnt2d(float(a), float(b))) in (TopAbs_IN, TopAbs_ON))
    corner = (np.arange(GRID)[:, None] * (GRID + 1) + np.arange(GRID)).ravel()[np.array(inside) | (not any(inside))]
    right, up, both = corner + GRID + 1, corner + 1, corner + GRID + 2
    return points, np.concatenate([np.stack([corner, right, both], axis=1), np.stack([corner, both, up], axis=1)])


def corners_of(solid: Any) -> np.ndarray:
    """A solid's vertices, (n, 3), mm."""
    points = [BRep_Tool.Pnt_s(as_vertex(vertex)) for vertex in sub_shapes(solid, TopAbs_VERTEX)]
    return np.array([(p.X(), p.Y(), p.Z()) for p in points]).reshape(-1, 3)
