"""The options of `brep-slicer plan` that are made from the declarations of the process's parameters and the patterns'.

In: declarations. Out: parameters of a function, for the parser; a process's values from what was given.

Only our own patterns' parameters are options: those of other packages are not looked for before a name needs them, and are
given behind the name, as --pattern wave:amplitude=2.
"""

from __future__ import annotations

import inspect
import tomllib
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Optional

import typer

from brep_slicer.errors import InputError
from brep_slicer.process import GROUPS, PATTERNS, Process
from brep_slicer.process.parameter import Declaration, declarations_of, defaults_of, option_names

# What separates a group's name from a parameter's in the names that the parser hands over.
APART = "__"
PATTERN = "pattern"
PATTERN_PANEL = "Patterns' parameters"
PATTERN_HELP = "What fills a layer inside of its contours: a name, or name:parameter=value,...; all are listed above"


def process_options() -> list[inspect.Parameter]:
    """A parameter of a function for each of the process's, and for each of our own patterns'."""
    out = [
        _option(name, one, defaults_of(Process)[name], "Layers" if name == "layer_thickness" else "Beads")
        for name, one in declarations_of(Process).items()
    ]
    for table, group in GROUPS.items():
        defaults = defaults_of(group)
        out += [_option(table + APART + name, one, defaults[name], group.title) for name, one in declarations_of(group).items()]
    for name, (one, default, users) in sorted(_of_patterns().items(), key=lambda item: item[1][2]):
        out.append(_option(PATTERN + APART + name, one, default, PATTERN_PANEL, behind=f"for {', '.join(users)}"))
    return out


def _of_patterns() -> dict[str, tuple[Declaration, Any, list[str]]]:
    """The parameters of our own patterns by name, with their default (None where patterns differ) and whose they are."""
    found: dict[str, tuple[Declaration, Any, list[str]]] = {}
    for pattern in PATTERNS.own():
        kind = PATTERNS.load(pattern)
        for name, one in declarations_of(kind).items():
            default = defaults_of(kind)[name]
            _, before, users = found.get(name, (one, default, []))
            found[name] = (one, default if before == default else None, [*users, pattern])
    return found


def _option(name: str, one: Declaration, default: Any, panel: str, behind: str = "") -> inspect.Parameter:
    names = option_names(name.split(APART)[-1], one)
    details = "; ".join(text for text in (one.in_words(default), behind) if text)
    text = PATTERN_HELP if one.kind == PATTERN else f"{one.help} ({details})." if details else f"{one.help}."
    kind: Any = one.kind if one.kind in (float, int, bool) else str
    asked: Any = Annotated[
        Optional[list[kind] if one.many else kind],  # noqa: UP045
        typer.Option(*names, help=text, rich_help_panel=panel, show_default=False),
    ]
    return inspect.Parameter(name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=asked)


def process_values(given: Mapping[str, Any]) -> dict[str, Any]:
    """A process's values, in the form of a process file, from what the parser handed over; what was not given is left out."""
    out: dict[str, Any] = {}
    pattern: dict[str, Any] = {}
    for name, value in _given(given):
        table, _, last = name.rpartition(APART)
        if table == PATTERN:
            pattern[last] = value
        elif (table, last) == ("fill", PATTERN):
            pattern = {**pattern_from_text(value), **pattern}
        elif table:
            out.setdefault(table, {})[last] = value
        else:
            # one thickness for all layers, or one for each
            out[name] = value[0] if isinstance(value, list) and len(value) == 1 else value
    if pattern:
        out.setdefault("fill", {})[PATTERN] = pattern
    return out


def _given(given: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    for name, value in given.items():
        if value is not None and not (isinstance(value, list | tuple) and not value):
            yield name, list(value) if isinstance(value, tuple) else value


def pattern_from_text(text: str) -> dict[str, Any]:
    """A pattern's table from its name at the command, with its parameters behind a colon: helix:starts=2,left_handed=true.

    Raises
    ------
    InputError
        If what is behind the colon is not of that form.
    """
    name, colon, rest = text.partition(":")
    try:
        return {**(tomllib.loads(f"table = {{{rest}}}")["table"] if colon else {}), "name": name}
    except tomllib.TOMLDecodeError:
        raise InputError(
            f"--pattern {text}: write its parameters as name:parameter=value,... with texts in quotes, as helix:starts=2"
        ) from None
