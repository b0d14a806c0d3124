"""Users' parts: what is chosen for them, and which of 200 random radii are vouched for, fall back, fail or are wrong.

In: STEP files. Out: a table, a line a part, and below it why its substrate was chosen, what is warned of, each radius that the
analytic engine does not vouch for, and what the surface integral contradicts.

Every area is judged by the quick surface integral; where that differs by more than it is good for, by the exact one.

python -m tests.figures.public [--plan] part.step part.step@axis=X@solid=1@substrate=20
(@: as the options of `plan`; @t= and @d=, mm, for --plan, which plans each part too and counts its layers and warnings)
"""

from __future__ import annotations

import sys
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import brep_slicer as bs
from brep_slicer.errors import BrepSlicerError, LayerError
from brep_slicer.maps import Array
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.section.engines import Found, SolidSections
from brep_slicer.substrate.radius import find_substrate
from brep_slicer.testing import area_by_flux, areas_by_flux, closure_of

RANDOM = 200
# fallbacks tried, a solid (a boolean takes a second), and areas judged by the exact integral (how many are left is printed)
MOST_FALLBACKS, MOST_JUDGED = 20, 12
# seconds for the exact integrals of a solid: helical B-splines whose pcurves wander have millions of nodes
JUDGING = 60.0
# the quick integral is good for this share of the solid's largest section; exact ones are asked for beyond it
QUICK = 5e-4
# of several radii within noise of a level face one is on the section's side of it
SNAPS = np.array([0.0, 1.001e-9, -1.001e-9, 2.1e-5, -2.1e-5])
# a layer of --plan where no t is given: this share of what lies above the substrate; d is twice that
SHARE_OF_HEIGHT = 0.08
COUNTS = ("vouched", "fallback", "failed", "not tried", "contradicted", "not judged")
HEAD = ("part", "axis", "R mm", "to mm", "faces", *COUNTS, "ms a radius", "layers", "s to plan")


def options_of(argument: str) -> tuple[str, dict[str, str]]:
    """A file's name and the options behind it."""
    name, *options = argument.split("@")
    return name, dict(option.split("=", 1) for option in options)


def counts_of_solid(solid: CutSolid, low: float, lines: list[str]) -> tuple[Counter[str], float]:
    """How many of the radii from `low` (mm) on are what, and the seconds that the analytic engine takes for all of them."""
    radii = np.sort(np.random.default_rng(7).uniform(max(low, solid.critical.lowest), solid.critical.highest, RANDOM))
    start = time.perf_counter()
    sections = SolidSections(solid, radii, Engine.ANALYTIC)
    found = list(sections.ahead or [])
    took = time.perf_counter() - start
    refused = np.flatnonzero([isinstance(s, LayerError) for s in found])
    asked = np.random.default_rng(2).permutation(refused)[:MOST_FALLBACKS].tolist()
    counts = Counter(vouched=RANDOM - len(refused))
    counts["not tried"] = len(refused) - len(asked)
    for i in sorted(asked):
        why, found[i] = str(found[i]), sections.section(i)
        counts["failed" if isinstance(found[i], LayerError) else "fallback"] += 1
        lines.append(f"  {solid.index}: R {radii[i]:.12g}: {_said_of(found[i])}; not vouched for: {why}")
    counts.update(contradictions(solid, radii, found, lines))
    return counts, took


def _said_of(found: Found) -> str:
    if isinstance(found, LayerError):
        return f"failed: {found}"
    return f"{found[1].engine.value}, residual {found[1].residual:.2g} mm, bound {found[1].bound:.2g} mm"


def contradictions(solid: CutSolid, radii: Array, found: Sequence[Found], lines: list[str]) -> dict[str, int]:
    """How many areas the surface integral contradicts, and how many that the quick one doubts are left unjudged."""
    areas = np.array([np.nan if isinstance(s, LayerError) else sum(loop.signed_area() for loop in s[0]) for s in found])
    quick = areas_by_flux(solid.brep, radii, level=solid.stretches.face_level)
    scale = max(float(np.nanmax(quick)), 1e-12)
    doubted = np.random.default_rng(1).permutation(np.flatnonzero(np.abs(areas - quick) > QUICK * scale))
    leak = _leak_of(solid) if len(doubted) else 0.0
    judged = wrong = 0
    start = time.perf_counter()
    for i in doubted[:MOST_JUDGED].tolist():
        if time.perf_counter() - start > JUDGING:
            break
        judged += 1
        loops, certificate = found[i]
        # the faces' gaps along the outline are the file's, not the section's, and so is what the flux loses through them
        reach = max(2.0 * float(solid.gaps.max()), certificate.bound)
        allowed = 1e-6 * scale + reach * sum(loop.length() for loop in loops) + leak
        differs = min(_differences(solid, radii[i], float(areas[i]), allowed))
        if differs > allowed:
            wrong += 1
            lines.append(
                f"  {solid.index}: R {radii[i]:.12g}: contradicted: {areas[i]:.9g} mm2 by {certificate.engine.value} differs by"
                f" {differs:.3g} from the surface integral, {allowed:.3g} allowed"
            )
    return {"contradicted": wrong, "not judged": len(doubted) - judged}


