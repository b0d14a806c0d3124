"""Regions joined and taken from one another: closed forms, shapely on shared corners and edges, whole turns, real solids."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
import shapely.affinity
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.curves import LineCurve, Loop, QuadricCurve, SinusoidCurve
from brep_slicer.layers import cylinder
from brep_slicer.region import Layer, Region, difference_of_regions, region_from_loops, slice_solids, union_of_regions
from brep_slicer.section import cut_solids
from brep_slicer.substrate.axis import axis_from_line
from brep_slicer.testing import closure_of, integrate_sections

R = 20.0
SHEET = cylinder(R)
TURN = 2.0 * np.pi * R
AXIS = axis_from_line((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))


def chain(corners, *, winding=0) -> Loop:
    """Straight lines from corner to corner and back to the first."""
    last = (corners[0][0] + winding * TURN, corners[0][1])
    ends = [*corners[1:], last]
    return Loop(curves=tuple(LineCurve.between(a, b) for a, b in zip(corners, ends, strict=True)), sheet=SHEET, winding=winding)


def rectangle(k0, v0, k1, v1) -> Loop:
    return chain([(k0, v0), (k1, v0), (k1, v1), (k0, v1)])


def test_union_and_difference_of_crossing_rectangles():
    a, b = (region_from_loops(SHEET, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(15, -5, 25, 5)))
    assert union_of_regions(SHEET, [a, b]).area == pytest.approx(200.0 + 100.0 - 25.0, rel=1e-12)
    assert difference_of_regions(a, b).area == pytest.approx(175.0, rel=1e-12)
    assert difference_of_regions(b, a).area == pytest.approx(75.0, rel=1e-12)


def test_crossing_over_the_seam():
    a = region_from_loops(SHEET, [rectangle(-10, 0, 10, 10)])
    b = region_from_loops(SHEET, [rectangle(TURN + 5, -5, TURN + 15, 5)])
    assert union_of_regions(SHEET, [a, b]).area == pytest.approx(200.0 + 100.0 - 25.0, rel=1e-12)


def test_a_blade_on_a_band_and_kinds_are_kept():
    wave = SinusoidCurve(coefficients=np.array([40.0, 3.0, 0.0]), radius=R, range=(TURN, 0.0))
    lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(TURN, 0.0)),), sheet=SHEET, winding=1)
    band = region_from_loops(SHEET, [lower, Loop(curves=(wave,), sheet=SHEET, winding=-1)])
    blade = region_from_loops(SHEET, [rectangle(-5, 30, 5, 60)])
    both = union_of_regions(SHEET, [band, blade])
    outside = difference_of_regions(blade, band)
    assert both.area == pytest.approx(band.area + outside.area, rel=1e-12)
    # the strip of the blade that lies in the band: integral of 40 + 3 cos(k / R) - 30 over |k| < 5
    inside = 2.0 * (10.0 * 5.0 + 3.0 * R * np.sin(5.0 / R))
    assert outside.area == pytest.approx(300.0 - inside, rel=1e-11)
    assert {c.kind.value for loop in outside.loops for c in loop.curves} == {"line", "sinusoid"}


def test_a_piece_inside_of_another():
    a, b = (region_from_loops(SHEET, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(5, 2, 8, 4)))
    assert union_of_regions(SHEET, [a, b]).area == pytest.approx(200.0)
    assert difference_of_regions(b, a).is_empty
    assert difference_of_regions(a, b).area == pytest.approx(194.0)


def test_pieces_that_touch_are_one():
    a, b = (region_from_loops(SHEET, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(20, 0, 30, 10)))
    both = union_of_regions(SHEET, [a, b])
    assert both.area == pytest.approx(300.0)
    assert len(both.pieces) == 1
    assert difference_of_regions(a, b).area == pytest.approx(200.0)


def test_nothing():
    a = region_from_loops(SHEET, [rectangle(0, 0, 20, 10)])
    assert union_of_regions(SHEET, []).is_empty
    assert union_of_regions(SHEET, [Region(sheet=SHEET), a]).area == pytest.approx(200.0)
    assert difference_of_regions(Region(sheet=SHEET), a).is_empty


GAPS = [1e-10, 1e-7, 5e-7, 2e-6, 1e-5, 1e-4, 1e-3, 1e-2]


@pytest.mark.parametrize("gap", GAPS)
def test_overlaps_of_any_width_count_once(gap):
    a, b = (region_from_loops(SHEET, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(20 - gap, 2, 30, 12)))
    both = union_of_regions(SHEET, [a, b])
    assert len(both.pieces) == 1
    assert both.area == pytest.approx(200.0 + 100.0, abs=8.0 * gap + 1e-9)
    assert both.area == pytest.approx(300.0 + 10.0 * gap - 8.0 * gap, abs=1e-9 if gap > 1e-6 else 10.0 * gap)


@pytest.mark.parametrize("gap", GAPS)
def test_gaps_wider_than_a_touch_stay(gap):
    a, b = (region_from_loops(SHEET, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(20 + gap, 2, 30, 12)))
    both = union_of_regions(SHEET, [a, b])
    assert len(both.pieces) == (1 if gap < 1e-6 else 2)
    assert both.area == pytest.approx(300.0 - 10.0 * gap, abs=1e-9 if gap > 1e-6 else 10.0 * gap)


def test_the_same_region_twice_and_a_hole_filled():
    hole = rectangle(5, 2, 8, 4).reversed()
    a = region_from_loops(SHEET, [rectangle(0, 0, 20, 10), hole])
    assert union_of_regions(SHEET, [a, a]).area == pytest.approx(194.0)
    assert difference_of_regions(a, a).is_empty
    plug = region_from_loops(SHEET, [hole.reversed()])
    whole = union_of_regions(SHEET, [a, plug])
    assert whole.area == pytest.approx(200.0)
    assert not whole.pieces[0].holes


@pytest.mark.parametrize("starts", [(0.0, 1 / 2), (0.1, 0.35, 0.8), (0.0, 0.25, 0.5, 0.75)])
@pytest.mark.parametrize("overlap", [0.0, 3.0])
def test_sectors_close_to_a_band(starts, overlap):
    ends = [*starts[1:], starts[0] + 1.0]
    sectors = [
        region_from_loops(SHEET, [rectangle(a * TURN, 0, b * TURN + overlap, 10)]) for a, b in zip(starts, ends, strict=True)
    ]
    band = union_of_regions(SHEET, sectors)
    assert [piece.winds for piece in band.pieces] == [True]
    assert band.area == pytest.approx(10.0 * TURN, rel=1e-12)
    assert max(loop.jog() for loop in band.loops) < 1e-9


def pin(kappa, v, size) -> Region:
    """The section of a cylinder of radius `size`, square to the axis: size**2 = (R sin theta)**2 + v**2."""
    theta = kappa / R
    c = 0.5 * R**2 * np.array([1.0, 0.0, 0.0, -np.cos(2 * theta), -np.sin(2 * theta)])
    c[0] += v * v - size**2
    b = np.array([-v, 0.0, 0.0])
    half = R * np.arcsin(size / R)
    curve = QuadricCurve(a=1.0, b=b, c=c, radius=R, branch=1, range=(0.0, 2 * np.pi), fold=(kappa, half))
    loop = Loop(curves=(curve,), sheet=SHEET)
    return region_from_loops(SHEET, [loop if loop.signed_area() > 0 else loop.reversed()])


def test_pins_that_cross_touch_and_fill_their_holes():
    a, b, c = pin(0.0, 0.0, 4.0), pin(3.0, 2.0, 4.0), pin(0.0, 8.0, 4.0)
    chord = 1e-6
    truth = shapely.union_all([r.to_shapely(chord=chord) for r in (a, b)]).area
    both = union_of_regions(SHEET, [a, b])
    assert both.area == pytest.approx(truth, abs=chord * both.length)
    assert both.area == pytest.approx(a.area + difference_of_regions(b, a).area, rel=1e-12)
    assert max(loop.jog() for loop in both.loops) < 1e-9
    assert union_of_regions(SHEET, [a, c]).area == pytest.approx(a.area + c.area, rel=1e-9)
    band = region_from_loops(SHEET, [chain([(1.0, -10.0)], winding=1), chain([(1.0, 10.0)], winding=-1)])
    drilled = difference_of_regions(band, b)
    assert drilled.area == pytest.approx(band.area - b.area, rel=1e-12)
    assert union_of_regions(SHEET, [drilled, b]).area == pytest.approx(band.area, rel=1e-12)


def test_many_pins_in_any_order():
    rng = np.random.default_rng(4)
    half = 0.5 * TURN
    places = [(k, v) for k, v in rng.uniform([-half, -12.0], [half, 12.0], (12, 2))]
    pins = [pin(kappa, v, 3.0) for kappa, v in places] + [pin(TURN + 1.0, 30.0, 2.0), Region(sheet=SHEET)]
    chord = 1e-5
    drawn = [shapely.affinity.translate(r.to_shapely(chord=chord), k * TURN) for r in pins[:-1] for k in (-1, 0, 1)]
    truth = shapely.union_all(drawn).intersection(shapely.box(-half, -50.0, half, 50.0)).area
    unions = [
        union_of_regions(SHEET, [pins[i] for i in order]) for order in (range(14), range(13, -1, -1), rng.permutation(14))
    ]
    for union in unions:
        assert union.area == pytest.approx(truth, abs=chord * union.length)
        assert union.area == pytest.approx(unions[0].area, rel=1e-11)
        assert len(union.pieces) == len(unions[0].pieces)
    rest = difference_of_regions(unions[0], union_of_regions(SHEET, pins[:6]))
    assert rest.area + union_of_regions(SHEET, pins[:6]).area == pytest.approx(unions[0].area, rel=1e-11)


def shape(steps) -> shapely.Geometry:
    """Boxes and triangles on a grid, added and taken away: shared edges, corners on edges, corners on corners."""
    out = shapely.Polygon()
    for x, y, w, h, lean, add in steps:
        part = shapely.box(x, y, x + w, y + h) if lean is None else shapely.Polygon([(x, y), (x + w, y), (x + lean, y + h)])
        out = out.union(part) if add else out.difference(part)
    return shapely.set_precision(out, 0.0)


def region(polygons, move: float) -> Region:
    loops = []
    moved = shapely.affinity.translate(polygons, move)
    for polygon in getattr(moved, "geoms", [moved]):
        oriented = shapely.geometry.polygon.orient(polygon)
        loops += [chain(line.coords[:-1]) for line in (oriented.exterior, *oriented.interiors)]
    return region_from_loops(SHEET, loops)


steps = st.lists(
    st.tuples(
        st.integers(0, 5),
        st.integers(0, 5),
        st.integers(1, 4),
        st.integers(1, 4),
        st.none() | st.integers(0, 4),
        st.sampled_from([True, True, True, False]),
    ),
    min_size=1,
    max_size=3,
)


@settings(max_examples=60, deadline=None)
@given(steps, steps, st.sampled_from([0.05, 1.0, 9.0]), st.sampled_from([0.0, 37.0]), st.floats(-90, 90), st.integers(-2, 2))
def test_as_shapely_does_where_corners_and_edges_fall_together(one, other, scale, angle, move, turns):
    first, second = (
        shapely.affinity.rotate(shapely.affinity.scale(shape(s), scale, scale, origin=(0, 0)), angle, origin=(0, 0))
        for s in (one, other)
    )
    assume(first.area > 0 and second.area > 0)
    a, b = region(first, move), region(second, move + turns * TURN)
    fine = 1e-9 * scale
    for result, truth in (
        (union_of_regions(SHEET, [a, b]), shapely.union(first, second, grid_size=fine)),
        (difference_of_regions(a, b), shapely.difference(first, second, grid_size=fine)),
    ):
        assert result.area == pytest.approx(truth.area, abs=1e-6 * scale)


def test_sharp_corners_that_cross_behind_other_corners():
    one = region_from_loops(SHEET, [chain([(-18.0, -6.0), (7.0, 0.0), (8.0, 17.0)])])
    other = region_from_loops(SHEET, [chain([(31.0, -6.0), (7.0, 11.0), (4.0, -11.0)])])
    truth = shapely.union_all([r.to_shapely() for r in (one, other)]).area
    assert union_of_regions(SHEET, [one, other]).area == pytest.approx(truth, rel=1e-12)
    # a spike between two places where a line is drawn: nearest to both is the edge that runs along it
    spike = region_from_loops(
        SHEET, [chain([(-40.0, -5.0), (40.0, -5.0), (40.0, 0.0), (9.01, 0.0), (9.0, 3.0), (8.99, 0.0), (-40.0, 0.0)])]
    )
    strip = region_from_loops(SHEET, [chain([(-40.0, 1.0), (40.0, 1.0), (40.0, 2.0), (-40.0, 2.0)])])
    truth = shapely.union_all([r.to_shapely() for r in (spike, strip)]).area
    both = union_of_regions(SHEET, [spike, strip])
    assert both.area == pytest.approx(truth, rel=1e-12)
    assert len(both.pieces) == 1


def test_solids_that_cross_touch_and_coincide():
    bd = pytest.importorskip("build123d")
    ring = bd.Cylinder(20, 30) - bd.Cylinder(10, 30)
    hole = bd.Pos(15, 0, 0) * bd.Rot(0, 90, 0) * bd.Cylinder(4, 20)
    side = bd.Rot(90, 0, 0) * bd.Pos(0, 3, -20) * bd.Cylinder(4, 30)
    for shapes, radii, truth in (
        ([ring, ring], (12.0, 15.0), lambda r: 2 * np.pi * r * 30),
        ([ring - hole, hole], (12.0, 15.0, 18.0), lambda r: 2 * np.pi * r * 30),
        ([ring - hole, bd.Rot(0, 0, 40) * (ring - hole)], (12.0, 18.0), lambda r: 2 * np.pi * r * 30),
        ([ring, bd.Pos(0, 0, 30) * ring], (12.0, 18.0), lambda r: 2 * np.pi * r * 60),
        ([ring, side, hole], (12.0, 18.0), lambda r: 2 * np.pi * r * 30),
    ):
        part = bs.as_part(bd.Compound([s for shape in shapes for s in shape.solids()]))
        for layer in slice_solids(cut_solids(part, AXIS), radii):
            assert isinstance(layer, Layer)
            assert layer.area == pytest.approx(truth(layer.radius), rel=1e-9)
            assert len(layer.region.pieces) == 1


@pytest.mark.parametrize("shift", [1e-5, 1e-4, 1e-3, 1e-2, 0.2])
@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, 1.0), (0.6, 0.8)])
def test_outlines_that_cross_at_small_angles(shift, way):
    # a pin beside its own hole: the two outlines cross at about shift / 4 rad
    a, b = pin(0.0, 0.0, 4.0), pin(shift * way[0], shift * way[1], 4.0)
    chord = 1e-7
    first, second = (r.to_shapely(chord=chord) for r in (a, b))
    within = chord * (a.length + b.length) + 1e-7 * a.length
    assert union_of_regions(SHEET, [a, b]).area == pytest.approx(first.union(second).area, abs=within)
    assert difference_of_regions(a, b).area == pytest.approx(first.difference(second).area, abs=within)


@pytest.mark.parametrize("turned", [1e-6, 1e-5, 1e-4, 1e-3, 1e-1])
def test_bands_along_a_wave_that_is_turned(turned):
    def band(low, high, turn):
        waves = [
            SinusoidCurve(coefficients=np.array([v, w * np.cos(turn), w * np.sin(turn)]), radius=R, range=ends)
            for v, w, ends in ((*low, (0.0, TURN)), (*high, (TURN, 0.0)))
        ]
        return region_from_loops(
            SHEET, [Loop(curves=(c,), sheet=SHEET, winding=s) for c, s in zip(waves, (1, -1), strict=True)]
        )

    a, b = band((0.0, 0.0), (10.0, 4.0), 0.0), band((10.0, 4.0), (20.0, 0.0), turned)
    # they overlap by |4 cos x - 4 cos(x - turned)| over half a turn, and gape by as much over the other half
    lens = 2.0 * R * 8.0 * np.sin(0.5 * turned)
    both = union_of_regions(SHEET, [a, b])
    assert both.area == pytest.approx(20.0 * TURN - lens, abs=1e-6 * TURN if turned < 1e-6 else 4e-6 * TURN)
    assert difference_of_regions(a, b).area == pytest.approx(10.0 * TURN - lens, abs=4e-6 * TURN)


def test_halves_of_a_ring_on_the_radius_at_which_their_joint_touches_the_bore():
    bd = pytest.importorskip("build123d")
    ring = bd.Cylinder(30, 50) - bd.Cylinder(20, 50)
    side = bd.Pos(0, 70, 0) * bd.Box(200, 100, 200)
    part = bs.as_part(bd.Compound([s for shape in (ring - side, ring & side) for s in shape.solids()]))
    for layer in bs.slice_part(part, [20.0, 20.0 + 1e-7, 25.0], axis="Z"):
        assert isinstance(layer, Layer)
        assert layer.area == pytest.approx(2.0 * np.pi * layer.radius * 50.0, rel=1e-9)
        assert [piece.winds for piece in layer.region.pieces] == [True]


@pytest.mark.parametrize("gap", [5e-7, 1.1e-6, 2e-6, 5e-6])
def test_half_rings_with_a_gap_at_either_joint(gap):
    half = TURN / 2
    halves = [region_from_loops(SHEET, [rectangle(k, 0, k + half - gap, 10)]) for k in (0.0, half)]
    both = union_of_regions(SHEET, halves)
    assert [piece.winds for piece in both.pieces] == ([True] if gap < 1e-6 else [False, False])


def test_an_offset_of_an_extruded_spline_is_read_as_it_is():
    bd = pytest.importorskip("build123d")
    spline = bd.Spline([(5, 0), (0, 6.5), (-4, 0), (0, -4.5)], periodic=True)
    shape = bd.offset(bd.Pos(20, 0, 0) * bd.extrude(bd.make_face(spline), 8), 1.0)
    (solid,) = cut_solids(bs.as_part(shape), AXIS)
    # OCCT's own volume, a quadrature, is 3e-4 more than what all three volume integrals over the faces say
    assert integrate_sections(solid, relative=1e-7).volume == pytest.approx(closure_of(solid.brep).volume, rel=1e-6)
