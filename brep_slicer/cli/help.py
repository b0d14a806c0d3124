"""What `brep-slicer plan --help` says beside its options: an example, a line for each pattern, what only a file can say.

In: the process parameters' own names. Out: texts.
"""

from __future__ import annotations

from dataclasses import fields

from brep_slicer.process import InnerPattern, Process

# The groups that options are shown in.
INPUT, LAYERS, METAL = "Part: what is built, on what", "Layers", "Beads"
OUTPUT, TUNING = "What is written", "How it is computed"

PATTERN_LINES = {
    "auto": "for each piece what covers it: hatch, or contours and skeleton where it is narrow",
    "hatch": "parallel lines at --angle, exactly a step-over apart",
    "zigzag": "the same lines joined to one bead along the outline",
    "flank": "lines along the piece's two long edges, as the flanks of a tooth",
    "contours": "along the outline, as many as fit, then along the skeleton",
    "spiral": "one bead from the outline inwards, then along the skeleton",
    "skeleton": "one bead along the middle, for thin tips",
    "rings": "closed rings round the shaft, on full bands",
    "helix": "one continuous bead round the shaft, on full bands",
}
# Parameters that options of other names stand for.
_BY_OPTION = {
    "layer_thickness",
    "step_over",
    "bead_width",
    "inset",
    "contours",
    "pattern",
    "fit",
    "allowance",
    "order",
    "speed_follows_spacing",
    "hatch_angles_deg",
    "hatch_angle_step_deg",
    "both_ways",
    "deposition_speed_mm_s",
    "chord",
    "last_layer",
    "cut_at",
}


def pattern_names() -> list[str]:
    """The names that --pattern takes."""
    return [pattern.value for pattern in InnerPattern]


def only_in_files() -> list[str]:
    """Process parameters that have no option."""
    return [f.name for f in fields(Process) if f.name not in _BY_OPTION]


def plan_help() -> str:
    """The text above the options; a line of its own for everything that has one."""
    width = max(map(len, pattern_names()))
    patterns = [f"  {name:<{width}}  {PATTERN_LINES.get(name, '')}".rstrip() for name in pattern_names()]
    names, lines = only_in_files(), [""]
    for name in names:
        comma = "," if name is not names[-1] else ""
        if len(lines[-1]) + len(name) > 70:
            lines.append("")
        lines[-1] += f"{'  ' if not lines[-1] else ' '}{name}{comma}"
    return "\n\n".join(
        (
            "Plan the deposition of a part: toolpath.csv, toolpath.json, report.json, layers.png, toolpath.png.",
            "\b\nExample: layers of 1.4 mm, beads 3.4 mm apart, a contour and a hatch at 45 and 135 degrees in turn:\n"
            "  brep-slicer plan gear.step -t 1.4 -d 3.4 --contours 1 --angle 45 --angle 135 -o out/",
            "\b\nPatterns:\n" + "\n".join(patterns),
            "\b\nOnly in a file with --process (TOML; names as in brep_slicer.Process):\n" + "\n".join(lines),
        )
    )


PLAN_HELP = plan_help()
