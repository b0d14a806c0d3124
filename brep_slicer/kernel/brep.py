"""One solid, read out of OCCT into numpy: vertices, edges, faces, in the axis frame.

In: a solid in the axis frame. Out: a geometry.Brep.

Edge identity comes from OCCT's indexed map (IsSame); an edge use keeps the composed orientation, so that the face lies on
its left as seen from outside of the solid.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d, BRepAdaptor_Surface
from OCP.BRepTools import BRepTools_WireExplorer
from OCP.TopAbs import (
    TopAbs_EDGE,
    TopAbs_FACE,
    TopAbs_FORWARD,
    TopAbs_REVERSED,
    TopAbs_VERTEX,
    TopAbs_WIRE,
)
from OCP.TopExp import TopExp, TopExp_Explorer
from OCP.TopoDS import TopoDS_Iterator

from brep_slicer.geometry import Brep, Edge, EdgeUse, Face

from .brep_geometry import centred, curve_from_adaptor, surface_from_adaptor
from .compat import as_edge, as_face, as_vertex, as_wire, indexed_map


def brep_from_solid(moved: Any, lift: float = 0.0, noise: float = 0.0) -> Brep:
    """Read a solid.

    Parameters
    ----------
    moved : TopoDS_Solid
        In the axis frame moved down by `lift`, mm (`shapes.into_frame`).
    lift : float
        mm.
    noise : float
        What the file's coordinates are good for, mm: a surface turned about a line so near to the axis is turned about it.

    Raises
    ------
    KernelError
        If a surface or a curve is of a kind that cannot be read, not even approximately.
    """
    maps = {kind: indexed_map() for kind in (TopAbs_VERTEX, TopAbs_EDGE, TopAbs_FACE)}
    for kind, found in maps.items():
        TopExp.MapShapes_s(moved, kind, found)
    corners = [as_vertex(maps[TopAbs_VERTEX].FindKey(i)) for i in range(1, maps[TopAbs_VERTEX].Extent() + 1)]
    points = [BRep_Tool.Pnt_s(vertex) for vertex in corners]
    errors: list[float] = [0.0]
    edges = [_edge(as_edge(maps[TopAbs_EDGE].FindKey(i)), maps, errors) for i in range(1, maps[TopAbs_EDGE].Extent() + 1)]
    faces = [replace(face, surface=centred(face.surface, noise)) for face in _faces(moved, maps, errors)]
    return Brep(
        vertices=np.array([[p.X(), p.Y(), p.Z()] for p in points]).reshape(-1, 3),
        vertex_tolerances=np.array([BRep_Tool.Tolerance_s(v) for v in corners]),
        edges=tuple(edges),
        faces=tuple(faces),
        residual=max(errors),
        lift=lift,
    )


def _edge(edge: Any, maps: Any, errors: list[float]) -> Edge:
    forward = as_edge(edge.Oriented(TopAbs_FORWARD))
    ends = tuple(
        maps[TopAbs_VERTEX].FindIndex(end) - 1 for end in (TopExp.FirstVertex_s(forward), TopExp.LastVertex_s(forward))
    )
    tolerance = BRep_Tool.Tolerance_s(edge)
    if BRep_Tool.Degenerated_s(edge):
        return Edge(curve=None, first=0.0, last=1.0, vertices=(ends[0], ends[1]), tolerance=tolerance)
    adaptor = BRepAdaptor_Curve(forward)
    curve = curve_from_adaptor(adaptor, 3, errors)
    first, last = adaptor.FirstParameter(), adaptor.LastParameter()
    return Edge(curve=curve, first=first, last=last, vertices=(ends[0], ends[1]), tolerance=tolerance)


def _faces(moved: Any, maps: Any, errors: list[float]) -> list[Face]:
    """Every face with the orientation that it has in the solid (the map alone forgets it)."""
    out: dict[int, Face] = {}
    explorer = TopExp_Explorer(moved, TopAbs_FACE)
    while explorer.More():
        face = as_face(explorer.Current())
        index = maps[TopAbs_FACE].FindIndex(face) - 1
        if index not in out:
            out[index] = _face(index, face, maps, errors)
        explorer.Next()
    return [out[i] for i in sorted(out)]


def _face(index: int, face: Any, maps: Any, errors: list[float]) -> Face:
    adaptor = BRepAdaptor_Surface(face, False)
    u0, u1, v0, v1 = _bounds(face)
    loops = []
    wires = TopoDS_Iterator(face)
    while wires.More():
        wire = wires.Value()
        if wire.ShapeType() == TopAbs_WIRE:
            loops.append(_loop(wire, face, maps, errors))
        wires.Next()
    return Face(
        index=index,
        surface=surface_from_adaptor(adaptor, (u0, u1, v0, v1), errors),
        sign=-1 if face.Orientation() == TopAbs_REVERSED else 1,
        loops=tuple(loop for loop in loops if loop),
        box=np.array([[u0, v0], [u1, v1]]),
        tolerance=BRep_Tool.Tolerance_s(face),
    )


def _bounds(face: Any) -> tuple[float, float, float, float]:
    bounded = BRepAdaptor_Surface(face, True)
    return (
        bounded.FirstUParameter(),
        bounded.LastUParameter(),
        bounded.FirstVParameter(),
        bounded.LastVParameter(),
    )


def _loop(wire: Any, face: Any, maps: Any, errors: list[float]) -> tuple[EdgeUse, ...]:
    uses = []
    for edge in _in_order(as_wire(wire), face):
        adaptor = BRepAdaptor_Curve2d(edge, face)
        uses.append(
            EdgeUse(
                edge=maps[TopAbs_EDGE].FindIndex(edge) - 1,
                forward=edge.Orientation() == TopAbs_FORWARD,
                pcurve=curve_from_adaptor(adaptor, 2, errors),
                range=(adaptor.FirstParameter(), adaptor.LastParameter()),
            )
        )
    return tuple(uses)


def _in_order(wire: Any, face: Any) -> list[Any]:
    """The edges of a wire as they follow one another (a wire may store them in any order).

    OCCT's explorer, which follows the curves in the face's parameters where vertices alone do not tell (seams), is believed
    if it meets every edge; else the stored order is kept.
    """
    stored = []
    explorer = TopExp_Explorer(wire, TopAbs_EDGE)
    while explorer.More():
        edge = as_edge(explorer.Current())
        if edge.Orientation() in (TopAbs_FORWARD, TopAbs_REVERSED):
            stored.append(edge)
        explorer.Next()
    ordered = []
    follower = BRepTools_WireExplorer(wire, face)
    while follower.More():
        ordered.append(as_edge(follower.Current()))
        follower.Next()
    if len(ordered) != len(stored):
        return stored
    rest = list(stored)
    out = []
    for edge in ordered:
        found = next((e for e in rest if e.IsEqual(edge)), None)
        if found is None:
            return stored
        rest.remove(found)
        out.append(found)
    return out


def ensure_curves(solid: Any) -> None:
    """Give every edge its 3D curve where a file left only curves on surfaces."""
    from OCP.BRepLib import BRepLib

    BRepLib.BuildCurves3d_s(solid)


__all__ = ["brep_from_solid", "ensure_curves"]
