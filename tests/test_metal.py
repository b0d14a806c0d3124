"""Each piece gets its metal: closed forms, the default plans, narrow lobes, contours, random plans."""

from __future__ import annotations

import math

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.fill import BeadKind, Contours, Hatch, Skeleton, fill_layer, metal_of
from brep_slicer.fill.tools.strips import strip_areas
from brep_slicer.layers import cylinder
from brep_slicer.notices import NoticeKind
from brep_slicer.process import PATTERNS
from brep_slicer.proof import coverage_of, deposit_of, evenness_of
from brep_slicer.proof.equals import shares_of
from fixtures import bodies

from .figures.plans import metal_by_piece, random_plan
from .test_fill import D, R, W, rectangle
from .test_proof import polygon

T = 1.4
PROCESS = bs.Process(layer_thickness=T, step_over=D, fill=bs.Fill(bead_width=W))


def layer_of(region):
    (layer,) = bs.slice_part(bodies.tube(), [40.0], axis="Z")
    from dataclasses import replace

    return replace(layer, region=region, area=region.area, thickness=T)


def test_the_metal_of_a_bead_in_closed_form():
    from brep_slicer.fill import Bead

    points, ends = np.array([[0.0, 0.0], [30.0, 0.0]]), 2.0 * 3.0 * math.pi / 32.0 * W
    plain = Bead(points=points, kind=BeadKind.HATCH)
    slow = Bead(points=points, kind=BeadKind.HATCH, speed=np.array([0.5, 0.5]))
    ring = Bead(points=points, kind=BeadKind.RING, closed=True)
    expected = [D * (30.0 + ends), 2.0 * D * (30.0 + ends), D * 30.0]
    assert metal_of([plain, slow, ring], step_over=D, width=W) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("angle", [0.0, 0.4, 0.5 * math.pi])
def test_strips_of_a_disc_in_closed_form(angle):
    import shapely

    disc = shapely.Point(0.0, 0.0).buffer(10.0, quad_segs=2000)
    # a segment of height from y up: r**2 acos(y / r) - y sqrt(r**2 - y**2)
    above = [100.0 * math.acos(y / 10.0) - y * math.sqrt(100.0 - y * y) for y in (-10.0, -5.5, 1.0, 5.5, 10.0)]
    found = strip_areas(disc, angle, np.array([-8.0, -3.0, 5.0, 6.0]))
    assert found == pytest.approx(-np.diff(above), rel=1e-5)


@pytest.mark.parametrize("angle_deg", [0.0, 31.0, 90.0])
@pytest.mark.parametrize("size", [(1.9, 40.0), (8.0, 40.0), (15.0, 15.0), (23.0, 61.0)])
def test_a_rectangle_gets_its_metal_by_default(size, angle_deg):
    region = polygon((0, 0), (size[0], 0), size, (0, size[1]))
    fill = fill_layer(layer_of(region), PROCESS.updated(fill={"pattern": bs.Automatic(angle_deg=angle_deg)}))
    # what lies inside counts; of a section half a width u W from its middle (3 u - u**3) / 2 does
    u = min(1.0, size[0] / W)
    within, whole = metal_inside(region, fill.beads), metal_of(fill.beads, step_over=D, width=W).sum()
    assert within == pytest.approx(region.area, rel=0.02)
    assert within / whole == pytest.approx(0.5 * (3.0 * u - u**3), abs=0.03)
    assert fill.metal == pytest.approx((1.0,), abs=0.02)
    assert fill.beyond == pytest.approx(((whole - within) / region.area,), abs=0.02)
    # told of where the bead does not fit, and where the corners that round beads do not reach are more than 2 % of it
    corners = (4.0 - math.pi) * (0.5 * W) ** 2 / region.area
    kinds = [NoticeKind.PIECE_METAL] * (u < 1.0) + [NoticeKind.BARE] * (u == 1.0 and corners > 0.02)
    assert [n.kind for n in fill.notes] == kinds
    made = deposit_of(region, fill.beads, width=W, thickness=T, step_over=D)
    assert made.mean == pytest.approx(T, rel=0.02)


