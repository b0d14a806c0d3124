"""Solids moved, scaled, checked, measured and packed: small services on OCCT shapes.

In: TopoDS shapes. Out: new shapes (the given ones are never changed), numbers, bytes.
"""

from __future__ import annotations

import io
from typing import Any

import numpy as np
from OCP.BinTools import BinTools
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Builder
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp, BRepGProp_Domain, BRepGProp_Face, BRepGProp_Vinert
from OCP.gp import gp_Pnt, gp_Trsf, gp_Vec
from OCP.GProp import GProp_GProps
from OCP.ShapeAnalysis import ShapeAnalysis_ShapeTolerance
from OCP.ShapeFix import ShapeFix_Shape
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Compound, TopoDS_Shape

from brep_slicer.errors import EmptySolidError, InputError

from .compat import as_face, as_solid, sub_shapes
from .facets import Facets, diagonal_of, facets_of
from .silence import silenced
from .untrimmed import untrimmed

# A solid whose faces are on average farther apart than this share of its diagonal has a volume; thinner ones are looked at.
THIN = 1e-2
# Facets are believed where they make it so many times as thick as that: they leave their faces by a fifth of it at most.
BULKY = 2.0


def transformed(shape: Any, matrix: np.ndarray) -> Any:
    """A copy moved by a rigid (4, 4) `matrix`, its geometry rewritten (no location is left on it)."""
    trsf = gp_Trsf()
    trsf.SetValues(*(float(x) for x in np.asarray(matrix)[:3].ravel()))
    return BRepBuilderAPI_Transform(shape, trsf, True).Shape()


def into_frame(shape: Any, origin: np.ndarray, rotation: np.ndarray) -> Any:
    """A copy in the frame at `origin` (3,), mm, whose axes are the rows of `rotation` (3, 3).

    Moved first, which loses no digits where the shape is near the origin, and then turned: in one motion a shape far from its
    file's origin loses as many as its coordinates have there.
    """
    there = gp_Trsf()
    there.SetTranslation(gp_Vec(*(-float(x) for x in origin)))
    near = BRepBuilderAPI_Transform(shape, there, True).Shape() if np.any(origin) else shape
    turn = np.eye(4)
    turn[:3, :3] = rotation
    return transformed(near, turn)


def scaled(shape: Any, factor: float) -> Any:
    """A copy scaled about the file's origin."""
    trsf = gp_Trsf()
    trsf.SetScale(gp_Pnt(0.0, 0.0, 0.0), factor)
    return BRepBuilderAPI_Transform(shape, trsf, True).Shape()


def baked(solid: Any, location: Any) -> Any:
    """The solid moved by an assembly's `location`, which is written into its geometry together with its own."""
    total = location.Multiplied(solid.Location())
    bare = solid.Located(TopLoc_Location())
    if total.IsIdentity():
        return as_solid(bare)
    return as_solid(BRepBuilderAPI_Transform(bare, total.Transformation(), True).Shape())


def checked_solid(solid: Any, name: str) -> tuple[Any, Facets, tuple[str, ...]]:
    """A valid solid of positive volume, its facets, and notes on what had to be done for that.

    Raises
    ------
    EmptySolidError
        If the solid has no volume; the message names it.
    InputError
        If the solid is invalid and stays so after healing, or the kernel fails on it; the message names it.
    """
    try:
        return _checked(solid, name)
    except InputError:
        raise
    except Exception as error:  # OCCT raises classes of its own, which share no base: for numbers that are none (NAN), say
        said = type(error).__name__
        raise InputError(
            f"solid {name!r} is broken: the CAD kernel fails on it ({said}); repair it in the CAD system"
        ) from None


def _checked(solid: Any, name: str) -> tuple[Any, Facets, tuple[str, ...]]:
    notes: list[str] = []
    if not BRepCheck_Analyzer(solid).IsValid():
        fix = ShapeFix_Shape(solid)
        with silenced():
            fix.Perform()
        healed = sub_shapes(fix.Shape(), TopAbs_SOLID)
        if len(healed) != 1 or not BRepCheck_Analyzer(healed[0]).IsValid():
            raise InputError(f"solid {name!r} is invalid and cannot be healed; repair it in the CAD system")
        solid = as_solid(healed[0])
        notes.append(f"solid {name!r} was invalid as read and has been healed")
    solid = untrimmed(solid)
    facets = facets_of(solid)
    volume, area = facets.bulk()
    if 2.0 * abs(volume) < BULKY * THIN * diagonal_of(solid) * area:
        # too thin for its facets to tell
        properties = GProp_GProps()
        BRepGProp.VolumeProperties_s(solid, properties)
        volume = float(properties.Mass())
        if not _has_volume(solid, volume):
            raise EmptySolidError(f"solid {name!r} has no volume: its faces lie within its tolerance of each other")
    if volume < 0.0:
        solid, facets = as_solid(solid.Reversed()), facets.turned()
        notes.append(f"solid {name!r} was inside out and has been turned")
    return solid, facets, tuple(notes)


