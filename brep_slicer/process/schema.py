"""What a process file may hold, as a JSON schema, for editors that complete and check TOML as it is written.

In: the declarations of all parameters. Out: plain values (JSON Schema draft 7).
"""

from __future__ import annotations

import enum
from typing import Any

from .groups import GROUPS, Fill
from .parameter import Declaration, as_written, declarations_of, defaults_of
from .parameters import Process
from .patterns import PATTERNS
from .rules import RULED, Rule
from .values import FASTEST_SPEED, SLOWEST_SPEED

KINDS = {float: "number", int: "integer", bool: "boolean", str: "string"}
LAYERS = r"^\d*:\d*$"


def schema_of_process() -> dict[str, Any]:
    """The schema of a process file: with every pattern that is found, those of other packages too."""
    tables = {name: _table(_properties(group), group.__doc__ or "") for name, group in GROUPS.items()}
    where = _properties(Rule)
    changes = {name: one for name, one in _properties(Fill).items() if name in RULED}
    rules = {"type": "array", "items": _table(where | changes, "Other fill parameters for some layers and pieces.")}
    return {
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "brep_slicer process",
        **_table(_properties(Process) | tables | {"rules": rules}, "How to deposit: mm, degrees, mm/s."),
        "required": list(declarations_of(Process)),
    }


def _table(properties: dict[str, Any], about: str) -> dict[str, Any]:
    text = about.strip().splitlines()[0] if about else ""
    return {"type": "object", "description": text, "additionalProperties": False, "properties": properties}


def _properties(owner: Any) -> dict[str, Any]:
    defaults = defaults_of(owner)
    return {name: _parameter(one, defaults[name]) for name, one in declarations_of(owner).items()}


def _parameter(one: Declaration, default: Any) -> dict[str, Any]:
    details = one.in_words(default)
    out: dict[str, Any] = {"description": f"{one.help} ({details})." if details else f"{one.help}."}
    if one.kind == "pattern":
        return out | _pattern()
    if one.kind == "layers":
        return out | {"type": "string", "pattern": LAYERS}
    value = _value(one)
    out |= {"anyOf": [value, {"type": "array", "items": value, "minItems": 1}]} if one.many else value
    plain = as_written(default)
    return out | ({"default": plain} if isinstance(plain, bool | int | float | str | list) else {})


def _value(one: Declaration) -> dict[str, Any]:
    if isinstance(one.kind, type) and issubclass(one.kind, enum.Enum):
        return {"enum": one.choices()}
    assert isinstance(one.kind, type)
    out: dict[str, Any] = {"type": KINDS[one.kind]}
    low, high = (SLOWEST_SPEED, FASTEST_SPEED) if one.unit == "mm/s" else (one.least, one.most)
    limits = {"minimum": low, "exclusiveMinimum": one.above, "maximum": high, "exclusiveMaximum": one.below}
    return out | {name: limit for name, limit in limits.items() if limit is not None}


def _pattern() -> dict[str, Any]:
    """A name, or a table with a name and the parameters of its pattern."""
    patterns = PATTERNS.all()
    tables = []
    for name, kind in patterns.items():
        table = _table({"name": {"const": name}, **_properties(kind)}, kind.help)
        tables.append(table | {"required": ["name"]})
    return {"anyOf": [{"enum": list(patterns)}, *tables], "default": "auto"}
