"""Is any layer wrong without saying so? 1,000 random radii a solid, and the critical radii with small steps to either side.

Every certified area is judged by the surface integral: by the quick one, and where that differs by more than it is good for, by
the exact one; some are judged by the exact one anyway. What falls back is held against it by the engines themselves.

python -m tests.figures.certificates [--all] [--fallbacks] fixtures/step/*.step
(--all: every doubt judged; --fallbacks: every fallback tried)
"""

from __future__ import annotations

import itertools
import sys
import time
from collections.abc import Collection, Sequence
from pathlib import Path

import numpy as np

import brep_slicer as bs
from brep_slicer.errors import LayerError
from brep_slicer.maps import Array
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.section.engines import Found, SolidSections
from brep_slicer.testing import area_by_flux, areas_by_flux, closure_of

RANDOM, STEPS = 1000, (0.0, 1e-9, 1e-7, 1e-5, 1e-3)
# the quick integral is good for this share of the solid's largest section; exact ones are asked for beyond it
QUICK = 5e-4
# radii within 1e-9 mm of a level count as that level, and what lies just beyond it is what the section then is; faces that are
# level but for noise of up to 2e-5 mm count as one radius
SNAPS = np.array([0.0, 1.001e-9, 2e-9, -1.001e-9, 2.1e-5, -2.1e-5])
# fallbacks tried (a boolean takes a second) and areas judged by the exact integral in any case, a solid and kind of radius
MOST_FALLBACKS, JUDGED = 20, 4
# of those whose quick integral differs, at most this many are judged by the exact one (how many are left is printed)
MOST_JUDGED = 40


def radii_of_solid(solid: CutSolid) -> dict[str, Array]:
    """The radii to try, increasing, inside of the solid's range."""
    low, high = solid.critical.lowest, solid.critical.highest
    steps = np.array([s * x for s in (-1.0, 1.0) for x in STEPS[1:]] + [0.0])
    near = np.unique(solid.critical.radii[:, None] + steps)
    return {
        "random": np.sort(np.random.default_rng(7).uniform(low, high, RANDOM)),
        "critical": near[(near > max(low, 1e-3)) & (near < high)],
    }


def judge(solid: CutSolid, radii: Array, options: Collection[str]) -> dict[str, float]:
    """Counts of layers tried, certified, fallen back, failed and wrong; the largest differences in area."""
    start = time.perf_counter()
    sections = SolidSections(solid, radii, Engine.ANALYTIC)
    found = sections.ahead or []
    took = (time.perf_counter() - start) / len(radii)
    refused = np.flatnonzero([isinstance(s, LayerError) for s in found])
    asked = np.random.default_rng(2).permutation(refused)[: None if "--fallbacks" in options else MOST_FALLBACKS]
    failed = [i for i in asked.tolist() if isinstance(sections.section(i), LayerError)]
    for i in failed:
        print(f"    failed: R {radii[i]:.12g}", flush=True)
    return {
        "tried": len(radii),
        "certified": len(radii) - len(refused),
        "refused": len(refused),
        "fallbacks tried": len(asked),
        "failed": len(failed),
        **_suspects(solid, radii, found, sys.maxsize if "--all" in options else MOST_JUDGED),
        "ms": 1e3 * took,
    }


def _suspects(solid: CutSolid, radii: Array, found: Sequence[Found], most_judged: int) -> dict[str, float]:
    """How many certified areas the surface integral contradicts."""
    areas = np.array([np.nan if isinstance(s, LayerError) else sum(loop.signed_area() for loop in s[0]) for s in found])
    quick = areas_by_flux(solid.brep, radii, level=solid.stretches.face_level)
    scale = max(float(np.nanmax(quick)), 1e-12)
    off = np.abs(areas - quick) / scale
    whole = np.flatnonzero(np.isfinite(areas))
    doubted = np.random.default_rng(1).permutation(whole[off[whole] > QUICK])
    chosen = np.union1d(doubted[:most_judged], np.random.default_rng(1).choice(whole, min(JUDGED, len(whole)), replace=False))
    wrong, worst = 0, 0.0
    closure = closure_of(solid.brep)
    leak = closure.defect * closure.volume / float(np.linalg.norm(np.ptp(solid.brep.vertices, axis=0)))
    for i in chosen.astype(int):
        # the faces' gaps along the outline are the file's, not the section's (at grazing angles, as far as the certificate
        # says); so is what the flux loses where the faces do not close
        loops, certificate = found[i]
        reach = max(2.0 * float(solid.gaps.max()), float(certificate.checks["jog_allowed_mm"]))
        allowed = 1e-6 * scale + reach * sum(loop.length() for loop in loops) + leak
        differs = np.inf
        # the coarse quadrature acquits most; a finer one judges the others
        for panels, r in itertools.product((4, 12, 24), (radii[i] + SNAPS).tolist()):
            if differs > allowed:
                differs = min(differs, abs(area_by_flux(solid.brep, r, panels=panels) - areas[i]))
        worst = max(worst, differs / scale)
        if differs > allowed:
            wrong += 1
            print(f"    suspect: R {radii[i]:.12g} area {areas[i]:.9g} differs {differs:.3g}", flush=True)
    return {
        "suspects": wrong,
        "not judged": max(0, len(doubted) - most_judged),
        "quick": float(off[whole].max(initial=0.0)),
        "exact": worst,
    }


def main(arguments: list[str]) -> None:
    names = [name for name in arguments if not name.startswith("--")]
    for name in names:
        part = bs.read_step(name)
        for i, solid in enumerate(cut_solids(part, bs.find_axis(part))):
            for kind, radii in radii_of_solid(solid).items():
                if not len(radii):
                    continue
                row = judge(solid, radii, arguments)
                figures = "  ".join(f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in row.items())
                print(f"{Path(name).stem}/{i} gap {solid.gaps.max():.1e} {kind}: {figures}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