def _leak_of(solid: CutSolid) -> float:
    """What the flux may lose where the faces do not close, mm**2."""
    closure = closure_of(solid.brep)
    return closure.defect * closure.volume / float(np.linalg.norm(np.ptp(solid.brep.vertices, axis=0)))


def _differences(solid: CutSolid, radius: float, area: float, allowed: float) -> list[float]:
    """How far the area is from the exact integral, by coarse panels, then by finer ones, until one of them acquits it."""
    differences = [np.inf]
    for panels in (2, 4, 12):
        for snap in SNAPS.tolist():
            if differences[-1] > allowed:
                differences.append(abs(area_by_flux(solid.brep, radius + snap, panels=panels) - area))
    return differences


def planned(part: bs.Part, options: dict[str, str], height: float, chosen: dict[str, Any], lines: list[str]) -> tuple[str, str]:
    """How many layers a plan has (and how many of them failed), and the seconds that it took."""
    thickness = float(options.get("t", SHARE_OF_HEIGHT * height))
    process = bs.Process(layer_thickness=thickness, step_over=float(options.get("d", 2.0 * thickness)))
    start = time.perf_counter()
    try:
        plan = bs.plan(part, process, **chosen)
    except BrepSlicerError as error:
        lines.append(f"  no plan: {error}")
        return "-", f"{time.perf_counter() - start:.1f}"
    took = time.perf_counter() - start
    lines.extend(f"  plan warns: {warning}" for warning in plan.warnings)
    return str(len(plan.layers)), f"{took:.1f}"


def row_of_part(argument: str, plans: bool, lines: list[str]) -> tuple[str, ...]:
    """A part's line of the table; what there is to say below it goes to `lines`."""
    name, options = options_of(argument)
    part = bs.read_step(name, solids=options["solid"].split("+") if "solid" in options else None)
    axis = bs.axis_from_text(options["axis"]) if "axis" in options else bs.find_axis(part)
    given = float(options["substrate"]) if "substrate" in options else None
    solids = cut_solids(part, axis)
    substrate = find_substrate(part, axis, reach={s.index: s.critical.highest for s in solids}, radius=given)
    lines.append(f"  R {substrate.radius:.6g}: {substrate.reason}")
    lines.append(f"  {substrate.roles}; left out: {substrate.left_out}")
    lines.extend(f"  warning: {warning}" for warning in substrate.warnings)
    counts: Counter[str] = Counter()
    seconds, cut = 0.0, [s for s in solids if s.index in substrate.built and s.critical.highest > substrate.radius + 1e-3]
    for solid in cut:
        more, took = counts_of_solid(solid, substrate.radius, lines)
        counts, seconds = counts + more, seconds + took
    highest = max(s.critical.highest for s in solids)
    chosen = {"axis": axis, "substrate": given}
    layers = planned(part, options, highest - substrate.radius, chosen, lines) if plans else ("", "")
    origin, direction = (",".join(f"{x:.4g}" for x in v) for v in (axis.origin, axis.direction))
    faces = str(sum(len(s.brep.faces) for s in solids))
    pace = f"{1e3 * seconds / max(1, RANDOM * len(cut)):.1f}"
    known = (Path(name).stem, f"{origin}:{direction}", f"{substrate.radius:.6g}", f"{highest:.6g}", faces)
    return (*known, *(str(counts[c]) for c in COUNTS), pace, *layers)


def main(arguments: list[str]) -> None:
    print("\t".join(HEAD), flush=True)
    for argument in (a for a in arguments if not a.startswith("--")):
        lines: list[str] = []
        try:
            print("\t".join(row_of_part(argument, "--plan" in arguments, lines)))
        except BrepSlicerError as error:
            print(f"{Path(options_of(argument)[0]).stem}\t{error}")
        print("\n".join(lines), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
