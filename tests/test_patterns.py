"""Patterns beyond hatch and contours: zigzag, rings, helices, flank-following."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop
from brep_slicer.fill import Contours, FlankFollowing, Hatch, Helix, PatternSequence, Rings, Zigzag, fill_region, in_cool_order
from brep_slicer.fill.tools.distance import Outline
from brep_slicer.layers import cylinder
from brep_slicer.process import PATTERNS as NAMED
from brep_slicer.proof import summary_of_proof
from brep_slicer.region import region_from_loops

from .test_fill import ARGS, REGIONS, TURN, D, R, W, along, band, box, rectangle

Z = bs.axis_from_text("Z")
PATTERNS = {
    "hatch": Hatch(angle_deg=math.degrees(0.4)),
    "zigzag": Zigzag(angle_deg=math.degrees(0.4)),
    "rings": Rings(),
    "helix": Helix(),
    "three left-handed helices": Helix(starts=3, left_handed=True),
    "flank": FlankFollowing(),
    "contours and zigzag": PatternSequence(patterns=(Contours(count=1, skeleton=False), Zigzag(angle_deg=math.degrees(1.0)))),
}


def plain_band(height=40.0):
    lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(TURN, 0.0)),), sheet=cylinder(R), winding=1)
    upper = Loop(curves=(LineCurve(p0=(TURN, height), p1=(0.0, height)),), sheet=cylinder(R), winding=-1)
    return region_from_loops(cylinder(R), [lower, upper])


@pytest.mark.parametrize("pattern", PATTERNS.values(), ids=PATTERNS)
@pytest.mark.parametrize("make", REGIONS.values(), ids=REGIONS)
def test_every_bead_keeps_its_inset_and_no_piece_is_lost(pattern, make):
    region = make()
    fill = fill_region(region, pattern, **ARGS)
    outline = Outline(region.pieces[:1], 0.5 * W)
    gaps, _ = outline.distances(np.concatenate([along(b.points) for b in fill.beads]))
    assert gaps.min() >= 0.5 * W - 1e-6
    assert {b.piece for b in fill.beads} == set(range(len(region.pieces)))


def test_a_zigzag_is_one_bead_in_a_convex_piece():
    hatch, zigzag = (fill_region(box(), p, **ARGS) for p in (Hatch(angle_deg=0.0), Zigzag(angle_deg=0.0)))
    assert len(zigzag.beads) == 1
    lines = sum(b.length() for b in hatch.beads)
    assert zigzag.beads[0].length() == pytest.approx(lines + (len(hatch.beads) - 1) * D, rel=1e-9)


@given(st.floats(10.0, 60.0))
@settings(max_examples=20, deadline=None)
def test_a_helix_is_one_bead_and_covers_what_rings_do(height):
    region = plain_band(height)
    helix = fill_region(region, Helix(), **ARGS)
    assert len(helix.beads) == 1
    (bead,) = helix.beads
    rise = height - W
    # one start: it climbs d in a turn of the cylinder
    assert bead.length() == pytest.approx(rise / D * TURN, rel=1e-9)
    slope = (bead.points[-1, 1] - bead.points[0, 1]) / (bead.points[-1, 0] - bead.points[0, 0])
    assert math.sin(math.atan(slope)) == pytest.approx(D / TURN, rel=1e-12)


def test_lengths_against_n_rings():
    # N rings in the same inset: a helix has (N - 1) ring lengths, with closing rings (N + 1)
    n = 9
    region = plain_band(W + (n - 1) * D)
    rings, helix, closed = (fill_region(region, p, **ARGS) for p in (Rings(), Helix(), Helix(closing_rings=True)))
    assert len(rings.beads) in (n - 1, n)
    turns = sum(b.length() for b in helix.beads) / TURN
    assert turns == pytest.approx(n - 1, rel=1e-5)
    assert sum(b.length() for b in closed.beads) / TURN == pytest.approx(turns + 2.0, rel=1e-9)


def test_a_keyway_interrupts_a_helix_and_nothing_else_does():
    fill = fill_region(band(), Helix(), **ARGS)
    # every end but the first and the last lies at the keyway
    ends = np.concatenate([b.points[[0, -1]] for b in fill.beads])
    outline = Outline(band().pieces[:1], 0.5 * W)
    gaps, _ = outline.distances(ends)
    assert np.abs(gaps - 0.5 * W).max() < 1e-6
    v = np.sort(ends[:, 1])
    assert ((v[1:-1] > 10.0 - W) & (v[1:-1] < 30.0 + W)).all()


@given(st.floats(-7.0, 7.0), st.integers(1, 3), st.booleans())
@settings(max_examples=20, deadline=None)
def test_a_helix_begins_where_it_is_told(theta, starts, left_handed):
    region = plain_band(40.0)
    fill = fill_region(region, Helix(starts=starts, left_handed=left_handed, start_angle_deg=math.degrees(theta)), **ARGS)
    assert len(fill.beads) == starts
    ends = np.array([b.points[[0, -1]] for b in fill.beads]).reshape(-1, 2)
    low = ends[ends[:, 1] < ends[:, 1].min() + 1e-6]
    assert len(low) == starts
    assert low[:, 1] == pytest.approx(0.5 * W, abs=1e-9)
    off = np.remainder(low[:, 0] - theta * region.radius + 0.5 * TURN, TURN) - 0.5 * TURN
    assert np.abs(off).min() < 1e-6
    # the others begin an even share of a turn on
    assert np.sort(np.remainder(off * starts + 0.5 * TURN, TURN) - 0.5 * TURN) == pytest.approx(np.zeros(starts), abs=1e-5)


def test_a_helix_on_a_piece_that_does_not_wind_is_said():
    fill = fill_region(box(), Helix(), **ARGS)
    assert "does not go all the way round" in str(fill.notes[0])


def test_flank_following_on_the_helical_tooth(fixture_step):
    # dkappa/dv = 2 pi r / p_z at each layer
    gears = pytest.importorskip("fixtures.gears")
    part = bs.read_step(fixture_step("helical_gear_tooth"))
    process = bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(pattern="flank"))
    plan = bs.plan(part, process)
    for layer, fill in zip(plan.layers, plan.fills, strict=True):
        expected = math.atan2(1.0, 2.0 * math.pi * layer.radius / gears.HELICAL_TOOTH.lead)
        for bead in fill.beads:
            step = bead.points[-1] - bead.points[0]
            assert math.remainder(math.atan2(step[1], step[0]) - expected, math.pi) == pytest.approx(0.0, abs=1e-9)


def test_patterns_from_the_command(fixture_step, tmp_path):
    from typer.testing import CliRunner

    from brep_slicer.cli import app

    words = ["plan", str(fixture_step("keyed_band")), "-t", "2", "-d", "3", "--layers", "0:1", "-o", str(tmp_path)]
    for pattern in NAMED.own():
        done = CliRunner().invoke(app, [*words, "--pattern", pattern, "--outline-position", "on", "--order", "shortest"])
        assert done.exit_code == 0, done.output


def test_proof_from_the_command(fixture_step, tmp_path):
    import json

    from typer.testing import CliRunner

    from brep_slicer.cli import app

    words = ["plan", str(fixture_step("helical_gear_tooth")), "-t", "1.4", "-d", "3.4", "--layers", "0:2", "-o", str(tmp_path)]
    done = CliRunner().invoke(app, [*words, "--pattern", "flank", "--outline-position", "on", "--adaptive-speed", "--proof"])
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "report.json").read_text())
    assert len(report["proof"]) == 2
    (said,) = (line for line in done.output.splitlines() if line.startswith("proof: "))
    measured = [row["step_over_measured_mm"] for row in report["proof"]]
    places = sum(m["spacings"] for m in measured)
    assert all(m["as_planned"] == m["spacings"] for m in measured)
    worst = max(row["bare_share"] for row in report["proof"])
    assert said.startswith("proof: even; ")
    assert f"beads 3.4 mm apart as planned (within 0.001 mm): flank-flank at all {places} places; " in said
    assert f"at most {100 * worst:.3g} % left bare" in said
    assert report["proof"][0]["bare_share"] < 0.005
    assert (tmp_path / "proof.png").stat().st_size > 10_000


def test_the_proof_tells_the_spacings_of_a_hatch_from_those_at_its_contour(fixture_step, tmp_path):
    process = bs.Process(
        layer_thickness=1.4, step_over=3.4, fill=bs.Fill(contours=1, pattern=bs.Hatch(angle_deg=math.degrees(0.5)))
    )
    plan = bs.plan(bs.read_step(fixture_step("helical_gear_tooth")), process, layers=(0, 1))
    (row,) = plan.proof()
    measured = row["step_over_measured_mm"]
    assert 0 < measured["as_planned"] < measured["spacings"]
    assert measured["others_lowest"] == measured["lowest"] < 3.399
    said = summary_of_proof([row])
    pairs = measured["by_neighbours"]
    # lines of the hatch are a step-over apart wherever they are neighbours; a contour crosses their ends at an angle
    hatch, ends = pairs["hatch-hatch"], pairs["contour-hatch"]
    assert hatch["as_planned"] == hatch["spacings"] > 100
    assert hatch["others_lowest"] is None
    assert ends["as_planned"] < ends["spacings"]
    for key in ("spacings", "as_planned"):
        assert sum(pair[key] for pair in pairs.values()) == measured[key]
    assert min(p["others_lowest"] for p in pairs.values() if p["others_lowest"]) == measured["others_lowest"]
    assert f"(within 0.001 mm): hatch-hatch at all {hatch['spacings']} places" in said.replace("contour-contour", "")
    off = ends["spacings"] - ends["as_planned"]
    span = f"{ends['others_lowest']:.3f} to {ends['others_highest']:.3f} mm"
    assert f"contour-hatch {span} at {off} of {ends['spacings']} places, where they meet on purpose" in said


def row_of(pairs, *, bare=0.001, height=1.0, layer=0, peak=1.5):
    """A row of a proof with these neighbours: (places, as planned) by pair."""
    known = {
        pair: {
            "spacings": n,
            "as_planned": k,
            "others_lowest": 1.0 if k < n else None,
            "others_highest": 2.0 if k < n else None,
        }
        for pair, (n, k) in pairs.items()
    }
    measured = {"spacings": sum(n for n, _ in pairs.values()), "planned": [3.4], "by_neighbours": known}
    heights = {"mean_height_over_t": height, "peak_height_over_t": peak}
    place = {"piece": 4, "kappa_mm": 12.5, "v_mm": -3.0}
    return {"layer": layer, "bare_share": bare, **heights, "peak_at": place, "step_over_measured_mm": measured}


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (row_of({"hatch-hatch": (100, 100), "contour-hatch": (50, 0)}), "even; "),
        (row_of({"hatch-hatch": (1000, 995)}), "even; "),
        (row_of({"hatch-hatch": (100, 98)}), "uneven: hatch-hatch not spaced as planned; "),
        (row_of({"ring-ring": (9, 9)}, bare=0.05, layer=7), "uneven: 1 layer with more than 2% bare, most on layer 7; "),
        (
            row_of({"ring-ring": (9, 9)}, height=1.1, layer=3),
            "uneven: 1 layer whose mean height is off t by more than 2%, most ",
        ),
        (row_of({"ring-ring": (9, 9)}, height=0.97), "uneven: 1 layer whose mean height"),
        (
            row_of({"ring-ring": (9, 9)}, peak=2.13, layer=3),
            "uneven: highest 2.13 t (layer 3, piece 4, at kappa 12.5, v -3 mm); beads",
        ),
        (row_of({}), "even; no two beads beside each other"),
    ],
)
def test_the_proof_begins_with_its_verdict(row, verdict):
    assert summary_of_proof([row]).startswith(verdict)


def test_each_tooth_is_built_whole_before_the_next(fixture_step):
    part = bs.read_step(fixture_step("propeller"))
    process = bs.Process(layer_thickness=8.0, step_over=3.4, fill=bs.Fill(by_feature=True))
    plan = bs.plan(part, process)
    layer_by_layer = bs.plan(part, process.updated(fill={"by_feature": False}))
    # three blades: the layers rise three times
    path = plan.toolpath
    assert (np.diff(path.layer) < 0).sum() == 2
    assert path.segment_lengths()[path.deposits].sum() == pytest.approx(
        layer_by_layer.toolpath.segment_lengths()[layer_by_layer.toolpath.deposits].sum(), rel=1e-9
    )
    # a travel to the next blade clears the blade that stands: nothing moves lower than what was built before
    top = 0.0
    rho = np.hypot(*plan.axis.axis_from_file(path.points)[:, :2].T)
    for i in np.flatnonzero(np.diff(path.layer) < 0) + 1:
        top = max(top, float(path.radius[:i][path.deposits[:i]].max()))
        assert rho[i : i + 2].max() > top


def test_a_stretched_hatch_fills_the_width():
    loose, exact = (fill_region(box(), Hatch(angle_deg=90.0, stretch=s), **ARGS) for s in (0.0, 0.2))
    free = 25.0 - W
    for fill, outermost in ((loose, free - math.floor(free / D) * D), (exact, 0.0)):
        kappa = np.sort([b.points[0, 0] for b in fill.beads])
        assert kappa[0] + 10.0 - 0.5 * W == pytest.approx(0.5 * outermost, abs=0.02)
    assert exact.step_over[0] == pytest.approx(free / round(free / D), rel=2e-3)
    assert fill_region(box(), Hatch(angle_deg=90.0, stretch=0.001), **ARGS).step_over == (D,)


def test_alternate_layers_run_backwards_and_contours_come_every_so_many(fixture_step):
    process = bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(alternate=True, contours=1, contours_every=3))
    plan = bs.plan(bs.read_step(fixture_step("spur_gear_tooth")), process, layers=(0, 6))
    kinds = [{b.kind.value for b in fill.beads} for fill in plan.fills]
    assert ["contour" in k for k in kinds] == [True, False, False, True, False, False]
    first, second = plan.fills[1].beads[0].points[0], plan.fills[2].beads[0].points[0]
    assert first[1] > 30.0 > second[1] or first[1] < 30.0 < second[1]


def test_closed_beads_start_elsewhere_and_overlap_themselves(fixture_step):
    process = bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(contours=1, spread_starts=True, closing_overlap=4.0))
    part = bs.read_step(fixture_step("spur_gear_tooth"))
    plain, made = (
        bs.plan(part, p, layers=(0, 4))
        for p in (process.updated(fill={"spread_starts": False, "closing_overlap": 0.0}), process)
    )
    starts = []
    for before, after in zip(plain.fills, made.fills, strict=True):
        assert after.beads[0].length() == pytest.approx(before.beads[0].length() + 4.0, rel=1e-6)
        starts.append(after.beads[0].points[0] - before.beads[0].points[0])
    assert len(np.unique(np.round(starts, 1), axis=0)) == 4


def test_no_bead_is_laid_beside_a_hot_one():
    beads = fill_region(rows(12), Hatch(angle_deg=90.0, both_ways=False), **ARGS).beads
    plain = in_cool_order(beads, step_over=D, rest=0.0, speed=9.0, travel_speed=50.0)
    cool = in_cool_order(beads, step_over=D, rest=8.0, speed=9.0, travel_speed=50.0)
    assert plain.shortest_rest < 1.0
    assert cool.too_soon == 0
    assert cool.shortest_rest >= 8.0
    assert {id(b) for b in cool.beads} == {id(b) for b in beads}
    # a rest that no order can give is said
    assert in_cool_order(beads, step_over=D, rest=1e4, speed=9.0, travel_speed=50.0).too_soon > 0


def rows(count):
    return region_from_loops(cylinder(R), [rectangle(0.0, 0.0, W + (count - 1) * D + 0.1, 30.0)])


def test_a_pattern_for_each_layer_and_piece(fixture_step):
    part = bs.read_step(fixture_step("propeller"))
    process = bs.Process(layer_thickness=8.0, step_over=3.4)
    asked = []

    def choose(layer, piece):
        asked.append((layer, round(piece.bounds()[0], 3)))
        return Zigzag() if piece.bounds()[0] > 0.0 else Contours(count=1, skeleton=False)

    plan = bs.plan(part, process, pattern=choose, layers=(1, 3))
    assert len(asked) == 6
    assert {b.kind.value for fill in plan.fills for b in fill.beads} == {"zigzag", "contour"}


def test_rings_are_stretched_to_fill_a_band():
    height = W + 7.3 * D
    fill = fill_region(plain_band(height), Hatch(angle_deg=0.0, stretch=0.2), **ARGS)
    heights = np.sort([b.points[0, 1] for b in fill.beads])
    # seven spacings of 7.3 / 7 d, from half a bead above the lower edge to half a bead below the upper one
    assert np.diff(heights) == pytest.approx(np.full(7, 7.3 / 7.0 * D), rel=1e-3)
    assert heights[0] == pytest.approx(0.5 * W, abs=0.05)
    assert heights[-1] == pytest.approx(height - 0.5 * W, abs=0.05)