def metal_inside(region, beads):
    """The metal within a region of flat pieces, mm2, from the simulation on a grid."""
    made = deposit_of(region, beads, width=W, thickness=T, step_over=D)
    return made.mean / T * region.area


@pytest.mark.parametrize("wide", [0.6, 1.0, 2.5, 3.3])
def test_a_strip_narrower_than_a_bead_gets_its_height_and_what_lies_beyond_is_told_of(wide):
    fill = fill_layer(layer_of(polygon((0, 0), (wide, 0), (wide, 40.0), (0, 40.0))), PROCESS)
    assert fill.metal[0] == pytest.approx(1.0, abs=0.01)
    # of a bead's section (3 u - u**3) / 2 lies within half a strip u W wide
    u = wide / W
    assert fill.beyond[0] == pytest.approx(2.0 / (3.0 * u - u**3) - 1.0, rel=0.1)
    (said,) = [n for n in fill.notes if n.kind is NoticeKind.PIECE_METAL]
    assert said.pieces == (0,)
    assert "times its metal beyond its outline" in str(said)


def test_a_strip_hardly_narrower_than_a_bead_is_not_told_of():
    fill = fill_layer(layer_of(polygon((0, 0), (4.0, 0), (4.0, 40.0), (0, 40.0))), PROCESS)
    assert fill.metal[0] == pytest.approx(1.0, abs=0.01)
    u = 4.0 / W
    assert fill.beyond[0] == pytest.approx(2.0 / (3.0 * u - u**3) - 1.0, abs=0.02)
    assert not fill.notes


def test_what_beads_cannot_hold_at_their_fastest_is_told_of():
    fill = fill_layer(
        layer_of(polygon((0, 0), (8.0, 0), (8.0, 8.0), (0, 8.0))),
        PROCESS.updated(fill={"fastest": 1.0, "outline_position": "on"}),
    )
    (said,) = [n for n in fill.notes if n.kind is NoticeKind.PIECE_METAL]
    assert fill.metal[0] > 1.02
    assert "fastest" in str(said)


@pytest.mark.parametrize("fit", ["in", "on", "out"])
@pytest.mark.parametrize("pattern", ["hatch", "contours", "spiral", "zigzag"])
@pytest.mark.parametrize("shape", ["square", "wedge", "holed"])
def test_the_bookkeeping_is_that_of_the_simulation(shape, pattern, fit):
    from brep_slicer.region import region_from_loops

    regions = {
        "square": lambda: polygon((0, 0), (30, 0), (30, 30), (0, 30)),
        "wedge": lambda: polygon((0, 0), (40, 0), (25, 45), (18, 45)),
        "holed": lambda: region_from_loops(
            cylinder(R), [rectangle(-20.0, 0.0, 20.0, 40.0), rectangle(-5.0, 12.0, 6.0, 25.0, hole=True)]
        ),
    }
    region = regions[shape]()
    turned = {"angle_deg": 20.0} if pattern in ("hatch", "zigzag") else {}
    changes = {"pattern": {"name": pattern, **turned}, "outline_position": fit, "balance": False}
    fill = fill_layer(layer_of(region), PROCESS.updated(fill=changes))
    assert fill.metal[0] == pytest.approx(metal_inside(region, fill.beads) / region.area, abs=0.01)


DEFAULTS = {
    "spur tooth": (lambda read: read("spur_gear_tooth"), None, 4.0, 3.4),
    "helical tooth": (lambda read: read("helical_gear_tooth"), None, 4.0, 3.4),
    "cam": (lambda read: read("cam"), 40.0, 2.0, 2.0),
    "propeller": (lambda read: read("propeller"), None, 8.0, 3.4),
    "wind blade": (lambda read: read("wind_blade"), 40.0, 8.0, 1.5),
    "blisk": (lambda read: bodies.blisk(), 40.0, 4.0, 3.4),
    "thin blisk": (lambda read: bodies.blisk(thickness=2.0), 40.0, 4.0, 3.4),
    "bands": (lambda read: bodies.banded_shaft(), 30.0, 2.0, 3.4),
    "keyed band": (lambda read: read("keyed_band"), 45.0, 4.0, 3.0),
}


