"""STEP files rewritten as other systems write them: seams dropped, cones stated from the other nappe, edges moved.

In: the text of a STEP file. Out: another text of the same solid.
"""

from __future__ import annotations

import re
from pathlib import Path

import brep_slicer as bs

SHARED_CASES = Path(__file__).resolve().parent.parent.parent / "shared" / "cases"


def text_of(shape, folder: Path) -> str:
    """A build123d shape as STEP, an entity a line."""
    import build123d as bd

    path = folder / "made.step"
    bd.export_step(shape, str(path))
    return re.sub(r"\s*\n\s*", "", path.read_text()).replace(";", ";\n")


def part_of(text: str, folder: Path, name: str = "changed") -> bs.Part:
    """The part that a text says."""
    path = folder / f"{name}.step"
    path.write_text(text)
    return bs.read_step(path)


def without_seams(text: str) -> tuple[str, int]:
    """Faces bounded by two rings and a seam there and back are bounded by the two rings alone; how many there were."""
    uses = dict(re.findall(r"(#\d+) = ORIENTED_EDGE\('',\*,\*,(#\d+)", text))
    bounds = {loop: bound for bound, loop in re.findall(r"(#\d+) = FACE_BOUND\('',(#\d+)", text)}
    number = max(int(n) for n in re.findall(r"#(\d+) =", text)) + 1
    dropped = 0
    for loop, inside in re.findall(r"(#\d+) = EDGE_LOOP\('',\(([^)]*)\)\)", text):
        edges = inside.split(",")
        rings = [e for e in edges if [uses[x] for x in edges].count(uses[e]) == 1]
        if len(edges) != 4 or len(rings) != 2:
            continue
        extra = f"#{number} = EDGE_LOOP('',({rings[1]}));\n#{number + 1} = FACE_BOUND('',#{number},.T.);\n"
        text = text.replace(f"{loop} = EDGE_LOOP('',({inside}))", f"{loop} = EDGE_LOOP('',({rings[0]}))")
        text = re.sub(rf"(ADVANCED_FACE\('',\({bounds[loop]})\b", rf"\1,#{number + 1}", text)
        text = text.replace("ENDSEC;\nEND-ISO", extra + "ENDSEC;\nEND-ISO")
        number, dropped = number + 2, dropped + 1
    return text, dropped


def cone_restated(text: str, origin, direction, radius: float, half_angle: float) -> tuple[str, int]:
    """Every conical surface stated from another place on its axis (a negative-radius cone, read from beyond its apex)."""
    number = max(int(n) for n in re.findall(r"#(\d+) =", text)) + 1
    x = (1.0, 0.0, 0.0) if abs(direction[0]) < 0.9 else (0.0, 1.0, 0.0)
    lines = [
        f"CARTESIAN_POINT('',({','.join(f'{c:.15g}' if '.' in f'{c:.15g}' else f'{c:.15g}.' for c in map(float, origin))}))",
        f"DIRECTION('',({','.join(map(str, map(float, direction)))}))",
        f"DIRECTION('',({','.join(map(str, x))}))",
        f"AXIS2_PLACEMENT_3D('',#{number},#{number + 1},#{number + 2})",
    ]
    extra = "".join(f"#{number + i} = {line};\n" for i, line in enumerate(lines))
    stated = f"CONICAL_SURFACE('',#{number + 3},{float(radius):.15f},{half_angle:.15f})"
    text, count = re.subn(r"CONICAL_SURFACE\('',#\d+,[^)]*\)", stated, text)
    return text.replace("ENDSEC;\nEND-ISO", extra + "ENDSEC;\nEND-ISO"), count
