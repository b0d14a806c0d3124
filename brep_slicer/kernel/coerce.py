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
from .shapes import baked, compound, shape_from_bytes, unique_names


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
    # objects such as children share their geometry with the whole; what is placed twice is named in order
    leaves = [(name, s) for name, leaf in _leaves(thing, "solid") for s in sub_shapes(leaf, TopAbs_SOLID)]
    named = []
    for solid in solids:
        at = next((i for i, (_, leaf) in enumerate(leaves) if leaf.IsPartner(solid)), None)
        name = leaves.pop(at)[0] if at is not None else _label(thing) or "solid"
        named.append((name, baked(as_solid(solid), TopLoc_Location())))
    return unique_names(named)


def _label(thing: Any) -> str:
    """What a host calls an object: build123d's label, CadQuery's name."""
    for attribute in ("label", "name"):
        name = getattr(thing, attribute, "")
        if isinstance(name, str) and name.strip():
            return name.strip()
    return ""


def _leaves(thing: Any, inherited: str) -> list[tuple[str, Any]]:
    """The named shapes that a host object is put together of; a name that is missing is that of what it belongs to."""
    name = _label(thing) or inherited
    if hasattr(thing, "toCompound") and hasattr(thing, "children"):  # CadQuery Assembly: (shape, path of names, ...)
        return [(str(item[1]).split("/")[-1], item[0].wrapped) for item in thing]
    below = thing if isinstance(thing, list | tuple) else getattr(thing, "children", None)  # build123d has a tree of children
    if isinstance(below, list | tuple) and below:
        return [leaf for child in below for leaf in _leaves(child, name)]
    shape = _shape_of(thing)
    return [] if shape is None else [(name, shape)]


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
