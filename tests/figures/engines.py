"""Do both engines agree? 50 random radii a solid: areas, and how far apart the outlines lie; each disagreement is judged.

python -m tests.figures.engines fixtures/step/*.step
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.section import CutSolid, cut_solids
from brep_slicer.section.analytic import sections_by_analysis
from brep_slicer.section.boolean import section_by_boolean
from brep_slicer.section.stepped import outlines_apart
from brep_slicer.testing import area_by_flux

RADII, AWAY = 50, 1e-4
SAME_AREA, SAME_OUTLINE = 1e-6, 1e-5


def compare(solid: CutSolid) -> str:
    """One line of figures for a solid; the disagreements are printed one by one."""
    low, high = solid.critical.lowest, solid.critical.highest
    radii = np.random.default_rng(11).uniform(low, high, 4 * RADII)
    near = np.abs(radii[:, None] - solid.critical.radii).min(axis=1) < min(AWAY, 1e-3 * (high - low))
    radii = np.sort(radii[~near][:RADII])
    area, outline, agree, refused, failed = 0.0, 0.0, 0, 0, 0
    for section, radius in zip(sections_by_analysis(solid, radii), radii.tolist(), strict=True):
        try:
            by_boolean, _ = section_by_boolean(solid.wrapped, radius, critical=solid.critical.radii)
        except LayerError as error:
            failed += 1
            print(f"    R {radius:.9g}: boolean refuses: {error}", flush=True)
            continue
        if isinstance(section, LayerError):
            refused += 1
            continue
        a, b = (sum(loop.signed_area() for loop in loops) for loops in (section[0], by_boolean))
        off = abs(a - b) / max(abs(b), 1e-12)
        apart = outlines_apart(section[0], by_boolean)
        # met at a grazing angle, an edge's gap moves the crossing by more than the gap: the certificate says how far
        allowed = max(SAME_OUTLINE, float(section[1].checks["jog_allowed_mm"]))
        length = sum(loop.length() for loop in section[0])
        if abs(a - b) <= max(SAME_AREA * abs(b), 1e-6 * length * SAME_OUTLINE) and apart <= allowed:
            agree += 1
            area, outline = max(area, off), max(outline, apart)
            continue
        truth = area_by_flux(solid.brep, radius)
        print(
            f"    R {radius:.9g}: areas {a:.9g} and {b:.9g}, outlines {apart:.2e} mm apart, surface integral {truth:.9g}",
            flush=True,
        )
    return (
        f"{len(radii)} radii: {agree} agree (area {area:.1e}, outline {outline:.1e} mm), {refused} refused by analytic,"
        f" {failed} by boolean"
    )


def main(names: list[str]) -> None:
    import OCP

    print(f"OCP {OCP.__version__}")
    for name in names:
        try:
            part = bs.read_step(name)
        except bs.InputError as error:
            print(f"left out: {error}", flush=True)
            continue
        for i, solid in enumerate(cut_solids(part, bs.find_axis(part))):
            print(f"{Path(name).stem}/{i} gap {solid.gaps.max():.1e}: {compare(solid)}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
