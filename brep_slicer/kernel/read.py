"""STEP files in, named solids in millimetres out, with locations baked into the geometry.

In: a path. Out: (name, solid) pairs in the file's own frame, and the unit that the file states.

Words: *unit*, the length unit of the header; *label*, an entry of OCCT's document tree, which carries a part's name.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_FACE, TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

from brep_slicer.errors import InputError

from .compat import as_solid, label_sequence, sub_shapes
from .shapes import baked, scaled, unique_names
from .silence import silenced

MM_PER_UNIT = {
    "mm": 1.0,
    "millimetre": 1.0,
    "cm": 10.0,
    "dm": 100.0,
    "m": 1000.0,
    "metre": 1000.0,
    "km": 1e6,
    "um": 1e-3,
    "nm": 1e-6,
    "in": 25.4,
    "inch": 25.4,
    "ft": 304.8,
    "mil": 0.0254,
    "microinch": 2.54e-5,
    "yd": 914.4,
    "mile": 1609344.0,
}
# What files call them, beside the names above.
_SPELLINGS = {
    "inches": "inch",
    "foot": "ft",
    "feet": "ft",
    "yard": "yd",
    "yards": "yd",
    "miles": "mile",
    "mils": "mil",
    "thou": "mil",
    "micro_inch": "microinch",
    "micro inch": "microinch",
    "micro-inch": "microinch",
    "microinches": "microinch",
    "uin": "microinch",
}
# What editors put before UTF-8, as it looks in Latin-1.
BYTE_ORDER_MARK = "\xef\xbb\xbf"
_PREFIXES = {"MILLI": "mm", "CENTI": "cm", "DECI": "dm", "KILO": "km", "MICRO": "um", "NANO": "nm"}


def solids_from_step(path: str | Path, *, unit: str | None = None) -> tuple[list[tuple[str, Any]], str]:
    """Read every solid of a STEP file, in millimetres.

    Parameters
    ----------
    path : path
        A STEP file (AP203, AP214 or AP242).
    unit : str, optional
        Length unit to take instead of the header's ("mm", "cm", "m", "inch", ...).

    Returns
    -------
    solids : list of (name, TopoDS_Solid)
    unit : str
        The unit used.

    Raises
    ------
    InputError
        If the file is missing, empty, truncated or no STEP, states no unit, or holds no solid.
    """
    text = _checked_text(Path(path))
    stated = _stated_unit(text)
    asked = "" if unit is None else _SPELLINGS.get(unit.strip().lower(), unit.strip().lower())
    if unit is not None and asked not in MM_PER_UNIT:
        raise InputError(f"{path}: unit {unit!r} is not known; give one of {', '.join(MM_PER_UNIT)}")
    if stated is None and unit is None:
        raise InputError(f"{path}: the file states no length unit; say which it is with --unit (mm, cm, m, inch)")
    try:
        with silenced():
            solids = _named_solids(_read_document(Path(path)))
    except InputError:
        raise
    except Exception as error:  # OCCT raises classes of its own, which share no base
        said = type(error).__name__
        raise InputError(f"{path}: the CAD kernel fails on a solid in it ({said}); repair it and export it again") from None
    if not solids:
        raise InputError(f"{path}: {_what_instead(text)}; export a solid (closed B-Rep) as STEP")
    # OCCT converts to mm by the stated unit, and takes mm where none is stated
    factor = 1.0 if unit is None else MM_PER_UNIT[asked] / (stated[1] if stated else 1.0)
    if factor != 1.0:
        solids = [(name, as_solid(scaled(solid, factor))) for name, solid in solids]
    return solids, asked or (stated[0] if stated else "mm")


def _checked_text(path: Path) -> str:
    if not path.exists():
        raise InputError(f"{path}: there is no such file; check the path")
    if path.is_dir():
        raise InputError(f"{path}: this is a folder; give a STEP file")
    try:
        text = path.read_text(encoding="latin-1")
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}); check its permissions") from None
    if not text.strip():
        raise InputError(f"{path}: the file is empty; export it again")
    if text.startswith(BYTE_ORDER_MARK):
        raise InputError(
            f"{path}: the file begins with a byte-order mark, which STEP does not allow; save it without (plain UTF-8)"
        )
    if "ISO-10303-21" not in text[:2000]:
        raise InputError(f"{path}: this is no STEP file (it does not start with ISO-10303-21); export the part as STEP")
    if "END-ISO-10303-21" not in text[-2000:]:
        raise InputError(f"{path}: the file is cut off (END-ISO-10303-21 is missing); export or copy it again")
    return text


def _stated_unit(text: str) -> tuple[str, float] | None:
    """The length unit that a file's shapes are in, by name, and its millimetres; None where no length unit is stated.

    It is the one that the representation contexts refer to (files may define others that nothing uses), else the first
    conversion based one, which refers to a metric one itself, else the first metric one.
    """
    for entities in (_entities_of_contexts, _entities_defined):
        for entity in entities(text):
            unit = _unit_of(entity, text)
            if unit is not None:
                return unit
    return None


def _entities_defined(text: str) -> list[str]:
    """Every unit of length that a file defines, those based on others first."""
    defined = re.findall(r"#\d+\s*=\s*(\([^;]*?LENGTH_UNIT\s*\([^;]*);", text, flags=re.S)
    return sorted(defined, key=lambda entity: "CONVERSION_BASED_UNIT" not in entity)


def _entities_of_contexts(text: str) -> list[str]:
    """The unit entities that the representation contexts refer to."""
    listed = re.findall(r"GLOBAL_UNIT_ASSIGNED_CONTEXT\s*\(\s*\(([^)]*)\)", text)
    references = [reference for context in listed for reference in re.findall(r"#(\d+)", context)]
    return [entity for reference in dict.fromkeys(references) if "LENGTH_UNIT" in (entity := _entity(reference, text))]


def _entity(reference: str, text: str) -> str:
    """An entity's text by its number; empty where there is none."""
    found = re.search(rf"#{reference}\s*=\s*([^;]*);", text, flags=re.S)
    return found.group(1) if found else ""


