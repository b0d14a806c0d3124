"""Processes from TOML files and from the plain values of the command.

In: a file, or names and values as they stand in one. Out: a Process, or an InputError that names the file.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

from brep_slicer.errors import InputError

from .parameters import CHOICES, WHOLE, Process
from .rules import RULED, Rule
from .values import ANGLES, choice, finite, layer_range, whole

SWITCHES = tuple(f.name for f in fields(Process) if f.type == "bool")
# Keys of a rule that say where it holds.
WHERE = ("layers", "every", "narrower_than", "winds")


def read_process(path: str | Path, **overrides: Any) -> Process:
    """A Process from a TOML file whose keys are the parameters' names (angles as hatch_angles_deg, hatch_angle_step_deg).

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds a key or a value that cannot be used.
    """
    values = read_process_values(path)
    try:
        return process_from_values(values, source=str(path), **overrides)
    except InputError as error:
        raise error if str(path) in str(error) else InputError(f"{path}: {error}") from None


def read_process_values(path: str | Path) -> dict[str, Any]:
    """The plain values of a process file, not yet checked against each other."""
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file; give a TOML file with process parameters") from None
    except RecursionError:
        raise InputError(
            f"{path}: its lists are nested too deeply to be process parameters; write one `name = value` a line"
        ) from None
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"{path}: not a readable TOML file ({error}); write one `name = value` a line") from None


def process_from_values(values: Mapping[str, Any], *, source: str = "process", **overrides: Any) -> Process:
    """A Process from plain values as they stand in TOML (strings for enums, degrees for angles)."""
    out = _parameters(values, [f.name for f in fields(Process)], source)
    out.update({name: value for name, value in overrides.items() if value is not None})
    missing = [n for n in ("layer_thickness", "step_over") if n not in out]
    if missing:
        raise InputError(f"{source}: {' and '.join(missing)} not given; both are required (-t and -d at the command)")
    return Process(**out)


def _parameters(values: Mapping[str, Any], known: Sequence[str], source: str, also: Sequence[str] = ()) -> dict[str, Any]:
    """Values by parameter names, from values by the names that a file has for them."""
    names = {n + "_deg" if n in ("hatch_angles", *ANGLES) else n: n for n in known}
    wrong = [key for key in values if key not in names]
    if wrong:
        near = difflib.get_close_matches(wrong[0], [*names, *also], n=1, cutoff=0.6)
        mend = f"did you mean {near[0]}?" if near else f"known are {', '.join(sorted([*names, *also]))}"
        raise InputError(f"{source}: {wrong[0]} is no process parameter{' that a rule may change' if also else ''}; {mend}")
    return {names[key]: _from_plain(names[key], value, source) for key, value in values.items()}


def _rule(table: Any, source: str) -> Rule:
    if not isinstance(table, dict):
        raise InputError(f"{source}: rules is {table!r}; write each rule as a table, under [[rules]]")
    changes = _parameters({k: v for k, v in table.items() if k not in WHERE}, RULED, f"{source}: in a rule", WHERE)
    where = {key: table[key] for key in WHERE if key in table}
    if "layers" in where:
        where["layers"] = _said(source, layer_range, "layers", where["layers"])
    if not isinstance(where.get("winds", True), bool):
        raise InputError(f"{source}: winds is {where['winds']!r}; it must be true or false")
    if not isinstance(where.get("every", 1), int):
        raise InputError(f"{source}: every is {where['every']!r}; it must be a whole number")
    return Rule(changes=changes, **where)


def _from_plain(name: str, value: Any, source: str) -> Any:
    if name in CHOICES:
        return _said(source, choice, name, value, CHOICES[name])
    if name == "hatch_angles":
        listed = value if isinstance(value, list) else [value]
        return tuple(math.radians(finite(name, a)) for a in listed)
    if name in ANGLES:
        return math.radians(finite(name, value))
    if name in SWITCHES:
        if not isinstance(value, bool):
            raise InputError(f"{source}: {name} is {value!r}; it must be true or false")
        return value
    if name == "rules":
        return tuple(_rule(table, source) for table in (value if isinstance(value, list) else [value]))
    if name in WHOLE:
        return _said(source, whole, name, value)
    return tuple(value) if isinstance(value, list) else value


def _said(source: str, check: Callable[..., Any], *args: Any) -> Any:
    try:
        return check(*args)
    except InputError as error:
        raise InputError(f"{source}: {error}") from None
