"""OCCT's boolean of a cylinder face with a solid: the reference section.

In: a solid in the axis frame, a radius, the angle of the seam. Out: edges of the common faces as plain curves, chained by
vertex identity, and areas.

Words: *seam edge*, the cut of the cylinder face itself, no boundary of the section; *use*, an edge run through with the
material on its left as seen from outside.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Curve
from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace
from OCP.BRepGProp import BRepGProp
from OCP.Geom import Geom_CylindricalSurface
from OCP.gp import gp_Ax3, gp_Dir, gp_Pnt
from OCP.GProp import GProp_GProps
from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_FORWARD, TopAbs_REVERSED, TopAbs_VERTEX
from OCP.TopExp import TopExp, TopExp_Explorer

from brep_slicer.errors import LayerError
from brep_slicer.geometry import EdgeCurve
from brep_slicer.maps import TURN

from .brep_geometry import curve_from_adaptor
from .compat import as_edge, as_face, indexed_map, shape_list
from .silence import silenced


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EdgeOnCylinder:
    """One use of an edge: `curve` from `first` to `last` (reversed unless `forward`), between two numbered vertices.

    `tolerance` (mm) is OCCT's own: how far it allows the curve to lie from the solid's face and the cylinder.
    """

    curve: EdgeCurve
    first: float
    last: float
    forward: bool
    start: int
    end: int
    tolerance: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CommonFaces:
    """What a solid and a cylinder have in common: `uses` of edges, the seam left out, and the `area` (mm**2)."""

    uses: tuple[EdgeOnCylinder, ...]
    area: float


def height_range(solid: Any) -> tuple[float, float]:
    """Lowest and highest z of a solid (its exact bounding box), mm."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(solid, box, False, False)
    z0, z1 = box.CornerMin().Z(), box.CornerMax().Z()
    return float(z0), float(z1)


def largest_tolerance(solid: Any) -> float:
    """Largest tolerance of any vertex, edge or face, mm."""
    return float(ShapeAnalysis_ShapeTolerance().Tolerance(solid, 1))


def cylinder_face(radius: float, seam: float, turn: float, heights: tuple[float, float]) -> Any:
    """The face of a cylinder about z from angle `seam` on by `turn` (rad) between two heights (mm)."""
    x = gp_Dir(float(np.cos(seam)), float(np.sin(seam)), 0.0)
    surface = Geom_CylindricalSurface(gp_Ax3(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0), x), radius)
    return BRepBuilderAPI_MakeFace(surface, 0.0, turn, heights[0], heights[1], 1e-9).Face()


def common_with_cylinder(solid: Any, radius: float, *, seam: float, turn: float, heights: tuple[float, float]) -> CommonFaces:
    """Common of a solid (axis frame) with a cylinder face.

    Raises
    ------
    LayerError
        If OCCT reports an error, or changes the solid's tolerances on the way.
    """
    before = largest_tolerance(solid)
    work = BRepAlgoAPI_Common()
    work.SetArguments(shape_list([cylinder_face(radius, seam, turn, heights)]))
    work.SetTools(shape_list([solid]))
    work.SetNonDestructive(True)
    try:
        with silenced():
            work.Build()
    except Exception as error:
        raise LayerError(f"OCCT's boolean failed at radius {radius:g} mm ({type(error).__name__})") from None
    if not work.IsDone():  # an error inside leaves it undone; a section that is empty is done
        raise LayerError(f"OCCT's boolean failed at radius {radius:g} mm")
    if largest_tolerance(solid) != before:
        raise LayerError(f"OCCT's boolean changed the solid's tolerances at radius {radius:g} mm")
    return _read(work.Shape(), full=turn >= TURN)


def _read(shape: Any, *, full: bool) -> CommonFaces:
    area, uses = 0.0, []
    vertices = indexed_map()
    TopExp.MapShapes_s(shape, TopAbs_VERTEX, vertices)
    faces = TopExp_Explorer(shape, TopAbs_FACE)
    while faces.More():
        face = as_face(faces.Current())
        properties = GProp_GProps()
        BRepGProp.SurfaceProperties_s(face, properties, 1e-10)
        area += abs(float(properties.Mass()))
        if full:
            uses += _uses(face, vertices)
        faces.Next()
    return CommonFaces(uses=tuple(uses), area=area)


def _uses(face: Any, vertices: Any) -> list[EdgeOnCylinder]:
    flipped = face.Orientation() == TopAbs_REVERSED
    out = []
    edges = TopExp_Explorer(face.Oriented(TopAbs_FORWARD), TopAbs_EDGE)
    while edges.More():
        edge = as_edge(edges.Current())
        if edge.Orientation() in (TopAbs_FORWARD, TopAbs_REVERSED) and not BRep_Tool.Degenerated_s(edge):
            ahead = as_edge(edge.Oriented(TopAbs_FORWARD))
            if not BRep_Tool.IsClosed_s(ahead, face):
                out.append(_use(ahead, (edge.Orientation() == TopAbs_FORWARD) != flipped, vertices))
        edges.Next()
    return out


def _use(ahead: Any, forward: bool, vertices: Any) -> EdgeOnCylinder:
    adaptor = BRepAdaptor_Curve(ahead)
    ends = [vertices.FindIndex(v) for v in (TopExp.FirstVertex_s(ahead), TopExp.LastVertex_s(ahead))]
    return EdgeOnCylinder(
        curve=curve_from_adaptor(adaptor, 3, []),
        first=adaptor.FirstParameter(),
        last=adaptor.LastParameter(),
        forward=forward,
        start=ends[0] if forward else ends[1],
        end=ends[1] if forward else ends[0],
        tolerance=BRep_Tool.Tolerance_s(ahead),
    )
