"""Equal pieces are proven once: which are equal, when they may be, and that the figures are those of the whole layer."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import Bead, BeadKind, Contours, Hatch, LayerFill, Rings, fill_region
from brep_slicer.layers import cylinder
from brep_slicer.proof import coverage_of, evenness_of
from brep_slicer.proof.coverage import coverage_of_shares
from brep_slicer.proof.equals import leaders_of, shares_of
from brep_slicer.region import region_from_loops

from .test_fill import ARGS, TURN, D, R, W, rectangle

T = 1.4
SIZES = {"width": W, "thickness": T, "step_over": D, "tolerance": 0.02}


def boxes(*corners, wide=12.0, high=20.0):
    return region_from_loops(cylinder(R), [rectangle(k, v, k + wide, v + high) for k, v in corners])


def ring(low, high):
    lower = Loop(curves=(LineCurve(p0=(0.0, low), p1=(TURN, low)),), sheet=cylinder(R), winding=1)
    upper = Loop(curves=(LineCurve(p0=(TURN, high), p1=(0.0, high)),), sheet=cylinder(R), winding=-1)
    return [lower, upper]


def filled(region, pattern):
    return fill_region(region, pattern, **ARGS)


def times_of(region, fill):
    return sorted(share.times for share in shares_of(region, fill, width=W))


APART = [(-50.0, 0.0), (-10.0, 0.0), (30.0, 40.0)]


@pytest.mark.parametrize("pattern", [Hatch(angle_deg=0.0), Contours(skeleton=False)], ids=["hatch", "contours"])
def test_pieces_moved_round_or_along_stand_for_one_another(pattern):
    region = boxes(*APART)
    fill = filled(region, pattern)
    assert times_of(region, fill) == [3]
    # also if some beads run the other way and are laid in another order
    turned = replace(fill, beads=tuple(bead.reversed() if bead.piece == 1 else bead for bead in fill.beads[::-1]))
    assert times_of(region, turned) == [3]


def test_rings_of_equal_collars_stand_for_one_another():
    region = region_from_loops(cylinder(R), [loop for low in (0.0, 60.0, 120.0) for loop in ring(low, low + 17.0)])
    assert times_of(region, filled(region, Rings())) == [3]


def test_a_piece_with_other_beads_or_speeds_is_proven_by_itself():
    region = boxes(*APART)
    fill = filled(region, Hatch(angle_deg=0.0))
    chosen = next(i for i, bead in enumerate(fill.beads) if bead.piece == 2)
    bead = fill.beads[chosen]
    for other in (
        replace(bead, speed=np.full(len(bead.points), 0.5)),
        replace(bead, points=bead.points + np.array([0.0, 0.01])),
    ):
        beads = (*fill.beads[:chosen], other, *fill.beads[chosen + 1 :])
        assert times_of(region, replace(fill, beads=beads)) == [1, 2]
    short = replace(fill, beads=(*fill.beads[:chosen], *fill.beads[chosen + 1 :]))
    assert times_of(region, short) == [1, 2]


def test_pieces_that_differ_are_not_equal():
    loops = [rectangle(-50, 0, -38, 20), rectangle(-10, 0, 2, 20.01), rectangle(30, 0, 42, 20)]
    region = region_from_loops(cylinder(R), loops)
    heights = [piece.bounds()[3] for piece in region.pieces]
    leader = leaders_of(region, LayerFill(beads=()))
    assert len(np.unique(leader)) == 2
    odd = int(np.argmax(heights))
    assert leader[odd] == odd
    assert (leader == odd).sum() == 1


@pytest.mark.parametrize(
    "gap", [0.5 * W + 0.01, 0.9 * W], ids=["a bead's edge in the other piece", "two beads' edges over one another"]
)
def test_pieces_that_beads_reach_over_are_proven_together(gap):
    region = boxes((0.0, 0.0), (12.0 + gap, 0.0))
    # along the pieces' own borders, half of them outside
    beads = []
    for number, piece in enumerate(region.pieces):
        k0, v0, k1, v1 = piece.bounds()
        beads += [Bead(points=np.array([[k, v0], [k, v1]]), kind=BeadKind.FLANK, piece=number) for k in (k0, k1)]
    assert times_of(region, LayerFill(beads=tuple(beads))) == [1]
    far = boxes((0.0, 0.0), (12.0 + W + 0.2, 0.0))
    moved = [replace(bead, points=bead.points + np.array([W + 0.2 - gap if bead.piece else 0.0, 0.0])) for bead in beads]
    assert times_of(far, LayerFill(beads=tuple(moved))) == [2]


def test_pieces_near_each_other_over_the_seam_are_proven_together():
    # 12 mm wide, their borders 1 mm apart over the seam
    region = boxes((0.0, 0.0), (TURN - 13.0, 0.0))
    fill = filled(region, Hatch(angle_deg=0.0))
    wide = replace(fill, beads=tuple(replace(bead, points=bead.points * [1.0, 1.0]) for bead in fill.beads))
    assert times_of(region, wide) == [2]
    beads = []
    for number, piece in enumerate(region.pieces):
        k0, v0, k1, v1 = piece.bounds()
        beads += [Bead(points=np.array([[k, v0], [k, v1]]), kind=BeadKind.FLANK, piece=number) for k in (k0, k1)]
    assert times_of(region, LayerFill(beads=tuple(beads))) == [1]


@pytest.mark.parametrize("name", ["helical_gear", "propeller", "spur_gear"])
def test_the_figures_are_those_of_the_whole_layer(name, fixture_step):
    part = bs.read_step(fixture_step(name))
    plan = bs.plan(part, bs.Process(layer_thickness=T, step_over=D, fill=bs.Fill(bead_width=W)), axis="Z", layers=(2, 3))
    (layer,), (fill,) = plan.layers, plan.fills
    shares = shares_of(layer.region, fill, width=W)
    assert sum(share.times * len(share.region.pieces) for share in shares) == len(layer.region.pieces)
    assert sum(len(share.region.pieces) for share in shares) < len(layer.region.pieces)
    whole, parts = coverage_of(layer.region, fill.beads, W), coverage_of_shares(shares, W)
    for field in ("area", "bare", "once", "more", "outside"):
        assert getattr(parts, field) == pytest.approx(getattr(whole, field), rel=1e-6, abs=1e-6 * whole.area)
    every = evenness_of(layer.region, fill.beads, **SIZES)
    one = evenness_of(layer.region, fill.beads, **SIZES, shares=shares)
    # the cells lie elsewhere on the pieces: a fraction of a cell's width of their border
    assert one.mean == pytest.approx(every.mean, rel=2e-3)
    assert one.variation == pytest.approx(every.variation, rel=2e-2)
    assert one.within == pytest.approx(every.within, abs=2e-2)


@pytest.mark.parametrize("collar", [False, True])
def test_nothing_lies_outside_where_a_piece_is_over_the_seam(collar):
    # beads half a width inside of every border
    loops = [rectangle(0.5 * TURN + k, 0.0, 0.5 * TURN + k + 20.0, 20.0) for k in (-12.0, 20.0, -60.0)]
    region = region_from_loops(cylinder(R), [*loops, *(ring(40.0, 57.0) if collar else [])])
    fill = filled(region, Hatch(angle_deg=0.0))
    # but for the round ends of beads that are drawn as polygons
    assert coverage_of(region, fill.beads, W).outside == pytest.approx(0.0, abs=1e-6)


def test_what_lies_outside_over_the_seam_counts_once():
    region = region_from_loops(cylinder(R), [rectangle(0.5 * TURN - 10.0, 0.0, 0.5 * TURN + 10.0, 20.0)])
    line = np.array([[0.5 * TURN - 10.0, 20.0], [0.5 * TURN + 10.0, 20.0]])
    found = coverage_of(region, [Bead(points=line, kind=BeadKind.HATCH)], W)
    # half of a stadium 20 mm long and W wide, and the round ends beside the piece's corners
    half = 20.0 * 0.5 * W + math.pi * (0.5 * W) ** 2 - 0.5 * math.pi * (0.5 * W) ** 2
    ends = 0.5 * math.pi * (0.5 * W) ** 2
    assert found.outside == pytest.approx(half + ends, rel=1e-3)
