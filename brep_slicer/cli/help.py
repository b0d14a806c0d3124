"""What `brep-slicer plan --help` says above its options: an example, a line for each pattern and each writer.

In: what patterns and writers say of themselves. Out: texts; made only where the help is asked for.
"""

from __future__ import annotations

from typing import Any

from brep_slicer.output.writers import WRITERS
from brep_slicer.process import PATTERNS
from brep_slicer.process.parameter import declarations_of, defaults_of


def plan_help() -> str:
    """The text above the options; a line of its own for everything that has one."""
    return "\n\n".join(
        (
            "Plan the deposition of a part: toolpath, report, pictures.",
            "\b\nExample: layers of 1.4 mm, beads 3.4 mm apart, a contour and a hatch at 45 and 135 degrees in turn:\n"
            "  brep-slicer plan gear.step -t 1.4 -d 3.4 --contours 1 --angle 45 --angle 135 -o out/",
            "\b\nPatterns (--pattern):\n" + "\n".join(_pattern_lines()),
            "\b\nWriters (--write; those with a * are asked unless others are named):\n" + "\n".join(_writer_lines()),
            "\b\nEvery option but those of part and output may stand in a file instead, given by --process; rules for some\n"
            "layers and pieces may stand there only. brep-slicer init writes such a file, with a comment on each parameter.",
        )
    )


def _pattern_lines() -> list[str]:
    """A line for each pattern; below one of another package, one for each of its parameters, which have no options."""
    patterns = PATTERNS.all()
    width = max(map(len, patterns))
    lines = []
    for name, kind in patterns.items():
        lines.append(f"  {name:<{width}}  {kind.help}")
        if name not in PATTERNS.own():
            lines += _parameter_lines(kind, " " * (width + 4))
    return lines


def _parameter_lines(kind: Any, space: str) -> list[str]:
    defaults = defaults_of(kind)
    return [f"{space}{name}: {one.help} ({one.in_words(defaults[name])})" for name, one in declarations_of(kind).items()]


def _writer_lines() -> list[str]:
    writers = WRITERS.all()
    width = max(map(len, writers))
    return [f"  {name:<{width}}  {kind.help}{' *' if kind.usual else ''}" for name, kind in writers.items()]