def _has_volume(solid: Any, volume: float) -> bool:
    """Whether a solid's volume (mm**3) is more than what its tolerance, or the gaps between its faces, may make of nothing.

    Faces within the tolerance of each other enclose no more than area * tolerance. What does not close by the vector area c
    has a volume that changes by c . s where it is measured from a place s farther on: anywhere within the solid is as good.
    """
    properties = GProp_GProps()
    BRepGProp.SurfaceProperties_s(solid, properties)
    area = abs(float(properties.Mass()))
    box = Bnd_Box()
    BRepBndLib.Add_s(solid, box)
    low, high = (np.array([p.X(), p.Y(), p.Z()]) for p in (box.CornerMin(), box.CornerMax()))
    diagonal = float(np.linalg.norm(high - low))
    if 2.0 * abs(volume) > THIN * diagonal * area:
        return True
    tolerance = float(ShapeAnalysis_ShapeTolerance().Tolerance(solid, 1))
    middle = 0.5 * (low + high)
    here, *there = (_volume_from(solid, apex) for apex in [middle, *(middle + diagonal * np.eye(3))])
    return abs(here) > max(area * tolerance, *(abs(volume - here) for volume in there))


def _volume_from(solid: Any, apex: np.ndarray) -> float:
    """The volume of the cones from an apex (3,) over a solid's faces, mm**3."""
    total, over = 0.0, BRepGProp_Vinert()
    over.SetLocation(gp_Pnt(*apex.tolist()))
    for shape in sub_shapes(solid, TopAbs_FACE):
        face = as_face(shape)
        over.Perform(BRepGProp_Face(face), BRepGProp_Domain(face))
        total += float(over.Mass())
    return total


def unique_names(found: list[tuple[str, Any]]) -> list[tuple[str, Any]]:
    """Named shapes with numbers behind names that occur more than once: name#1, name#2."""
    total: dict[str, int] = {}
    for name, _ in found:
        total[name] = total.get(name, 0) + 1
    seen: dict[str, int] = {}
    out = []
    for name, solid in found:
        seen[name] = seen.get(name, 0) + 1
        out.append((f"{name}#{seen[name]}" if total[name] > 1 else name, solid))
    return out


def boxes_apart(a: Any, b: Any) -> float:
    """How far the boxes round two shapes are apart, mm; 0 where they meet."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    boxes = []
    for shape in (a, b):
        box = Bnd_Box()
        BRepBndLib.Add_s(shape, box, False)
        boxes.append(box)
    return float(boxes[0].Distance(boxes[1]))


def distance_of(a: Any, b: Any) -> float:
    """How far two shapes are apart, mm; infinite where the kernel cannot say."""
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    found = BRepExtrema_DistShapeShape(a, b)
    return float(found.Value()) if found.IsDone() and found.NbSolution() > 0 else float("inf")


def compound(shapes: Any) -> Any:
    """One compound of several shapes."""
    builder = BRep_Builder()
    out = TopoDS_Compound()
    builder.MakeCompound(out)
    for shape in shapes:
        builder.Add(out, shape)
    return out


def volume_of(solid: Any) -> float:
    """Volume in mm**3 by OCCT's adaptive quadrature, asked for 1e-9 on each face."""
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid, properties, 1e-9)
    return float(properties.Mass())


def bytes_from_shape(shape: Any) -> bytes:
    """OCCT's binary form of a shape, for worker processes."""
    stream = io.BytesIO()
    BinTools.Write_s(shape, stream)
    return stream.getvalue()


def shape_from_bytes(data: bytes) -> Any:
    """The shape of `bytes_from_shape`, or of BREP text (DBRep_DrawableShape).

    Raises
    ------
    InputError
        If the bytes are neither.
    """
    from OCP.BRepTools import BRepTools

    shape = TopoDS_Shape()
    try:
        if not data.lstrip().startswith(b"Open CASCADE"):
            BRepTools.Read_s(shape, io.BytesIO(data), BRep_Builder())
        else:
            BinTools.Read_s(shape, io.BytesIO(data))
    except Exception:
        shape = TopoDS_Shape()
    if shape.IsNull():
        raise InputError("these bytes are no BREP shape; write them with BinTools or BRepTools")
    return shape


def holds_point(shape: Any, point: np.ndarray) -> bool:
    """Whether a point (3,) in mm lies inside of a solid."""
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.TopAbs import TopAbs_IN

    return bool(BRepClass3d_SolidClassifier(shape, gp_Pnt(*point.tolist()), 1e-9).State() == TopAbs_IN)