@pytest.mark.parametrize("name", DEFAULTS)
def test_by_default_every_piece_gets_its_metal(name, fixture_step):
    part, substrate, t, d = DEFAULTS[name]
    made = bs.plan(
        part(lambda n: bs.read_step(fixture_step(n))),
        bs.Process(layer_thickness=t, step_over=d),
        axis="Z",
        substrate=substrate,
    )
    found = metal_by_piece(made)
    assert found
    assert max(abs(f.share - 1.0) for f in found) <= 0.02
    # nothing to warn of but pieces so narrow that a bead does not fit: the thin blades and the propeller's very tip
    said = [n for n in made.notices if n.kind in (NoticeKind.PIECE_METAL, NoticeKind.NARROW, NoticeKind.BARE)]
    assert all("beyond its outline" in n.text for n in said)
    named = {(layer, piece) for n in said for layer in n.layers for piece in n.pieces}
    narrow = {(f.layer, f.piece) for f in found if f.beyond > 0.11}
    assert narrow <= named <= {(f.layer, f.piece) for f in found if f.beyond > 0.09}
    assert (len(narrow) > 0) == (name in ("thin blisk", "propeller"))
    # the simulation says so, too
    for layer, fill in list(zip(made.layers, made.fills, strict=True))[:: max(1, len(made.layers) // 4)]:
        if fill.beads:
            shares = shares_of(layer.region, fill, width=made.process.width)
            sizes = {"width": made.process.width, "thickness": t, "step_over": d, "tolerance": 0.02}
            even = evenness_of(layer.region, fill.beads, shares=shares, **sizes)
            assert even.mean == pytest.approx(t, rel=0.02)
            assert even.peak < 2.0 * t
    # what was chosen, and why, is in the report
    rows = made.report()["layers"]
    assert all("is wider than" in words for row in rows for words in row["patterns"])


@pytest.mark.parametrize(("wide", "long"), [(10.8, 20.0), (6.0, 20.0), (12.0, 12.0), (15.0, 15.5)])
def test_corners_that_round_beads_do_not_reach_are_told_of_where_they_count(wide, long):
    region = polygon((0, 0), (wide, 0), (wide, long), (0, long))
    # of each corner (1 - pi / 4) (W / 2)**2
    share = (4.0 - math.pi) * (0.5 * W) ** 2 / (wide * long)
    fill = fill_layer(layer_of(region), PROCESS)
    said = [n for n in fill.notes if n.kind is NoticeKind.BARE]
    assert len(said) == (share > 0.02)
    bare = coverage_of(region, fill.beads, W).bare_share
    if said:
        assert said[0].figures["share"][0] == pytest.approx(share, rel=0.1)
        assert bare >= 0.9 * share
    else:
        assert bare < 0.03
    # bead centres on the outline reach into them
    assert not [
        n
        for n in fill_layer(layer_of(region), PROCESS.updated(fill={"outline_position": "on"})).notes
        if n.kind is NoticeKind.BARE
    ]


def test_the_last_layer_of_a_cam_is_told_of(fixture_step):
    made = bs.plan(bs.read_step(fixture_step("cam")), bs.Process(layer_thickness=2.0, step_over=3.4), axis="Z", substrate=40.0)
    bare = [
        coverage_of(la.region, f.beads, made.process.width).bare_share for la, f in zip(made.layers, made.fills, strict=True)
    ]
    (said,) = [n for n in made.notices if n.kind is NoticeKind.BARE]
    assert said.layers == tuple(i for i, share in enumerate(bare) if share > 0.02) == (8,)


@pytest.mark.parametrize(("thickness", "vanes"), [(1.0, 6), (2.0, 6), (1.5, 4), (1.0, 9), (2.0, 3)])
def test_narrow_vanes_on_a_band_get_beads_of_their_own(thickness, vanes):
    part = bodies.vaned_band(vanes, thickness=thickness)
    process = bs.Process(layer_thickness=2.0, step_over=2.0)
    made = bs.plan(part, process, axis="Z", substrate=30.0)
    for layer, fill in zip(made.layers, made.fills, strict=True):
        (piece,) = layer.region.pieces
        assert piece.winds
        mine = [b for b in fill.beads if b.kind is BeadKind.SKELETON]
        assert len(mine) == vanes
        assert all(b.points[:, 1].max() > 40.0 for b in mine)
        assert f"{vanes} narrow lobes" in fill.patterns[0]
        assert fill.metal[0] == pytest.approx(1.0, abs=0.02)
        # rings between the vanes, up to half a bead from the band's edge, and nothing bare there
        assert coverage_of(layer.region, fill.beads, process.width).bare_share < 0.005
    # a hatch alone leaves them bare, and that is told of
    bare = bs.plan(part, process.updated(fill={"pattern": "hatch"}), axis="Z", substrate=30.0)
    said = [n for n in bare.notices if n.kind is NoticeKind.NARROW]
    assert [(n.layers, n.pieces) for n in said] == [(tuple(layer.index for layer in made.layers), (0,))]
    assert f"{vanes} parts of it narrower than a bead get none" in str(said[0])
    if thickness == 2.0 and vanes == 6:
        assert max(f.metal[0] for f in bare.fills) < 0.98
        assert [n for n in bare.notices if n.kind is NoticeKind.PIECE_METAL]


def _lens(width):
    """Two arcs over a chord of 60 mm, `width` apart in the middle."""
    x = np.linspace(0.0, math.pi, 40)
    side = np.stack([0.5 * width * np.sin(x), 30.0 * (1.0 - np.cos(x))], axis=1)
    return [*side, *(side[-2:0:-1] * [-1.0, 1.0])]


TAPERS = {
    "rectangle": lambda w: [(0, 0), (w, 0), (w, 50.0), (0, 50.0)],
    "trapezium": lambda w: [(0, 0), (w, 0), (0.7 * w, 50.0), (0.3 * w, 50.0)],
    "parallelogram": lambda w: [(0, 0), (w, 0), (w + 15.0, 50.0), (15.0, 50.0)],
    "lens": _lens,
    "step": lambda w: [(0, 0), (w, 0), (w, 25.0), (0.6 * w, 25.0), (0.6 * w, 50.0), (0, 50.0)],
}


@pytest.mark.parametrize("shape", TAPERS)
def test_what_is_chosen_for_a_tapering_piece_changes_once(shape):
    hatched = []
    for width in np.linspace(45.0, 2.5, 40):
        fill = fill_layer(layer_of(polygon(*TAPERS[shape](width))), PROCESS)
        assert fill.metal[0] == pytest.approx(1.0, abs=0.02) or [n for n in fill.notes if n.kind is NoticeKind.PIECE_METAL]
        hatched.append(fill.patterns[0].startswith("hatch"))
    assert not hatched[-1]
    assert np.count_nonzero(np.diff(hatched)) <= 1


# (substrate radius mm, layer)
PILES = {
    "keyed_band": (45.0, 0),
    "box_on_shaft": (50.0, 0),
    "spur_gear_tooth": (None, 2),
    "helical_gear_tooth": (None, 0),
    "cam": (40.0, 1),
}


@pytest.mark.parametrize("contours", [1, 2])
@pytest.mark.parametrize("angle_deg", [0.0, 20.0, 31.0, 90.0])
@pytest.mark.parametrize("name", PILES)
def test_contours_and_hatch_do_not_pile_up(name, angle_deg, contours, fixture_step):
    process = bs.Process(
        layer_thickness=2.0, step_over=3.0, fill=bs.Fill(contours=contours, pattern=bs.Hatch(angle_deg=angle_deg))
    )
    substrate, number = PILES[name]
    part = bs.read_step(fixture_step(name))
    made = bs.plan(part, process, axis="Z", substrate=substrate, layers=(number, number + 1))
    (layer,), (fill,) = made.layers, made.fills
    deposit = deposit_of(layer.region, fill.beads, width=process.width, thickness=2.0, step_over=3.0)
    assert deposit.mean == pytest.approx(2.0, rel=0.02)
    assert fill.metal == pytest.approx([1.0] * len(fill.metal), abs=0.02)
    # ridges stood at 1.8 to 2.1 t where all lines ended as near to the contour as those at small angles have to
    even = evenness_of(layer.region, fill.beads, width=process.width, thickness=2.0, step_over=3.0, tolerance=0.02)
    assert even.peak <= 1.75 * 2.0
    # and nothing is bare that was not bare when they did
    near = fill_layer(layer, process.updated(fill={"overlap": 2.0 * 3.0 - process.width}))
    before, after = (coverage_of(layer.region, f.beads, process.width).bare_share for f in (near, fill))
    assert after <= before + 1e-3


@pytest.mark.parametrize("width", [1.05, 1.2, 1.44, 1.8])
@pytest.mark.parametrize("slant_deg", [1.0, 8.0, 20.0, 45.0, 70.0, 90.0])
def test_lines_beside_a_contour_leave_nothing_bare_and_hold_what_is_theirs(slant_deg, width):
    import shapely

    from brep_slicer.fill.tools.meeting import ends_from_contour, nearest_end

    slant = math.radians(slant_deg)
    end = float(ends_from_contour(np.array([math.sin(slant)]), 1.0, width)[0])
    way, count = np.array([math.cos(slant), math.sin(slant)]), 9
    starts = np.stack([np.arange(count) / math.sin(slant), np.full(count, end)], axis=1)
    lines = shapely.union_all(
        [shapely.LineString([p, p + 2.0 * count / math.sin(slant) * way]).buffer(0.5 * width, quad_segs=64) for p in starts]
    )
    # the contour is the line y = 0; between the fourth and the fifth line, from its edge on
    low, high = starts[[3, 5], 0]
    beside = shapely.box(low, 0.5 * width, high, 0.5 * width + 1.0)
    assert beside.difference(lines).area < 1e-3 * width
    # never farther than what its round end fills up to half-way, and never nearer than a wedge asks for
    filled = 0.5 + 3.0 * math.pi / 32.0 * width * math.sin(slant)
    assert nearest_end(1.0, width) - 1e-12 <= end <= max(filled, nearest_end(1.0, width)) + 1e-12
    if slant_deg >= 45.0 and width >= 1.44:
        assert end == pytest.approx(filled)


def test_a_line_without_room_between_two_contours_is_left_out_only_if_nothing_is_bare_without():
    strip = polygon((0, 0), (W + 2.0 * D - 0.6, 0), (W + 2.0 * D - 0.6, 40), (0, 40))
    for angle_deg in (0.0, 35.0, 90.0):
        process = PROCESS.updated(fill={"contours": 1, "pattern": bs.Hatch(angle_deg=angle_deg)})
        fill = fill_layer(layer_of(strip), process)
        near = fill_layer(layer_of(strip), process.updated(fill={"overlap": 2.0 * D - W}))
        # the piece's own corners stay bare, outside of the contour
        before, after = (coverage_of(strip, f.beads, W).bare_share for f in (near, fill))
        assert after <= before + 1e-3
        assert fill.metal[0] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    "chosen",
    [Hatch(angle_deg=math.degrees(0.3)), Skeleton(), Contours(count=2, skeleton=False)],
    ids=lambda p: type(p).__name__,
)
def test_a_pattern_that_is_chosen_keeps_the_contours(chosen):
    region = polygon((0, 0), (25, 0), (25, 40), (0, 40))
    fill = fill_layer(layer_of(region), PROCESS.updated(fill={"contours": 1}), lambda layer, piece: chosen)
    outermost = [b for b in fill.beads if b.kind is BeadKind.CONTOUR and b.points[:, 0].min() < 0.5 * W + 0.1]
    assert len(outermost) == 1
    none = fill_layer(layer_of(region), PROCESS, lambda layer, piece: Hatch(angle_deg=math.degrees(0.3)))
    assert not [b for b in none.beads if b.kind is BeadKind.CONTOUR]


def test_without_balance_all_beads_are_laid_at_one_speed_and_what_is_missing_is_told_of():
    region = polygon((0, 0), (15, 0), (15, 40), (0, 40))
    fill = fill_layer(layer_of(region), PROCESS.updated(fill={"balance": False, "pattern": "hatch"}))
    assert all(b.speed is None for b in fill.beads)
    assert fill.metal[0] == pytest.approx(metal_of(fill.beads, step_over=D, width=W).sum() / region.area, rel=1e-9)
    assert fill.metal[0] < 0.98
    assert [n for n in fill.notes if n.kind is NoticeKind.PIECE_METAL]


def test_contours_and_skeleton_cover_what_is_too_narrow_for_a_hatch():
    region = polygon((0, 0), (9.0, 0), (9.0, 60.0), (0, 60.0))
    fill = fill_layer(layer_of(region), PROCESS)
    assert "contours" in fill.patterns[0]
    assert coverage_of(region, fill.beads, W).bare_share < 0.02


def test_a_hole_is_measured_as_one():
    from brep_slicer.region import region_from_loops

    region = region_from_loops(cylinder(R), [rectangle(-20.0, 0.0, 20.0, 40.0), rectangle(-5.0, 12.0, 6.0, 25.0, hole=True)])
    fill = fill_layer(layer_of(region), PROCESS)
    assert metal_of(fill.beads, step_over=D, width=W).sum() == pytest.approx(region.area, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_no_random_plan_is_off_without_a_warning(seed):
    _, made = random_plan(np.random.default_rng(seed))
    assert not [f for f in metal_by_piece(made) if f.off and not f.named]


def at(region_or_points, kappa):
    return [(x + kappa, y) for x, y in region_or_points]


@pytest.mark.parametrize("pattern", [name for name in PATTERNS.own() if name not in ("rings", "helix")])
def test_equal_pieces_get_equal_beads_and_others_their_own(pattern):
    from brep_slicer.fill.tools.copies import copies_of
    from brep_slicer.region import Region

    corners = [(0.0, 0.0), (17.0, 3.0), (19.0, 31.0), (-2.0, 26.0)]
    taller = [*corners[:2], (19.0, 31.5), corners[3]]
    pieces = tuple(
        polygon(*at(c, k)).pieces[0] for c, k in ((corners, -58.0), (taller, -30.0), (corners, 2.3), (corners, 36.0))
    )
    assert copies_of(pieces).first == (0, 1, 0, 0)
    region = Region(sheet=cylinder(R), pieces=pieces)
    fill = fill_layer(layer_of(region), PROCESS.updated(fill={"pattern": pattern, "order": "pattern"}))
    mine = [[b for b in fill.beads if b.piece == i] for i in range(4)]
    for number, shift in ((2, 60.3), (3, 94.0)):
        assert len(mine[number]) == len(mine[0]) > 0
        for one, other in zip(mine[0], mine[number], strict=True):
            assert other.points == pytest.approx(one.points + np.array([shift, 0.0]), abs=1e-9)
            assert other.speed == pytest.approx(one.speed, abs=1e-9)
    # each as it would be alone
    for number, piece in enumerate(pieces[:2]):
        alone = fill_layer(
            layer_of(Region(sheet=cylinder(R), pieces=(piece,))), PROCESS.updated(fill={"pattern": pattern, "order": "pattern"})
        )
        assert fill.metal[number] == pytest.approx(alone.metal[0], abs=1e-9)
        for one, other in zip(alone.beads, mine[number], strict=True):
            assert other.points == pytest.approx(one.points, abs=1e-6)


def test_a_pattern_that_knows_where_it_is_fills_each_piece_by_itself():
    from dataclasses import dataclass

    from brep_slicer.fill import AreaFill, Bead, Pattern
    from brep_slicer.region import Region

    @dataclass(frozen=True)
    class Across(Pattern):
        def fill(self, area):
            low, v0, high, v1 = area.piece.bounds()
            kappa = max(low, min(high, 10.0 * math.ceil(low / 10.0)))
            return AreaFill(beads=(Bead(points=[(kappa, v0), (kappa, v1)], kind=BeadKind.HATCH, piece=area.index),))

    square = [(0.0, 0.0), (15.0, 0.0), (15.0, 15.0), (0.0, 15.0)]
    region = Region(sheet=cylinder(R), pieces=tuple(polygon(*at(square, k)).pieces[0] for k in (1.0, 26.0)))
    fill = fill_layer(layer_of(region), PROCESS, lambda layer, piece: Across())
    assert [b.points[0, 0] for b in fill.beads] == [10.0, 30.0]
