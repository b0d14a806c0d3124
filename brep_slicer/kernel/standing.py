"""Whether metal stands on a turned land: what lies behind the edges of its faces, or of another solid against it.

In: a solid, the numbers of the faces of one of its cylinders, the axis. Out: yes or no.

Words: *land*, the faces of one cylinder; *rises*, leaves an edge away from the axis; *relief*, a shallow groove that is cut
into the land where metal rises from it, as for a grinding wheel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec, gp_Vec2d
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopExp import TopExp_Explorer

from .compat import as_edge, as_face, indexed_map, sub_shapes
from .revolutes import area_of, sampled

# A relief is no deeper than this share of the land's radius.
RELIEF_DEPTH = 0.1
# A face that leaves an edge at less than this slope towards the axis is tangent there: a fillet, which may rise later.
TANGENT = 1e-3


class Lands:
    """One solid's faces about an axis (`point`, `direction`), and which of them share edges."""

    def __init__(self, solid: Any, point: np.ndarray, direction: np.ndarray) -> None:
        self.solid, self.point, self.direction = solid, point, direction
        self.faces = [as_face(f.Oriented(TopAbs_FORWARD)) for f in sub_shapes(solid, TopAbs_FACE)]
        edges = indexed_map()
        self.uses: list[list[tuple[int, Any]]] = []
        self.owners: dict[int, list[int]] = {}
        self.extents: dict[int, tuple[float, float]] = {}
        for number, face in enumerate(self.faces):
            self.uses.append([])
            walk = TopExp_Explorer(face, TopAbs_EDGE)
            while walk.More():
                edge = as_edge(walk.Current())
                key = edges.Add(edge)
                self.uses[-1].append((key, edge))
                self.owners.setdefault(key, []).append(number)
                walk.Next()

    def stood_on(self, land: Sequence[int], radius: float, margin: float) -> bool:
        """Whether some face rises past `radius` + `margin` (mm) from an edge of the land, or of a relief in it."""
        area = sum(area_of(self.faces[i]) for i in land)
        seen, open_ = set(land), list(land)
        while open_:
            for key, _ in self.uses[open_.pop()]:
                for other in set(self.owners[key]) - seen:
                    low, high = self._extent(other)
                    if high > radius + margin:
                        if self._rises(other, key):
                            return True
                    elif low >= (1.0 - RELIEF_DEPTH) * radius and area_of(self.faces[other]) < area:
                        seen.add(other)
                        open_.append(other)
        return False

    def touched_by(self, land: Sequence[int], other: Any, margin: float) -> bool:
        """Whether another solid comes within `margin` (mm) of the land."""
        for number in land:
            found = BRepExtrema_DistShapeShape(self.faces[number], other)
            if found.IsDone() and found.NbSolution() > 0 and found.Value() <= margin:
                return True
        return False

    def _outwards(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The distance of points (n, 3) from the axis, and the unit vectors away from it."""
        arm = points - self.point
        arm = arm - np.outer(arm @ self.direction, self.direction)
        rho = np.linalg.norm(arm, axis=1)
        return rho, arm / np.maximum(rho, 1e-300)[:, None]

    def _extent(self, number: int) -> tuple[float, float]:
        """The least and the largest radius of a face, by samples."""
        if number in self.extents:
            return self.extents[number]
        face = self.faces[number]
        points = [sampled(BRepAdaptor_Surface(face, True), face, strict=True)[0]]
        for _, edge in self.uses[number]:
            if BRep_Tool.Degenerated_s(edge):
                continue
            curve = BRepAdaptor_Curve(edge)
            along = np.linspace(curve.FirstParameter(), curve.LastParameter(), 17)
            points.append(np.array([[p.X(), p.Y(), p.Z()] for p in (curve.Value(float(t)) for t in along)]))
        rho, _ = self._outwards(np.concatenate(points))
        self.extents[number] = float(rho.min(initial=math.inf)), float(rho.max(initial=0.0))
        return self.extents[number]

    def _rises(self, number: int, key: int) -> bool:
        """Whether a face leaves one of its edges away from the axis, or tangent to the land, anywhere along it."""
        face = self.faces[number]
        surface = BRepAdaptor_Surface(face, True)
        point, du, dv, uv, along = gp_Pnt(), gp_Vec(), gp_Vec(), gp_Pnt2d(), gp_Vec2d()
        for edge in (e for k, e in self.uses[number] if k == key):
            sign = -1.0 if edge.Orientation() == TopAbs_REVERSED else 1.0
            curve = BRepAdaptor_Curve2d(edge, face)
            for share in (0.2, 0.4, 0.6, 0.8):
                t = curve.FirstParameter() + share * (curve.LastParameter() - curve.FirstParameter())
                curve.D1(t, uv, along)
                surface.D1(uv.X(), uv.Y(), point, du, dv)
                su, sv = (np.array([d.X(), d.Y(), d.Z()]) for d in (du, dv))
                # the face lies on the left of its edges, in its parameters
                a, b = sign * along.X(), sign * along.Y()
                edge_way, inwards = a * su + b * sv, a * sv - b * su
                inwards = inwards - (inwards @ edge_way) / max(float(edge_way @ edge_way), 1e-300) * edge_way
                _, away = self._outwards(np.array([[point.X(), point.Y(), point.Z()]]))
                if float(inwards @ away[0]) >= -TANGENT * float(np.linalg.norm(inwards)):
                    return True
        return False
