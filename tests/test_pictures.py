"""What the pictures show: lines broken where the unrolled window ends."""

from __future__ import annotations

import numpy as np
import pytest

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import Bead, BeadKind, LayerFill
from brep_slicer.layers import cylinder
from brep_slicer.output.pictures import draw_layer
from brep_slicer.region import Layer, region_from_loops
from brep_slicer.section import Certificate, Engine

from .test_fill import TURN, R


def closed(*corners):
    """A loop through `corners`, material on its left."""
    pairs = zip(corners, [*corners[1:], corners[0]], strict=True)
    return Loop(curves=tuple(LineCurve(p0=a, p1=b) for a, b in pairs), sheet=cylinder(R))


def band_with(*loops):
    lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(TURN, 0.0)),), sheet=cylinder(R), winding=1)
    upper = Loop(curves=(LineCurve(p0=(TURN, 40.0), p1=(0.0, 40.0)),), sheet=cylinder(R), winding=-1)
    region = region_from_loops(cylinder(R), [lower, upper, *loops])
    certificate = Certificate(engine=Engine.ANALYTIC, residual=0.0, jog=0.0, checks={})
    return Layer(index=0, level=R, cut_level=R, thickness=1.0, region=region, area=region.area, certificate=certificate)


def drawn(layer, beads=()):
    """(lines of the outline, lines of beads, corners of the metal) as the picture has them."""
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    draw_layer(axes, layer, LayerFill(beads=tuple(beads)))
    outline = [np.column_stack(line.get_data()) for line in axes.lines]
    laid = [path.vertices for path in axes.collections[0].get_paths()]
    return outline, laid, [patch.get_path().vertices for patch in axes.patches]


def reach(lines):
    """The widest step of any line, and how far out it is drawn, over a turn."""
    steps = [np.nanmax(np.abs(np.diff(line[:, 0])), initial=0.0) for line in lines if len(line) > 1]
    return max(steps) / TURN, max(np.nanmax(np.abs(line[:, 0])) for line in lines) / TURN


# a diamond's corner, or the middle of a square's side, on the seam
HOLES = {
    "corner": closed((0.5 * TURN, 12), (0.5 * TURN - 8, 20), (0.5 * TURN, 28), (0.5 * TURN + 8, 20)),
    "side": closed((0.5 * TURN - 8, 12), (0.5 * TURN - 8, 28), (0.5 * TURN + 8, 28), (0.5 * TURN + 8, 12)),
}


@pytest.mark.parametrize("hole", HOLES.values(), ids=HOLES)
def test_a_hole_over_the_seam_is_broken_at_the_edge_of_the_picture(hole):
    bead = Bead(points=hole.sample(0.02), kind=BeadKind.CONTOUR, closed=True)
    outline, beads, _ = drawn(band_with(hole), [bead])
    for lines in (outline[2:], beads):
        widest, farthest = reach(lines)
        assert widest * TURN <= 16.0 + 1e-9
        assert farthest <= 0.5 + 1e-12
        # all of it is there
        length = sum(np.nansum(np.hypot(*np.diff(line, axis=0).T)) for line in lines)
        assert length == pytest.approx(hole.length(), rel=1e-9)


def test_a_piece_and_a_bead_of_more_than_a_turn_beside_a_band_stay_in_the_window():
    thread = closed((-0.7 * TURN, 50), (0.8 * TURN, 70), (0.8 * TURN, 76), (-0.7 * TURN, 56))
    bead = Bead(points=np.array([[-1.5 * TURN, 53.0], [0.8 * TURN, 73.0]]), kind=BeadKind.FLANK)
    layer = band_with(thread)
    outline, beads, metal = drawn(layer, [bead])
    for lines in (outline, beads, metal):
        assert reach(lines)[1] <= 0.5 + 1e-12
    assert reach(beads)[0] <= 1.0 + 1e-12
    (line,) = beads
    assert np.isnan(line).any(axis=1).sum() == 2
