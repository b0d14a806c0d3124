"""The proof that the metal is even: what it measures, held against closed forms, and what the patterns reach."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import (
    Bead,
    BeadKind,
    Contours,
    FlankFollowing,
    Hatch,
    PatternSequence,
    Rings,
    Skeleton,
    Spiral,
    fill_region,
    in_short_order,
    with_speed_by_spacing,
)
from brep_slicer.fill.passes.order import travel_of
from brep_slicer.layers import cylinder
from brep_slicer.proof import coverage_of, deposit_of, evenness_of, step_over_of
from brep_slicer.region import region_from_loops

from .test_fill import ARGS, D, R, W, band, box
from .test_patterns import plain_band

Z = bs.axis_from_text("Z")
ON = {**ARGS, "inset": 0.0}
T = 1.4
CONTOURS_AND_HATCH = [
    PatternSequence(patterns=(Contours(count=1, skeleton=False), Hatch(angle_deg=a)), overlap=2.0 * D - W)
    for a in range(0, 180, 15)
]
CONTOURS_AND_SKELETON = PatternSequence(patterns=(Contours(skeleton=False), Skeleton()))


def polygon(*corners):
    lines = tuple(LineCurve.between(a, b) for a, b in itertools.pairwise([*corners, corners[0]]))
    return region_from_loops(cylinder(R), [Loop(curves=lines, sheet=cylinder(R))])


def test_coverage_of_one_bead_in_closed_form():
    (bead,) = fill_region(polygon((0, 0), (W, 0), (W, 30), (0, 30)), Hatch(angle_deg=90.0), **ARGS).beads
    found = coverage_of(box_around(), [bead], W)
    strip = bead.length() * W + math.pi * W**2 / 4.0
    assert found.once == pytest.approx(strip, rel=1e-3)
    assert found.bare == pytest.approx(found.area - strip, rel=1e-3)
    assert found.more == pytest.approx(0.0, abs=1e-9)


def box_around():
    return polygon((-20, -20), (40, -20), (40, 60), (-20, 60))


def test_two_beads_overlap_by_what_their_spacing_leaves():
    width = 3.0 * D + 0.02
    region = polygon((0, 0), (width, 0), (width, 200), (0, 200))
    beads = fill_region(region, Hatch(angle_deg=90.0), **ON).beads
    found = coverage_of(region, beads, W)
    assert len(beads) == 4
    assert found.bare_share < 1e-4
    assert found.more / found.area == pytest.approx((W - D) / D, rel=2e-2)


def test_a_full_turn_of_rings_deposits_t_everywhere_across_the_seam():
    region = plain_band(W + 9 * D)
    rings = fill_region(region, Rings(), **ARGS)
    made = deposit_of(region, rings.beads, width=W, thickness=T, step_over=D)
    inner = (made.v > 2 * W) & (made.v < 2 * W + 5 * D)
    heights = made.heights[inner][:, :-1]
    assert heights.mean() == pytest.approx(T, rel=1e-2)
    # no seam shows: every column is the same
    assert np.ptp(heights, axis=1).max() < 1e-3 * T


def test_the_metal_of_a_bead_is_t_d_per_length():
    (bead,) = fill_region(polygon((0, 0), (W, 0), (W, 60), (0, 60)), Hatch(angle_deg=90.0), **ARGS).beads
    made = deposit_of(box_around(), [bead], width=W, thickness=T, step_over=D)
    cell = made.kappa[1] - made.kappa[0]
    ends = 3.0 * math.pi / 32.0 * W * 2.0
    assert np.nansum(made.heights) * cell**2 == pytest.approx(T * D * (bead.length() + ends), rel=2e-3)


@pytest.mark.parametrize("start", range(4))
def test_a_square_contour_lays_its_own_metal_and_all_its_corners_are_alike(start):
    side = 12.0 * W
    region = polygon((0, 0), (side, 0), (side, side), (0, side))
    (ring,) = fill_region(region, Contours(count=1, skeleton=False), **ARGS).beads
    corners = np.roll(ring.points[:-1], start, axis=0)
    bead = replace(ring, points=np.concatenate([corners, corners[:1]]))
    made = deposit_of(region, [bead], width=W, thickness=T, step_over=D)
    cell = made.kappa[1] - made.kappa[0]
    assert np.nansum(made.heights) * cell**2 == pytest.approx(T * D * bead.length(), rel=1e-3)
    for other in (made.heights.T, made.heights[::-1], made.heights[:, ::-1]):
        assert np.abs(made.heights - other).max() < 1e-6 * T
    # no corner is bare, or twice as high
    middle = 1.5 * D / W * T
    at = np.searchsorted(made.kappa, 0.5 * W)
    assert made.heights[at, at] == pytest.approx(middle, rel=0.1)
    assert np.nanmax(made.heights) < 1.5 * middle


@pytest.mark.parametrize("amount", [1.0, 0.5, 1.6])
def test_the_peak_of_one_bead_in_closed_form(amount):
    bead = Bead(points=[(-20.0, 0.0), (20.0, 0.0)], kind=BeadKind.HATCH, speed=[1.0 / amount, 1.0 / amount])
    region = polygon((-30, -10), (30, -10), (30, 10), (-30, 10))
    found = evenness_of(region, [bead], width=W, thickness=T, step_over=D, tolerance=0.02)
    # 1.5 t d / w (1 - (2 s / w)**2) averaged over s = -w / 4 to w / 4
    assert found.peak == pytest.approx(amount * 1.5 * T * D / W * (1.0 - 1.0 / 12.0), rel=5e-3)
    assert found.peak_at is not None
    assert abs(found.peak_at[1]) < W / 24.0
    # two beads on one another are twice as high, and a second piece elsewhere does not move the place
    twice = evenness_of(region, [bead, bead], width=W, thickness=T, step_over=D, tolerance=0.02)
    assert twice.peak == pytest.approx(2.0 * found.peak, rel=1e-9)


def test_a_proof_says_its_peak_and_warns_of_a_high_one(fixture_step):
    part = bs.read_step(fixture_step("spur_gear_tooth"))
    process = bs.Process(layer_thickness=4.0, step_over=D, fill=bs.Fill(contours=1, pattern="hatch"))
    made = bs.plan(part, process, layers="0:2")
    rows = made.proof()
    assert not made.proof_notices
    assert all(1.0 < row["peak_height_over_t"] < 2.0 for row in rows)
    for row in rows:
        k0, v0, k1, v1 = made.layers[row["layer"]].region.pieces[row["peak_at"]["piece"]].bounds()
        assert k0 <= row["peak_at"]["kappa_mm"] <= k1
        assert v0 <= row["peak_at"]["v_mm"] <= v1
    # hatch lines that end on the contour's own centre line
    piled = bs.plan(part, process.updated(fill={"overlap": D, "balance": False}), layers="0:2")
    assert not piled.proof_notices
    piled.proof()
    (said,) = piled.proof_notices
    assert said.layers == (0, 1)
    assert "higher than 2 t" in str(said)
    assert "piece 0, at kappa" in str(said)
    assert str(said) in piled.warnings
    assert said.as_dict() in piled.report()["notices"]


def test_a_line_that_turns_back_beside_itself_lays_its_own_metal():
    from brep_slicer.fill import Zigzag

    (bead,) = fill_region(box(), Zigzag(angle_deg=math.degrees(0.3)), **ARGS).beads
    slow = replace(bead, speed=np.linspace(0.5, 2.0, len(bead.points)))
    # as the toolpath lays it: each segment at the mean of the speeds at its ends, and so its round end
    steps, metal = np.hypot(*np.diff(bead.points, axis=0).T), 2.0 / (slow.speed[1:] + slow.speed[:-1])
    for laid, length, ends in ((bead, steps.sum(), 2.0), (slow, (steps * metal).sum(), metal[0] + metal[-1])):
        made = deposit_of(box_around(), [laid], width=W, thickness=T, step_over=D)
        cell = made.kappa[1] - made.kappa[0]
        expected = T * D * (length + ends * 3.0 * math.pi / 32.0 * W)
        assert np.nansum(made.heights) * cell**2 == pytest.approx(expected, rel=1e-3)


TEETH = [("helical_gear_tooth", (152.0, 165.0, 183.0)), ("spur_gear_tooth", (152.0, 179.0))]


@pytest.mark.parametrize(("name", "radii"), TEETH)
def test_contours_and_hatch_leave_nothing_bare_on_a_tooth_at_any_angle(name, radii, fixture_step):
    for layer in bs.slice_part(bs.read_step(fixture_step(name)), list(radii), axis=Z):
        for pattern in CONTOURS_AND_HATCH:
            fill = fill_region(layer.region, pattern, **ON)
            assert coverage_of(layer.region, fill.beads, W).bare_share <= 0.005


def test_contours_and_skeleton_leave_nothing_bare_on_a_blade_down_to_the_tip(fixture_step):
    layers = bs.slice_part(bs.read_step(fixture_step("propeller")), [60.0, 80.0, 100.0, 118.0, 140.0, 149.9], axis=Z)
    bare = {}
    for name, pattern in {"both": CONTOURS_AND_SKELETON, "contours": Contours(skeleton=False), "hatch": Hatch()}.items():
        fills = [fill_region(layer.region, pattern, **ON) for layer in layers]
        bare[name] = max(coverage_of(la.region, f.beads, W).bare_share for la, f in zip(layers, fills, strict=True))
    assert bare["both"] <= 0.005
    # neither hatch nor contours alone do it
    assert bare["contours"] > 0.02
    assert bare["hatch"] > 0.005


def test_beads_that_pass_over_keep_their_bounds_and_speed_keeps_the_height():
    region = polygon((-15, 0), (15, 0), (12, 60), (-13, 60))
    beads = fill_region(region, FlankFollowing(), **ON).beads
    even = deposit_of(region, with_speed_by_spacing(beads, step_over=D, limits=(0.5, 2.0)), width=W, thickness=T, step_over=D)
    assert deposit_of(region, beads, width=W, thickness=T, step_over=D).share_within(T, 0.02) < 0.6
    assert even.share_within(T, 0.02) >= 0.99
    assert even.mean == pytest.approx(T, rel=0.005)
    first = beads[0].points
    for bead in beads[1:]:
        gap = np.hypot(*(bead.points.mean(axis=0) - first.mean(axis=0)))
        first = bead.points
        assert 0.75 * D <= gap <= 1.26 * D


@pytest.mark.parametrize("ratio", [4.0, 8.0])
def test_flanks_of_a_smooth_outline_run_from_tip_to_tip(ratio):
    # an ellipse has no corner: its flanks are its two halves, and no bead is laid on another
    s = np.linspace(0.0, 2.0 * math.pi, 241)[:-1]
    turned = np.array([[math.cos(0.6), math.sin(0.6)], [-math.sin(0.6), math.cos(0.6)]])
    outline = np.stack([40.0 * np.cos(s), 40.0 / ratio * np.sin(s)], axis=1) @ turned
    region = polygon(*outline.tolist())
    fill = fill_region(region, FlankFollowing(), **ON)
    made = deposit_of(region, fill.beads, width=W, thickness=T, step_over=D)
    assert coverage_of(region, fill.beads, W).bare_share < 0.015
    assert 0.9 * T < made.mean < 1.1 * T


def test_where_beads_would_be_squeezed_some_end():
    region = polygon((-15, 0), (15, 0), (4, 60), (-4, 60))
    fill = fill_region(region, FlankFollowing(), **ON)
    assert "beads end and fewer go on" in str(fill.notes[0])
    assert coverage_of(region, fill.beads, W).bare_share < 0.005


@pytest.mark.parametrize("angle", [0.0, 17.0, 60.0, 90.0])
def test_step_over_is_measured_on_the_emitted_points_across_the_seam(angle, fixture_step):
    part = bs.read_step(fixture_step("keyed_band"))
    process = bs.Process(layer_thickness=2.0, step_over=D, fill=bs.Fill(bead_width=W, pattern=bs.Automatic(angle_deg=angle)))
    plan = bs.plan(part, process, axis=Z, substrate=45.0, layers=(0, 1))
    used = plan.fills[0].step_over[0]
    found = step_over_of(plan.toolpath, plan.axis, 0).spacings
    near = found[found < 1.5 * D]
    assert len(near) > 100
    assert np.abs(near - used).max() <= 1e-6


def test_a_spiral_is_one_bead_with_turns_a_step_over_apart():
    fill = fill_region(box(), Spiral(skeleton=False), **ON)
    (bead,) = fill.beads
    assert bead.kind.value == "spiral"
    rings = fill_region(box(), Contours(skeleton=False), **ON).beads
    # the outermost and innermost rings whole, and a turn between each two: the mean of both
    expected = 0.5 * (rings[0].length() + rings[-1].length()) + sum(b.length() for b in rings)
    assert bead.length() == pytest.approx(expected, rel=0.02)


def test_short_order_keeps_every_bead_and_shortens_travel():
    rng = np.random.default_rng(4)
    beads = [b for k in range(12) for b in fill_region(shifted(k), Hatch(angle_deg=math.degrees(0.3)), **ARGS).beads]
    mixed = [beads[i] for i in rng.permutation(len(beads))]
    ordered = in_short_order(mixed, cylinder(R).closure)
    assert len(ordered) == len(mixed)
    key = sorted(tuple(np.sort(b.points.ravel()).round(9)) for b in mixed)
    assert sorted(tuple(np.sort(b.points.ravel()).round(9)) for b in ordered) == key
    assert travel(ordered) < 0.3 * travel(mixed)


def shifted(k):
    return polygon((25.0 * k, 0), (25.0 * k + 14, 0), (25.0 * k + 14, 20), (25.0 * k, 20))


def travel(beads):
    ends = np.array([[b.points[0], b.points[-1]] for b in beads])
    return travel_of(ends, [(i, False) for i in range(len(beads))], cylinder(R).closure)


def test_a_plan_proves_itself(fixture_step):
    process = bs.Process(
        layer_thickness=T, step_over=D, fill=bs.Fill(bead_width=W, outline_position="on", balance=False, pattern="flank")
    )
    plan = bs.plan(bs.read_step(fixture_step("helical_gear_tooth")), process, layers=(0, 4))
    for row in plan.proof():
        assert row["bare_share"] < 0.005
        assert row["mean_height_over_t"] == pytest.approx(1.0, abs=0.02)
        measured = row["step_over_measured_mm"]
        assert measured["lowest"] == pytest.approx(D, abs=1e-6)
        assert measured["highest"] == pytest.approx(D, abs=1e-6)
        assert sum(measured["histogram"]["counts"]) == measured["spacings"] > 50
        assert 0.5 < row["duty"] < 1.0


def test_a_keyway_is_not_counted_as_bare():
    found = coverage_of(band(), fill_region(band(), Rings(), **ON).beads, W)
    assert found.area == pytest.approx(band().area, rel=1e-9)
    assert found.bare_share < 0.02


@pytest.mark.parametrize("pattern", ["rings", "helix", bs.Zigzag(angle_deg=math.degrees(0.5))], ids=str)
def test_step_over_of_the_other_straight_patterns(pattern, fixture_step):
    part = bs.read_step(fixture_step("keyed_band"))
    process = bs.Process(layer_thickness=2.0, step_over=D, fill=bs.Fill(bead_width=W, pattern=pattern))
    plan = bs.plan(part, process, axis=Z, substrate=45.0, layers=(0, 1))
    found = step_over_of(plan.toolpath, plan.axis, 0).spacings
    near = found[found < 1.5 * D]
    assert len(near) > 50
    assert np.abs(near - plan.fills[0].step_over[0]).max() <= 1e-6


@pytest.mark.parametrize("region", [box(), polygon((-15, 0), (15, 0), (4, 60), (-4, 60))], ids=["box", "taper"])
def test_contours_and_spirals_keep_their_bounds(region):
    import shapely

    chord = ARGS["chord"]
    rings = [shapely.LinearRing(b.points) for b in fill_region(region, Contours(skeleton=False), **ON).beads]
    for outer, inner in itertools.pairwise(rings):
        # every point of a contour is a step-over from the one before, and no nearer
        gaps = shapely.distance(outer, shapely.points(shapely.get_coordinates(shapely.segmentize(inner, 0.3))))
        assert np.abs(gaps - D).max() <= 4.0 * chord
    (spiral,) = fill_region(region, Spiral(skeleton=False), **ON).beads
    places = shapely.points(shapely.get_coordinates(shapely.segmentize(shapely.LineString(spiral.points), 0.3)))
    # nowhere does a spiral leave more between its turns than the contours that it runs between
    bands = shapely.union_all([ring.buffer(D) for ring in rings])
    assert bands.covers(shapely.MultiPoint(places))
    assert coverage_of(region, [spiral], 2.0 * D).bare_share < 1e-3
