"""Host objects in (build123d, CadQuery, OCP, BREP bytes), solids out, without importing the hosts.

In: anything that wraps a TopoDS shape. Out: (name, solid) pairs in millimetres.
"""

from __future__ import annotations

from typing import Any

from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.TopoDS import TopoDS_Shape

from brep_slicer.errors import InputError

from .compat import as_solid, sub_shapes
from .shapes import baked, compound, shape_from_bytes


def solids_from_object(thing: Any) -> list[tuple[str, Any]]:
    """Every solid of a host object.

    Raises
    ------
    InputError
        If the object wraps no shape, or its shape holds no solid.
    """
    shape = _shape_of(thing)
    kind = type(thing).__name__
    if shape is None:
        raise InputError(f"a {kind} is no shape; give a build123d, CadQuery or OCP solid, or BREP bytes")
    if shape.IsNull():
        raise InputError(f"the {kind} is empty; build a solid first")
    solids = [s for s in sub_shapes(shape, TopAbs_SOLID) if sub_shapes(s, TopAbs_FACE)]
    if not solids:
        raise InputError(f"the {kind} holds no solid (surfaces or wires only); give a closed solid")
    name = getattr(thing, "label", "") or getattr(thing, "name", "") or "solid"
    name = name if isinstance(name, str) else "solid"
    here = TopLoc_Location()
    if len(solids) == 1:
        return [(name, baked(as_solid(solids[0]), here))]
    return [(f"{name}#{i + 1}", baked(as_solid(s), here)) for i, s in enumerate(solids)]


def _shape_of(thing: Any) -> Any:
    """The TopoDS shape inside of a host object, or None."""
    if isinstance(thing, TopoDS_Shape):
        return thing
    if isinstance(thing, bytes | bytearray | memoryview):
        return shape_from_bytes(bytes(thing))
    try:
        wrapped = getattr(thing, "wrapped", None)
    except AssertionError:  # build123d asserts that an empty result has a shape
        return None
    if isinstance(wrapped, TopoDS_Shape):
        return wrapped
    if hasattr(thing, "toCompound"):  # CadQuery Assembly, locations included
        return _shape_of(thing.toCompound())
    if hasattr(thing, "vals") and callable(thing.vals):  # CadQuery Workplane
        shapes = [s for s in map(_shape_of, thing.vals()) if s is not None]
        return compound(shapes) if shapes else None
    for builder in ("part", "_obj"):  # build123d builders
        inner = getattr(thing, builder, None)
        if inner is not None and inner is not thing:
            return _shape_of(inner)
    if isinstance(thing, list | tuple):
        shapes = [_shape_of(item) for item in thing]
        return compound(shapes) if shapes and all(s is not None for s in shapes) else None
    return None
