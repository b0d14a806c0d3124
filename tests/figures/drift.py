"""What isometry avoids: the same tooth hatched in (theta, u) as slicers do that transform coordinates, step-over in degrees.

The hatch is planned once on the substrate's cylinder and carried out to each layer by its angles, so its spacing grows with R.

python -m tests.figures.drift
"""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np

import brep_slicer as bs
from brep_slicer.fill import Hatch, fill_region
from brep_slicer.layers import cylinder
from brep_slicer.proof import coverage_of, deposit_of

T, D, W, R0 = 1.4, 3.4, 4.9, 150.0


def main() -> None:
    part = bs.read_step("fixtures/step/helical_gear_tooth.step")
    layers = bs.slice_part(part, [150.0, 155.6, 161.2, 166.8, 172.4, 178.0, 182.2], axis=bs.axis_from_text("Z"))
    pattern = Hatch(angle_deg=75.0)
    print("R mm\tspacing\tbare\theight/t\tvariation\t| in (theta, u): spacing\tbare\theight/t\tvariation")
    for layer in layers:
        figures = []
        for scale in (1.0, layer.radius / R0):
            ground = layer.region.on_sheet(cylinder(layer.radius / scale))
            fill = fill_region(ground, pattern, step_over=D, width=W, inset=0.0, chord=0.005)
            beads = [replace(b, points=b.points * np.array([scale, 1.0])) for b in fill.beads]
            along = beads[0].points[1] - beads[0].points[0]
            normal = np.array([-along[1], along[0]]) / math.hypot(*along)
            spacing = float(np.median(np.abs([(b.points[0] - a.points[0]) @ normal for a, b in itertools.pairwise(beads)])))
            made = deposit_of(layer.region, beads, width=W, thickness=T, step_over=D)
            bare = coverage_of(layer.region, beads, W).bare_share
            figures.append(f"{spacing:.4f}\t{100 * bare:.2f} %\t{made.mean / T:.3f}\t{made.variation:.3f}")
        print(f"{layer.radius:.1f}\t" + "\t| ".join(figures))


if __name__ == "__main__":
    main()
