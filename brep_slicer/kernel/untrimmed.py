"""Faces on bare surfaces: rectangular trims taken off, since a face's own boundary trims it.

In: a solid. Out: the same solid, its faces on the surfaces that were trimmed, its edges' curves in the same parameters.

OCCT's reader wraps a closed surface so when a file bounds its face by two circles and no seam, as Parasolid systems write
rings, and adds the seam; parts of OCCT (the recognition of cylinders, say) fail on what is wrapped.
"""

from __future__ import annotations

from typing import Any

from OCP.BRep import BRep_Builder, BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
from OCP.Geom import Geom_RectangularTrimmedSurface
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location

from .compat import as_edge, as_face, as_solid, indexed_map, sub_shapes


def untrimmed(solid: Any) -> Any:
    """The solid as it is, or a copy without rectangular trims."""
    if not any(_is_trimmed(_surface(face)[0]) for face in _faces(solid)):
        return solid
    copied = as_solid(BRepBuilderAPI_Copy(solid).Shape())
    for face in _faces(copied):
        surface, location = _surface(face)
        if _is_trimmed(surface):
            bare = surface
            while _is_trimmed(bare):
                bare = bare.BasisSurface()
            _put_on(face, surface, bare, location)
    return copied


def _faces(solid: Any) -> list[Any]:
    return [as_face(face.Oriented(TopAbs_FORWARD)) for face in sub_shapes(solid, TopAbs_FACE)]


def _surface(face: Any) -> tuple[Any, Any]:
    location = TopLoc_Location()
    return BRep_Tool.Surface_s(face, location), location


def _is_trimmed(surface: Any) -> bool:
    return isinstance(surface, Geom_RectangularTrimmedSurface)


def _put_on(face: Any, old: Any, new: Any, location: Any) -> None:
    """Move a face and its edges' curves from the surface `old` to `new`, which has the same parameters."""
    builder = BRep_Builder()
    moved = []
    distinct = indexed_map()
    for edge in sub_shapes(face, TopAbs_EDGE):
        distinct.Add(edge.Oriented(TopAbs_FORWARD))
    for i in range(1, distinct.Extent() + 1):
        forward = as_edge(distinct.FindKey(i).Oriented(TopAbs_FORWARD))
        first, last = BRep_Tool.Range_s(forward, old, location)
        curve = BRep_Tool.CurveOnSurface_s(forward, old, location, first, last)
        if curve is None:
            continue
        closed = BRep_Tool.IsClosed_s(forward, old, location)
        backward = as_edge(forward.Oriented(TopAbs_REVERSED))
        second = BRep_Tool.CurveOnSurface_s(backward, old, location, first, last) if closed else None
        moved.append((forward, curve, second, (first, last)))
    for edge, _, second, _ in moved:
        # the old curves are dropped first: a null curve says so
        if second is None:
            builder.UpdateEdge(edge, None, old, location, BRep_Tool.Tolerance_s(edge))
        else:
            builder.UpdateEdge(edge, None, None, old, location, BRep_Tool.Tolerance_s(edge))
    builder.UpdateFace(face, new, location, BRep_Tool.Tolerance_s(face))
    for edge, curve, second, (first, last) in moved:
        tolerance = BRep_Tool.Tolerance_s(edge)
        if second is None:
            builder.UpdateEdge(edge, curve, new, location, tolerance)
        else:
            builder.UpdateEdge(edge, curve, second, new, location, tolerance)
        builder.Range(edge, new, location, first, last)
