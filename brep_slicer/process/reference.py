"""The reference page of all parameters: docs/process.md is this text.

In: the declarations of all parameters, what patterns say of themselves. Out: Markdown.
"""

from __future__ import annotations

from dataclasses import MISSING
from typing import Any

from brep_slicer.wording import counted

from .groups import GROUPS
from .parameter import Declaration, declarations_of, defaults_of, in_words, option_names
from .parameters import Process
from .patterns import PATTERNS
from .rules import RULED, Rule

HEAD = """# The process: every parameter

Written by `python -m docs.reference` from the declarations in `brep_slicer/process/` and `brep_slicer/fill/patterns/`; do
not edit it by hand. `layer_thickness` and `step_over` stand at the top of a process file, the others in the table of their
group; in Python a group is a class: `bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(contours=1))`.
`brep-slicer init` writes a file with all of them in comments, and a JSON schema beside it, by which editors complete and
check it. Lengths are in mm, angles in degrees, speeds in mm/s.
"""
PATTERNS_HEAD = """{count} come with brep_slicer; [add_a_pattern.md](add_a_pattern.md) says how to add one. A pattern is given
by its name, or by a table with its name and its parameters: `pattern = {{ name = "helix", starts = 2 }}`, at the command
`--pattern helix --starts 2` or `--pattern helix:starts=2`, in Python `bs.Helix(starts=2)`.
"""


def reference_page() -> str:
    """The page, without patterns of other packages."""
    parts = [HEAD, "## At the top\n", _table(Process)]
    for table, group in GROUPS.items():
        parts += [f"## [{table}]: {group.title.lower()}\n", f"{(group.__doc__ or '').strip()}\n", _table(group)]
    patterns = {name: PATTERNS.load(name) for name in PATTERNS.own()}
    parts += ["## Patterns\n", PATTERNS_HEAD.format(count=counted(len(patterns), "pattern"))]
    for name, kind in patterns.items():
        parts += [f"### {name}\n", f"{kind.help[0].upper()}{kind.help[1:]} (`bs.{kind.__name__}`).\n"]
        parts += [_table(kind)] if declarations_of(kind) else []
    changes = ", ".join(f"`{name}`" for name in RULED)
    parts += [
        "## [[rules]]\n",
        f"A rule changes {changes} for some layers and pieces; of several that hold, the first counts.\n",
    ]
    return "\n".join([*parts, _table(Rule, options=False)])


def _table(owner: Any, *, options: bool = True) -> str:
    defaults = defaults_of(owner)
    rows = ["| parameter | unit | range | default | option | |", "|---|---|---|---|---|---|"]
    for name, one in declarations_of(owner).items():
        option = ", ".join(f"`{text}`" for text in option_names(name, one)) if options else ""
        cells = [f"`{name}`", one.unit, _range(one), _default(one, defaults[name]), option, f"{one.help}."]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows) + "\n"


def _range(one: Declaration) -> str:
    kind: Any = one.kind
    words = one.range_in_words() or {bool: "true or false", int: "whole number"}.get(kind, "")
    return "; ".join(text for text in (words, "one or several" if one.many else "") if text)


def _default(one: Declaration, default: Any) -> str:
    if one.assumed:
        return one.assumed
    if one.kind == "layers":
        return "all"
    return "required" if default is MISSING else in_words(default)