def _unit_of(entity: str, text: str) -> tuple[str, float] | None:
    """Name and millimetres of a length unit: an SI unit, or one that is so many of another."""
    converted = re.search(r"CONVERSION_BASED_UNIT\s*\(\s*'([^']*)'\s*,\s*#(\d+)", entity)
    if converted:
        said = converted.group(1).strip().lower()
        name = _SPELLINGS.get(said, said)
        measure = _entity(converted.group(2), text)
        size = re.search(r"LENGTH_MEASURE\s*\(\s*([-+.\dEe]+)\s*\)\s*,\s*#(\d+)", measure)
        base = _unit_of(_entity(size.group(2), text), text) if size and size.group(2) != converted.group(2) else None
        if size and base:
            return name, float(size.group(1)) * base[1]
        return (name, MM_PER_UNIT[name]) if name in MM_PER_UNIT else None
    si = re.search(r"SI_UNIT\s*\(\s*(?:\.(\w+)\.|\$)\s*,\s*\.METRE\.\s*\)", entity)
    if not si:
        return None
    name = _PREFIXES.get(si.group(1) or "", "m")
    return name, MM_PER_UNIT[name]


def _read_document(path: Path) -> Any:
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 0.001)
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    reader.SetColorMode(False)
    try:
        done = reader.ReadFile(str(path)) == IFSelect_RetDone and reader.Transfer(document)
    except Exception as error:  # OCCT raises its own classes for broken entities
        raise InputError(f"{path}: the CAD kernel cannot read it ({error}); export it again") from None
    if not done:
        raise InputError(f"{path}: the CAD kernel finds nothing to read in it; export the part again as STEP")
    return document


def _named_solids(document: Any) -> list[tuple[str, Any]]:
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    roots = label_sequence()
    tool.GetFreeShapes(roots)
    found: list[tuple[str, Any]] = []
    for i in range(1, roots.Length() + 1):
        _collect(roots.Value(i), TopLoc_Location(), found)
    return unique_names(found)


def _collect(label: Any, location: Any, found: list[tuple[str, Any]], name: str = "") -> None:
    """Walk the assembly tree; a component's location is multiplied on, its own name beats its part's."""
    own = _name_of(label) or name
    here = location.Multiplied(XCAFDoc_ShapeTool.GetLocation_s(label))
    target = TDF_Label()
    if XCAFDoc_ShapeTool.GetReferredShape_s(label, target):
        _collect(target, here, found, own if not _name_of(target) else _name_of(target))
        return
    if XCAFDoc_ShapeTool.IsAssembly_s(label):
        children = label_sequence()
        XCAFDoc_ShapeTool.GetComponents_s(label, children)
        for i in range(1, children.Length() + 1):
            _collect(children.Value(i), here, found, own)
        return
    shape = XCAFDoc_ShapeTool.GetShape_s(label)
    if shape.IsNull():
        return
    for solid in sub_shapes(shape, TopAbs_SOLID):
        if sub_shapes(solid, TopAbs_FACE):
            found.append((own or "solid", baked(as_solid(solid), location)))


def _name_of(label: Any) -> str:
    attribute = TDataStd_Name()
    if label.FindAttribute(TDataStd_Name.GetID_s(), attribute):
        return str(attribute.Get().ToExtString()).strip()
    return ""


def _what_instead(text: str) -> str:
    if re.search(r"TESSELLATED|TRIANGULATED", text):
        return "the file holds a mesh and no solid"
    if re.search(r"OPEN_SHELL|SHELL_BASED_SURFACE_MODEL|ADVANCED_FACE", text):
        return "the file holds surfaces and no solid"
    return "there is no solid in the file"
