"""Patterns by their names: the modules of fill/patterns/, and the entry points of the group `brep_slicer.patterns`.

In: a name, a table of a process file, or a pattern. Out: a pattern.
"""

from __future__ import annotations

import importlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from brep_slicer.errors import InputError
from brep_slicer.extensions import Extensions

if TYPE_CHECKING:
    from brep_slicer.fill import Pattern

PATTERNS = Extensions(
    kind="pattern", folder="fill/patterns", group="brep_slicer.patterns", base="brep_slicer.fill.pattern:Pattern"
)


def as_pattern(name: str, value: Any) -> Pattern:
    """A pattern from itself, its name, or a table of its name and its parameters; `name` is what messages call it.

    Raises
    ------
    InputError
        If there is no such pattern, or it does not take what is given.
    """
    if isinstance(value, str):
        value = {"name": value}
    if not isinstance(value, Mapping):
        module, base = PATTERNS.base.split(":")
        if isinstance(value, getattr(importlib.import_module(module), base)):
            return value  # type: ignore[no-any-return]
        raise InputError(f"{name} is {value!r}; give a pattern, its name, or a table with its name and its parameters")
    if not isinstance(value.get("name"), str):
        raise InputError(f"{name} is {dict(value)!r}; give the pattern's name, as {name} = {{ name = 'hatch' }}")
    kind = PATTERNS.load(value["name"])
    return kind(**{key: given for key, given in value.items() if key != "name" and given is not None})  # type: ignore[no-any-return]
