"""Processes from TOML files and from the plain values of the command.

In: a file, or names and values as they stand in one. Out: a Process, or an InputError that names the file.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from brep_slicer.errors import InputError

from .groups import GROUPS, where_it_stands
from .parameter import check_names
from .parameters import TOP, Process

REQUIRED = ("layer_thickness", "step_over")


def read_process(path: str | Path, **overrides: Any) -> Process:
    """A Process from a TOML file: the two required parameters at its top, a table for each group, [[rules]].

    `overrides` are values that hold instead of the file's, a group's in a dict: read_process(path, fill={"contours": 2}).

    Raises
    ------
    InputError
        If the file is missing, is no TOML, or holds a key or a value that cannot be used.
    """
    return process_from_values(read_process_values(path), source=str(path), **overrides)


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
    """A Process from plain values as they stand in TOML or in a report (None: not given); every error names the `source`."""
    try:
        given = dict(values)
        for name, value in overrides.items():
            if name in GROUPS and isinstance(value, Mapping):
                given[name] = _over(name, given.get(name), value)
            elif value is not None:
                given[name] = value
        check_names(given, TOP, "process parameter", where_it_stands())
        missing = [name for name in REQUIRED if given.get(name) is None]
        if missing:
            raise InputError(f"{' and '.join(missing)} not given; both are required (-t and -d at the command)")
        return Process(**{name: value for name, value in given.items() if value is not None})
    except InputError as error:
        raise InputError(f"{source}: {error}") from None


def _over(name: str, below: Any, above: Mapping[str, Any]) -> Any:
    """A group's values with others over them; a pattern's parameters stay if it remains the same pattern."""
    if below is not None and not isinstance(below, Mapping):
        return below if isinstance(below, str | int | float | list) else {**below.as_dict(), **above}
    out = {**(below or {}), **{key: value for key, value in above.items() if value is not None and key != "pattern"}}
    pattern, given = out.get("pattern"), above.get("pattern")
    if given is not None:
        out["pattern"] = _pattern_over(pattern, given)
    return out


def _pattern_over(below: Any, above: Any) -> Any:
    if not isinstance(above, Mapping):
        return above
    before = {"name": below} if isinstance(below, str) else dict(below or {"name": "auto"})
    return dict(above) if above.get("name", before["name"]) != before["name"] else {**before, **above}
