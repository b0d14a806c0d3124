"""Beads in the plane: exact step-over, exact inset, nothing lost, the full turn closed."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import given, settings
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop, SinusoidCurve
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
    with_spread_starts,
)
from brep_slicer.fill.tools.distance import Outline, ends_at_inset
from brep_slicer.fill.tools.full_turn import closing_lines
from brep_slicer.layers import cylinder
from brep_slicer.proof import coverage_of
from brep_slicer.region import Region, region_from_loops
from brep_slicer.section import cut_solids

R = 20.0
SHEET = cylinder(R)
TURN = 2.0 * math.pi * R
D, W = 3.4, 4.9
ARGS = {"step_over": D, "width": W, "inset": 0.5 * W, "chord": 0.005}


def rectangle(k0, v0, k1, v1, *, hole=False):
    corners = [(k0, v0), (k1, v0), (k1, v1), (k0, v1)]
    corners = corners[::-1] if hole else corners
    return Loop(curves=tuple(LineCurve(p0=corners[i], p1=corners[(i + 1) % 4]) for i in range(4)), sheet=SHEET)


def box() -> Region:
    return region_from_loops(SHEET, [rectangle(-10.0, 0.0, 15.0, 30.0)])


def band() -> Region:
    lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(TURN, 0.0)),), sheet=SHEET, winding=1)
    upper = Loop(curves=(LineCurve(p0=(TURN, 40.0), p1=(0.0, 40.0)),), sheet=SHEET, winding=-1)
    return region_from_loops(SHEET, [lower, upper, rectangle(55.0, 10.0, 70.0, 30.0, hole=True)])


def wavy() -> Region:
    top = SinusoidCurve(coefficients=np.array([20.0, 3.0, 1.0]), radius=R, range=(12.0, -12.0))
    sides = [
        LineCurve(p0=(-12.0, 0.0), p1=(12.0, 0.0)),
        LineCurve(p0=(12.0, 0.0), p1=top.start),
        top,
        LineCurve(p0=top.end, p1=(-12.0, 0.0)),
    ]
    return region_from_loops(SHEET, [Loop(curves=tuple(sides), sheet=SHEET)])


def leaning(turned: float = 0.0, first: int = 0, lean: float = 50.0, wide: float = 20.0, count: int = 4) -> Region:
    """A band with blades that lean over the next ones: every kappa meets the upper edge several times; it begins anywhere."""
    blade = ((0.0, 20.0), (lean, 45.0), (lean + wide, 45.0), (wide, 20.0))
    once = [(i * TURN / count + k, v) for i in range(count) for k, v in blade]
    places = [(once[j % len(once)], j // len(once)) for j in range(first, first + len(once) + 1)]
    corners = [(k + turns * TURN + turned, v) for (k, v), turns in places]
    upper = tuple(LineCurve(p0=q, p1=p) for p, q in itertools.pairwise(corners))[::-1]
    lower = (LineCurve(p0=(turned + 3.0, 0.0), p1=(turned + 3.0 + TURN, 0.0)),)
    loops = [Loop(curves=lower, sheet=SHEET, winding=1), Loop(curves=upper, sheet=SHEET, winding=-1)]
    return region_from_loops(SHEET, loops)


REGIONS = {"box": box, "band": band, "wavy": wavy}
angle_deg = st.one_of(st.sampled_from([0.0, 90.0, 45.0, -30.0, 180.0]), st.floats(-180.0, 180.0))


def along(points: np.ndarray, step: float = 0.05) -> np.ndarray:
    parts = [np.linspace(a, b, max(2, int(np.hypot(*(b - a)) / step))) for a, b in itertools.pairwise(points)]
    return np.concatenate(parts)


@pytest.mark.parametrize("make", REGIONS.values(), ids=REGIONS)
@given(degrees=angle_deg)
@settings(max_examples=25, deadline=None)
def test_hatch_keeps_its_inset_and_ends_on_it(make, degrees):
    region = make()
    fill = fill_region(region, Hatch(angle_deg=degrees), **ARGS)
    outline = Outline(region.pieces[:1], 0.5 * W)
    gaps, _ = outline.distances(np.concatenate([along(b.points) for b in fill.beads]))
    assert gaps.min() >= 0.5 * W - 1e-9
    ends = np.concatenate([b.points for b in fill.beads if not b.closed] or [np.zeros((0, 2))])
    if len(ends):
        gaps, _ = outline.distances(ends)
        # a grazing line may stop short where sliding on would take it more than the outline's slack allows
        assert np.quantile(np.abs(gaps - 0.5 * W), 0.8) <= 1e-9


@pytest.mark.parametrize("make", REGIONS.values(), ids=REGIONS)
@given(degrees=angle_deg)
@settings(max_examples=25, deadline=None)
def test_hatch_lines_are_a_step_over_apart(make, degrees):
    fill = fill_region(make(), Hatch(angle_deg=degrees), **ARGS)
    angle, step = fill.angle[0], fill.step_over[0]
    offset = np.array([b.points[0] @ [-math.sin(angle), math.cos(angle)] for b in fill.beads]) / step
    assert np.abs((offset - offset[0]) - np.round(offset - offset[0])).max() < 1e-9
    for bead in fill.beads:
        assert np.abs(np.diff(bead.points @ [-math.sin(angle), math.cos(angle)])).max() < 1e-9


@given(st.floats(5.0, 500.0), st.floats(-180.0, 180.0), st.floats(0.2, 5.0))
def test_lines_close_round_the_shaft(radius, degrees, step):
    # L sin(phi) = k d, k whole
    turn = 2.0 * math.pi * radius
    angle, spacing, k = closing_lines(turn, math.radians(degrees), step)
    assert turn * math.sin(angle) == pytest.approx(k * spacing, rel=1e-9, abs=1e-9)
    assert -0.5 * math.pi < angle <= 0.5 * math.pi + 1e-12
    # d is kept and the angle moves, but near 90 degrees, or where k lines of d are longer than the turn
    if abs(math.degrees(angle)) < 79.0 and abs(k) * step < turn:
        assert spacing == step


def test_rings_close_and_a_hatch_crosses_the_seam():
    rings = fill_region(band(), Hatch(angle_deg=0.0), **ARGS)
    closed = [b for b in rings.beads if b.closed]
    assert len(closed) == 4
    assert all(b.length() == pytest.approx(TURN, rel=1e-12) for b in closed)
    hatch = fill_region(band(), Hatch(angle_deg=10.0), **ARGS)
    # no bead ends at the seam: every end lies at the inset from a real edge
    assert max(b.length() for b in hatch.beads) > TURN


@given(st.floats(0.0, TURN))
@settings(max_examples=20, deadline=None)
def test_where_a_band_is_cut_open_is_nobodys_business(start):
    lower = Loop(curves=(LineCurve(p0=(start, 0.0), p1=(start + TURN, 0.0)),), sheet=SHEET, winding=1)
    upper = Loop(curves=(LineCurve(p0=(start + TURN, 40.0), p1=(start, 40.0)),), sheet=SHEET, winding=-1)
    region = region_from_loops(SHEET, [lower, upper, rectangle(55.0, 10.0, 70.0, 30.0, hole=True)])
    for pattern in (Hatch(angle_deg=30.0), Contours(count=2, skeleton=False)):
        lengths = [np.sort([b.length() for b in fill_region(r, pattern, **ARGS).beads]) for r in (region, band())]
        assert np.allclose(lengths[0], lengths[1], atol=1e-6)


def test_both_ways_alternates():
    fill = fill_region(box(), Hatch(angle_deg=0.0), **ARGS)
    ways = [np.sign(b.points[1, 0] - b.points[0, 0]) for b in fill.beads]
    assert ways == [(-1.0) ** i * ways[0] for i in range(len(ways))]
    one_way = fill_region(box(), Hatch(angle_deg=0.0, both_ways=False), **ARGS)
    assert {np.sign(b.points[1, 0] - b.points[0, 0]) for b in one_way.beads} == {1.0}


@pytest.mark.parametrize("make", REGIONS.values(), ids=REGIONS)
def test_contours_are_step_overs_inside(make):
    region = make()
    fill = fill_region(region, Contours(count=2, skeleton=False), **ARGS)
    outline = Outline(region.pieces[:1], 0.5 * W)
    for bead in fill.beads:
        gaps, _ = outline.distances(bead.points)
        nearest = 0.5 * W if gaps.min() < 0.5 * W + 0.5 * D else 0.5 * W + D
        assert nearest <= gaps.min() <= nearest + 0.02
        assert bead.closed


def test_contours_then_hatch_keep_apart():
    fill = fill_region(
        box(), PatternSequence(patterns=(Contours(count=1, skeleton=False), Hatch(angle_deg=math.degrees(0.3)))), **ARGS
    )
    assert [b.kind.value for b in fill.beads[:2]] == ["contour", "hatch"]
    outline = Outline(box().pieces[:1], W)
    gaps, _ = outline.distances(np.concatenate([b.points for b in fill.beads[1:]]))
    assert gaps.min() >= 0.5 * W + D - 1e-9


def test_a_piece_narrower_than_a_bead_gets_one_along_its_skeleton_and_that_is_said():
    narrow = region_from_loops(SHEET, [rectangle(0.0, 0.0, 4.0, 30.0)])
    fill = fill_region(narrow, Hatch(angle_deg=0.0), **ARGS)
    (bead,) = fill.beads
    assert bead.kind.value == "skeleton"
    assert np.allclose(bead.points[:, 0], 2.0)
    assert "too narrow for a bead 2.45 mm inside of its outline: one bead along its skeleton" in str(fill.notes[0])


def test_a_piece_without_a_bead_is_said():
    tiny = region_from_loops(SHEET, [rectangle(0.0, 0.0, 3.0, 4.0)])
    fill = fill_region(tiny, Hatch(angle_deg=0.0), **ARGS)
    assert not fill.beads
    assert "left bare" in str(fill.notes[0])


@given(st.floats(2.45 * D, 40.0))
@settings(max_examples=30, deadline=None)
def test_a_wide_piece_gets_two_beads_at_least(width):
    region = region_from_loops(SHEET, [rectangle(0.0, 0.0, 30.0, width)])
    assert len(fill_region(region, Hatch(angle_deg=0.0), **ARGS).beads) >= 2


def test_short_beads_are_counted():
    region = region_from_loops(SHEET, [rectangle(0.0, 0.0, 6.0, 30.0)])
    fill = fill_region(region, Hatch(angle_deg=0.0), **ARGS, shortest_bead=2.0)
    assert [b.kind.value for b in fill.beads] == ["skeleton"]
    assert "beads shorter than 2 mm left out" in str(fill.notes[0])


PATTERNS = {
    "hatch": (Hatch(angle_deg=math.degrees(0.7)), 0.2),
    "zigzag": (Zigzag(), 0.2),
    "contours": (Contours(skeleton=False), 0.06),
    "contours and hatch": (
        PatternSequence(patterns=(Contours(count=1, skeleton=False), Hatch(angle_deg=math.degrees(0.7))), overlap=2 * D - W),
        0.02,
    ),
    "contours and skeleton": (PatternSequence(patterns=(Contours(skeleton=False), Skeleton())), 0.02),
    "spiral": (Spiral(skeleton=False), 0.02),
    "rings": (Rings(), 0.2),
}


@pytest.mark.parametrize("name", PATTERNS)
@pytest.mark.parametrize("shape", [{"lean": 50.0}, {"lean": 150.0, "wide": 70.0, "count": 1}], ids=["four", "more than a turn"])
def test_a_band_under_leaning_blades(name, shape):
    pattern, most_bare = PATTERNS[name]
    found = []
    for turned, first in ((0.0, 0), (17.3, 2), (-200.0, 5)):
        region = leaning(turned, first, **shape)
        made = fill_region(region, pattern, **ARGS)
        covered = coverage_of(region, made.beads, W)
        assert covered.area == pytest.approx(region.area, rel=1e-9)
        # in a sharp corner a bead along the skeleton is wider than the corner
        assert covered.outside < (0.025 * region.area if name == "contours and skeleton" else 1e-3)
        assert covered.bare_share < most_bare
        outline = Outline(region.pieces[:1], 0.5 * W)
        for bead in made.beads:
            if name != "contours and skeleton":
                assert outline.distances(along(bead.points))[0].min() > 0.5 * W - 1e-9
        found.append((len(made.beads), sum(bead.length() for bead in made.beads), covered.bare_share))
    assert [n for n, *_ in found] == [found[0][0]] * 3
    for other in found[1:]:
        assert other[1:] == pytest.approx(found[0][1:], rel=1e-3)


def test_a_contour_under_leaning_blades_is_one_line_all_the_way_round():
    (lower, upper) = fill_region(leaning(11.0, 1), Contours(count=1, skeleton=False), **ARGS).beads
    assert lower.length() == pytest.approx(TURN, rel=1e-12)
    # four times: up one flank and down the other, two ends; round the outer corners, cut short in the inner ones
    outline = 4.0 * (2.0 * math.hypot(50.0, 25.0) + TURN / 4)
    lean = math.atan2(25.0, 50.0)

    def at(inset: float) -> float:
        shorter = 2.0 * inset * (1.0 / math.tan(lean / 2) + 1.0 / math.tan((math.pi - lean) / 2))
        return outline + 4.0 * (math.pi * inset - shorter)

    # it errs inwards by the chord and that of the round corners
    assert at(0.5 * W + 2.0 * ARGS["chord"]) < upper.length() < at(0.5 * W)
    assert upper.points[-1] - upper.points[0] == pytest.approx([-TURN, 0.0], abs=1e-9)


@pytest.mark.parametrize("name", ["drilled_tube", "oblique_tube", "keyed_band", "wind_blade", "helical_gear_tooth"])
def test_distances_from_exact_outlines_are_those_from_fine_samples(name, fixture_step):
    part = bs.read_step(fixture_step(name))
    (solid,) = cut_solids(part, bs.axis_from_text("Z"))
    low, high = solid.critical.lowest, solid.critical.highest
    for layer in bs.slice_part(part, [low + share * (high - low) for share in (0.3, 0.7)], axis="Z"):
        for piece in layer.region.pieces:
            k0, v0, k1, v1 = piece.bounds()
            points = np.random.default_rng(3).uniform([k0 - 2.0, v0 - 2.0], [k1 + 2.0, v1 + 2.0], (4000, 2))
            fine = 1e-6
            copies = [loop.moved(k).sample(fine) for loop in piece.loops for k in ((-2, -1, 0, 1, 2) if piece.winds else (0,))]
            truth = shapely.MultiLineString([shapely.LineString(points) for points in copies])
            shapely.prepare(truth)
            found, away = Outline([piece], 1.5).distances(points)
            wanted = shapely.distance(truth, shapely.points(points))
            # where a curve bends round a point its feet are found slowly: well beyond an inset that does not matter
            assert np.abs(found - wanted)[wanted < 3.0].max() < 2.0 * fine
            assert np.abs(found - wanted).max() < 1e-3
            assert np.hypot(*away.T) == pytest.approx(1.0, abs=1e-9)


def test_ends_do_not_slide_across_the_outline():
    outline = Outline(leaning().pieces[:1], 1.5)
    start, way = np.array([[26.0, 17.9]]), np.array([[math.sin(0.02), math.cos(0.02)]])
    for limit in (1.0, 3.0, 30.0):
        (end,) = ends_at_inset(outline, start, way, inset=1.5, limit=limit)
        assert end[1] < 20.0
        assert outline.distances(end[None])[0][0] == pytest.approx(1.5, abs=1e-9)


def collar(radius: float, height: float, *holes: Loop) -> Region:
    turn = 2.0 * math.pi * radius
    lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(turn, 0.0)),), sheet=cylinder(radius), winding=1)
    upper = Loop(curves=(LineCurve(p0=(turn, height), p1=(0.0, height)),), sheet=cylinder(radius), winding=-1)
    return region_from_loops(cylinder(radius), [lower, upper, *holes])


def polygon(points, radius: float = R) -> Loop:
    lines = [LineCurve(p0=p, p1=q) for p, q in itertools.pairwise([*points, points[0]])]
    return Loop(curves=tuple(lines), sheet=cylinder(radius))


@pytest.mark.parametrize("step_over", [0.8, 1.0, 2.0, 3.4])
def test_upright_lines_are_all_there_round_a_collar(step_over):
    # a line through the anchor lies on the side of the window that is drawn: rounding dropped it there on both sides
    for radius in np.arange(10.0, 60.0, 1.5):
        made = fill_region(
            collar(radius, 20.0), Hatch(angle_deg=90.0), step_over=step_over, width=step_over, inset=0.5, chord=0.01
        )
        assert len(made.beads) == round(2.0 * math.pi * radius / made.step_over[0])


def test_angles_next_to_none_are_rings():
    made = fill_region(collar(R, 20.0), Hatch(angle_deg=math.degrees(1e-4)), **ARGS)
    assert made.angle == (0.0,)
    assert all(bead.closed for bead in made.beads)


@pytest.mark.parametrize("half", [2.0, 5.0])
def test_skeletons_reach_sharp_corners(half):
    region = region_from_loops(SHEET, [polygon([(-20.0, 0.0), (0.0, -half), (20.0, 0.0), (0.0, half)])])
    made = fill_region(region, PatternSequence(patterns=(Contours(skeleton=False), Skeleton())), **ARGS)
    assert coverage_of(region, made.beads, W).bare_share < 0.005
    ends = np.concatenate([bead.points for bead in made.beads])[:, 0]
    # the bead's round end is what reaches the corner
    assert (ends.min(), ends.max()) == pytest.approx((0.5 * W - 20.0, 20.0 - 0.5 * W), abs=0.01)


def test_edges_of_a_band_that_a_hole_breaks():
    angles = np.linspace(0.0, 2.0 * math.pi, 60, endpoint=False)
    hole = polygon([(40.0 + 2.5 * math.cos(a), 4.5 + 2.5 * math.sin(a)) for a in -angles])
    region = collar(R, 9.0, hole)
    made = fill_region(region, Spiral(skeleton=False), **ARGS)
    assert coverage_of(region, made.beads, W).bare_share < 0.05
    assert coverage_of(region, (), W).bare_share == 1.0


def test_flanks_of_a_hexagon_wherever_it_lies():
    for turned in np.linspace(0.0, 1.0, 7):
        corners = [(12.0 * math.cos(a), 12.0 * math.sin(a)) for a in turned + np.arange(6) * math.pi / 3]
        assert fill_region(region_from_loops(SHEET, [polygon(corners)]), FlankFollowing(), **ARGS).beads


def test_ends_slid_towards_each_other_meet_and_do_not_pass():
    # an hourglass whose neck is an inset wide: its polygon is cut in two there, by its slack
    neck = 0.5 * W + 0.005
    corners = [(-20.0, -8.0), (0.0, -neck), (20.0, -8.0), (20.0, 8.0), (0.0, neck), (-20.0, 8.0)]
    beads = fill_region(region_from_loops(SHEET, [polygon(corners)]), Hatch(), **ARGS).beads
    through = [np.sort(bead.points[:, 0]) for bead in beads if abs(bead.points[0, 1]) < 0.1]
    assert sum(high - low for low, high in through) == pytest.approx(40.0 - W, abs=1e-9)
    # a helix between a hole and the edge, two beads of which lay over each other
    radius = 40.0
    hole = polygon([(60.0 + 0.9 * math.cos(a), 4.1 + 0.9 * math.sin(a)) for a in -np.arange(40) * math.pi / 20], radius)
    region = collar(radius, 8.9, hole)
    made = fill_region(region, Helix(), step_over=2.0, width=2.88, inset=1.44, chord=0.01)
    lines = shapely.MultiLineString([bead.points for bead in made.beads])
    copies = [shapely.affinity.translate(line, k * 2.0 * math.pi * radius) for line in lines.geoms for k in range(-8, 9)]
    for i, line in enumerate(lines.geoms):
        mine = i * 17 + 8
        others = shapely.MultiLineString([other for j, other in enumerate(copies) if j != mine])
        assert line.intersection(others.buffer(1e-6)).length < 1e-3


@pytest.mark.parametrize("pattern", [Rings(), Contours(count=1, skeleton=False)])
def test_starts_are_spread_on_beads_that_go_round_too(pattern):
    beads = [bead for bead in fill_region(leaning(4.0, 1), pattern, **ARGS).beads if bead.closed]
    assert beads
    for bead, spread in zip(beads, with_spread_starts(beads, 1), strict=True):
        turns = bead.points[-1] - bead.points[0]
        assert spread.points[-1] - spread.points[0] == pytest.approx(turns, abs=1e-9)
        assert spread.length() == pytest.approx(bead.length(), rel=1e-12)
        assert np.hypot(*(spread.points[0] - bead.points[0])) > 1.0
        line = shapely.MultiLineString([bead.points + k * np.array([TURN, 0.0]) for k in range(-2, 3)])
        assert shapely.distance(line, shapely.points(along(spread.points))).max() < 1e-9


@pytest.mark.parametrize(
    "chosen",
    [Skeleton(), Hatch(angle_deg=math.degrees(0.3)), Zigzag(angle_deg=0.0), Spiral(skeleton=False), FlankFollowing()],
    ids=lambda p: type(p).__name__,
)
@pytest.mark.parametrize(("at", "jog"), [(10.0, 0.1), (9.5, 0.02), (5.0, 0.03), (2.7, 0.006), (3.2, 0.03)])
def test_an_edge_gap_at_which_the_outline_crosses_itself_is_no_obstacle(at, jog, chosen):
    crossing = [(at, 30.0), (at + jog, 30.0 + jog), (at + 0.6 * jog, 30.0 - jog)]
    region = region_from_loops(SHEET, [polygon([(0.0, 0.0), (14.5, 0.0), (14.5, 30.0), *crossing, (0.0, 30.0)])])
    plain = region_from_loops(SHEET, [rectangle(0.0, 0.0, 14.5, 30.0)])
    metal = [
        sum(
            bead.length()
            for bead in fill_region(r, PatternSequence(patterns=(Contours(count=1, skeleton=False), chosen)), **ARGS).beads
        )
        for r in (region, plain)
    ]
    assert metal[0] == pytest.approx(metal[1], rel=0.05)
