"""One face for the OCP versions that the project runs on (7.9 with CadQuery, 8.0 with build123d).

In: nothing. Out: shape containers and casts under one name, the version, a clear error where OCP cannot be loaded.
"""

from __future__ import annotations

from typing import Any

from brep_slicer.errors import KernelError


def _check_one_kernel() -> None:
    """Refuse an environment in which two versions of OCP lie over each other: both wheels write the same files."""
    from importlib import metadata

    found = {}
    for name in ("cadquery-ocp", "cadquery-ocp-novtk"):
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    if len({tuple(version.split(".")[:3]) for version in found.values()}) > 1:
        listed = " and ".join(f"{name} {version}" for name, version in found.items())
        raise KernelError(
            f"two versions of the CAD kernel lie over each other in this environment ({listed}); make a fresh one, with"
            ' pip install ".[cadquery]" or pip install ".[build123d]", not both'
        )


_check_one_kernel()
try:
    import OCP
    from OCP.TopoDS import TopoDS
except ImportError as error:  # pragma: no cover - depends on the machine
    if "lib" in str(error) and ".so" in str(error):
        raise KernelError(
            f"the CAD kernel cannot be loaded ({error}); install the system libraries, on Debian or Ubuntu:"
            " apt-get install libgl1 libx11-6"
        ) from error
    raise KernelError(f"the CAD kernel OCP is missing ({error}); pip install cadquery-ocp-novtk") from error

OCP_VERSION: str = getattr(OCP, "__version__", "unknown")

_CASTS = {}
for _name in ("Vertex", "Edge", "Wire", "Face", "Shell", "Solid", "Compound"):
    _CASTS[_name] = getattr(TopoDS, _name + "_s", None) or getattr(TopoDS, _name)


def as_vertex(shape: Any) -> Any:
    """Cast to TopoDS_Vertex."""
    return _CASTS["Vertex"](shape)


def as_edge(shape: Any) -> Any:
    """Cast to TopoDS_Edge."""
    return _CASTS["Edge"](shape)


def as_wire(shape: Any) -> Any:
    """Cast to TopoDS_Wire."""
    return _CASTS["Wire"](shape)


def as_face(shape: Any) -> Any:
    """Cast to TopoDS_Face."""
    return _CASTS["Face"](shape)


def as_solid(shape: Any) -> Any:
    """Cast to TopoDS_Solid."""
    return _CASTS["Solid"](shape)


def shape_list(shapes: Any = ()) -> Any:
    """OCCT's list of shapes, filled."""
    try:
        from OCP.TopTools import TopTools_ListOfShape as ListOfShape
    except ImportError:
        from OCP.collections import List_TopoDS_Shape as ListOfShape
    out = ListOfShape()
    for shape in shapes:
        out.Append(shape)
    return out


def indexed_map() -> Any:
    """OCCT's indexed map of shapes (identity by IsSame)."""
    try:
        from OCP.TopTools import TopTools_IndexedMapOfShape as IndexedMap
    except ImportError:
        from OCP.collections import IndexedMap_TopoDS_Shape_TopTools_ShapeMapHasher as IndexedMap
    return IndexedMap()


def label_sequence() -> Any:
    """OCCT's sequence of document labels."""
    try:
        from OCP.TDF import TDF_LabelSequence as LabelSequence
    except ImportError:
        from OCP.collections import Sequence_TDF_Label as LabelSequence
    return LabelSequence()


def sub_shapes(shape: Any, kind: Any) -> list[Any]:
    """Every sub-shape of one TopAbs kind, each once (IsSame), in OCCT's order."""
    from OCP.TopExp import TopExp

    found = indexed_map()
    TopExp.MapShapes_s(shape, kind, found)
    return [found.FindKey(i) for i in range(1, found.Extent() + 1)]


def array_of_reals(values: Any) -> Any:
    """OCCT's array of reals, from 1 on."""
    try:
        from OCP.TColStd import TColStd_Array1OfReal as Reals
    except ImportError:
        from OCP.collections import Array1_double as Reals
    return _filled(Reals, [float(x) for x in values])


def array_of_integers(values: Any) -> Any:
    """OCCT's array of integers, from 1 on."""
    try:
        from OCP.TColStd import TColStd_Array1OfInteger as Integers
    except ImportError:
        from OCP.collections import Array1_int as Integers
    return _filled(Integers, [int(x) for x in values])


def array_of_points_2d(points: Any) -> Any:
    """OCCT's array of points of the plane, from 1 on, of (n, 2) numbers."""
    from OCP.gp import gp_Pnt2d

    try:
        from OCP.TColgp import TColgp_Array1OfPnt2d as Points
    except ImportError:
        from OCP.collections import Array1_gp_Pnt2d as Points
    return _filled(Points, [gp_Pnt2d(float(x), float(y)) for x, y in points])


def _filled(kind: Any, values: list[Any]) -> Any:
    out = kind(1, len(values))
    for i, value in enumerate(values, start=1):
        out.SetValue(i, value)
    return out
