"""Draw docs/patterns.png, every pattern on one page: python docs/pattern_pictures.py (from the project's root)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import brep_slicer as bs
from brep_slicer.fill import (
    Contours,
    FlankFollowing,
    Hatch,
    Helix,
    PatternSequence,
    Rings,
    Skeleton,
    Spiral,
    Zigzag,
    fill_region,
)
from brep_slicer.output.pictures import draw_layer
from brep_slicer.proof import coverage_of

HERE = Path(__file__).parent
D, W = 3.4, 4.9
Z = bs.axis_from_text("Z")


def layer_of(name: str, radius: float):
    """One layer of a fixture."""
    (layer,) = bs.slice_part(bs.read_step(f"fixtures/step/{name}.step"), [radius], axis=Z)
    return layer


def main() -> None:
    """Patterns on a tooth, a blade and a full turn with a keyway, with the share that they leave bare."""
    tooth, blade, band = layer_of("helical_gear_tooth", 165.0), layer_of("propeller", 80.0), layer_of("keyed_band", 50.0)
    overlap = 2.0 * D - W
    cases = [
        ("hatch, both ways", tooth, Hatch(angle=np.radians(30.0))),
        ("zigzag", tooth, Zigzag(angle=np.radians(30.0))),
        ("along the flanks", tooth, FlankFollowing()),
        (
            "contour and hatch",
            tooth,
            PatternSequence(patterns=(Contours(count=1), Hatch(angle=np.radians(30.0))), overlap=overlap),
        ),
        ("contours", tooth, Contours(count=None)),
        ("spiral", tooth, PatternSequence(patterns=(Spiral(), Skeleton()))),
        ("hatch", blade, Hatch(angle=np.radians(30.0))),
        ("contours alone", blade, Contours(count=None)),
        ("contours and skeleton", blade, PatternSequence(patterns=(Contours(count=None), Skeleton()))),
        ("rings", band, Rings()),
        ("helix with closing beads", band, Helix(closing_rings=True)),
        ("hatch round a full turn", band, Hatch(angle=np.radians(60.0))),
    ]
    figure = Figure(figsize=(15, 15), layout="constrained")
    grid = figure.add_gridspec(4, 3, height_ratios=[1.0, 1.0, 1.0, 0.25])
    for k, (name, layer, pattern) in enumerate(cases):
        region = layer.region
        fill = fill_region(region, pattern, step_over=D, width=W, inset=0.0 if layer is not band else 0.5 * W, chord=0.01)
        ax = figure.add_subplot(grid[k // 3, k % 3])
        draw_layer(ax, layer, fill)
        if layer is blade:
            k0, v0, k1, v1 = region.pieces[0].bounds()
            ax.set_xlim(k0 - 2.0, k1 + 2.0)
            ax.set_ylim(v0 - 2.0, v1 + 2.0)
        bare = 100.0 * coverage_of(region, fill.beads, W).bare_share
        ax.set_title(f"{name}: {len(fill.beads)} beads, {bare:.2f} % bare", fontsize=11)
    figure.savefig(HERE / "patterns.png", dpi=80)


if __name__ == "__main__":
    main()
