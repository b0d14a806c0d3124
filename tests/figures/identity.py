"""The volume identity on STEP files: V by the sections, V and its closure defect by the surface integral, a line a solid.

python -m tests.figures.identity fixtures/step/*.step
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import brep_slicer as bs
from brep_slicer.section import cut_solids
from brep_slicer.testing import closure_of, integrate_sections


def main(names: list[str]) -> None:
    head = ("solid", "V mm3", "closure", "relative error", "of moment", "estimate", "in slivers", "sections", "boolean", "s")
    print("\t".join(head))
    for name in names:
        part = bs.read_step(name)
        axis = bs.axis_from_text("Z") if "fixtures" in name else bs.find_axis(part)
        for i, solid in enumerate(cut_solids(part, axis)):
            start = time.perf_counter()
            found = integrate_sections(solid, relative=1e-9)
            took = time.perf_counter() - start
            closure = closure_of(solid.brep)
            volume = closure.volume
            farthest = float(abs(solid.brep.vertices[:, 2]).max()) * volume
            row = (
                f"{Path(name).stem}/{i}",
                f"{volume:.9g}",
                f"{closure.defect:.1e}",
                f"{found.volume / volume - 1.0:.1e}",
                f"{(found.moment - closure.moment) / farthest:.1e}",
                f"{found.volume_error / volume:.1e}",
                f"{found.in_slivers / volume:.1e}",
                str(found.sections),
                str(found.by_boolean),
                f"{took:.1f}",
            )
            print("\t".join(row), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
