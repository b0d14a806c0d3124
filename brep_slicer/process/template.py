"""A process file to begin with: every parameter with a comment on it, all but the required ones switched off.

In: the declarations of all parameters. Out: TOML.
"""

from __future__ import annotations

import json
import textwrap
from collections.abc import Iterator
from typing import Any

from .groups import GROUPS
from .parameter import Declaration, as_written, declarations_of, defaults_of
from .parameters import Process
from .patterns import PATTERNS
from .rules import RULED, Rule

WIDTH = 110


def process_template(layer_thickness: float, step_over: float, *, schema: str) -> str:
    """The text of a process file; `schema` is where its JSON schema lies, as seen from the file."""
    given = {"layer_thickness": layer_thickness, "step_over": step_over}
    assumed = Process(**given).assumed()  # type: ignore[arg-type]
    lines = [
        f"#:schema {schema}",
        "# A process of brep_slicer: brep-slicer plan PART.step --process THIS.toml -o out/",
        "# Lengths in mm, angles in degrees, speeds in mm/s. Take away the # before a name to give it another value.",
    ]
    for name, one in declarations_of(Process).items():
        lines += ["", *_comment(one, defaults_of(Process)[name]), f"{name} = {_toml(given[name])}"]
    for table, group in GROUPS.items():
        defaults = defaults_of(group)
        lines += ["", "", f"# {(group.__doc__ or '').strip()}", f"[{table}]"]
        for name, one in declarations_of(group).items():
            value = assumed.get(table, {}).get(name, one.example if defaults[name] is None else defaults[name])
            lines += ["", *_comment(one, defaults[name]), *(_patterns() if one.kind == "pattern" else ())]
            lines.append(f"# {name} = {_toml(as_written(value))}")
    return "\n".join([*lines, *_rules()]) + "\n"


def _comment(one: Declaration, default: Any) -> list[str]:
    details = one.in_words(default)
    return [f"# {line}" for line in textwrap.wrap(f"{one.help} ({details})." if details else f"{one.help}.", WIDTH)]


def _patterns() -> Iterator[str]:
    """A line for each pattern, with what its parameters are when nothing is given."""
    for name, kind in PATTERNS.all().items():
        yield f"#   {name}: {kind.help}"
        defaults = defaults_of(kind)
        values = {
            key: one.example if defaults[key] is None else as_written(defaults[key])
            for key, one in declarations_of(kind).items()
        }
        if values:
            yield f"#     pattern = {_toml({'name': name, **values})}"


def _rules() -> list[str]:
    about = f"Other fill parameters ({', '.join(RULED)}) for some layers and pieces; the first rule that holds counts."
    lines = ["", "", *(f"# {line}" for line in textwrap.wrap(about, WIDTH)), "# [[rules]]"]
    for name, one in declarations_of(Rule).items():
        default = defaults_of(Rule)[name]
        value = "0:3" if one.kind == "layers" else one.example if default is None else default
        lines += [*_comment(one, default if one.kind != "layers" else None), f"# {name} = {_toml(value)}"]
    return [*lines, "# contours = 2"]


def _toml(value: Any) -> str:
    """A plain value as TOML has it."""
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {_toml(one)}" for key, one in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    return json.dumps(value)
