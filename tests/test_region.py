"""Regions: nesting on a periodic plane, exact areas, polygons, unions and differences."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brep_slicer.curves import LineCurve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.layers import cylinder
from brep_slicer.region import overlapping_area, region_from_loops

R = 20.0
SHEET = cylinder(R)
TURN = 2.0 * np.pi * R


def rectangle(k0, v0, k1, v1, *, hole=False) -> Loop:
    corners = [(k0, v0), (k1, v0), (k1, v1), (k0, v1)]
    corners = corners[::-1] if hole else corners
    return Loop(curves=tuple(LineCurve(p0=corners[i], p1=corners[(i + 1) % 4]) for i in range(4)), sheet=SHEET)


def ring(v0, v1, start=0.0) -> list[Loop]:
    lower = Loop(curves=(LineCurve(p0=(start, v0), p1=(start + TURN, v0)),), sheet=SHEET, winding=1)
    upper = Loop(curves=(LineCurve(p0=(start + TURN, v1), p1=(start, v1)),), sheet=SHEET, winding=-1)
    return [lower, upper]


def test_a_band_with_a_hole_across_the_seam():
    region = region_from_loops(SHEET, [*ring(0.0, 40.0), rectangle(TURN - 5.0, 10.0, TURN + 7.0, 30.0, hole=True)])
    assert len(region.pieces) == 1
    assert region.pieces[0].winds
    assert region.area == pytest.approx(TURN * 40.0 - 12.0 * 20.0, rel=1e-14)
    assert region.first_moment == pytest.approx(TURN * 40.0 * 20.0 - 12.0 * 20.0 * 20.0, rel=1e-14)
    for seam_deg in (-180.0, 9.0, -3.0):
        assert region.to_shapely(chord=0.01, seam_deg=seam_deg).area == pytest.approx(region.area, rel=1e-12)


@pytest.mark.parametrize("turned", [0.0, 11.0, -200.0])
@pytest.mark.parametrize("first", [0, 1, 2])
def test_holes_of_a_band_whose_edge_folds_back(turned, first):
    # at kappa = 42 the lower edge passes at v = 7, back at 16 and on at 18.1; it may begin anywhere
    once = [(0.0, 0.0), (60.0, 10.0), (30.0, 20.0)]
    corners = [*once[first:], *((k + TURN, v) for k, v in once[: first + 1])]
    corners = [(k + turned, v) for k, v in corners]
    lines = tuple(LineCurve(p0=p, p1=q) for p, q in itertools.pairwise(corners))
    lower = Loop(curves=lines, sheet=SHEET, winding=1)
    holes = [rectangle(42.0 + turned, v, 42.5 + turned, v + 1.0, hole=True) for v in (10.0, 20.0)]
    below = [*ring(-60.0, -40.0, 5.0), rectangle(1.0, -55.0, 9.0, -50.0, hole=True)]
    region = region_from_loops(SHEET, [lower, ring(0.0, 40.0, turned)[1], *holes, *below])
    by_height = sorted(region.pieces, key=lambda piece: piece.bounds()[1])
    assert [len(piece.holes) for piece in by_height] == [1, 2]
    for loop in region.loops:
        points = loop.sample(0.01)
        assert loop.bounds() == pytest.approx((*points.min(axis=0), *points.max(axis=0)), abs=1e-12)
    for cut in (-0.5 * TURN, 42.0 + turned, 59.0 + turned + TURN, 31.0, 0.0, -77.0):
        flat = region.to_shapely(chord=0.01, seam_deg=360.0 * cut / TURN)
        assert flat.is_valid
        assert flat.area == pytest.approx(region.area, rel=1e-12)
        assert flat.bounds[::2] == pytest.approx((cut, cut + TURN), abs=1e-12)
    assert overlapping_area(region) == 0.0
    gap = rectangle(42.0 + turned, 16.4, 42.5 + turned, 17.6, hole=True)
    with pytest.raises(LayerError, match="lies in no piece"):
        region_from_loops(SHEET, [lower, ring(0.0, 40.0, turned)[1], gap])


@given(st.floats(-300.0, 300.0))
def test_turning_a_region_changes_nothing(kappa):
    region = region_from_loops(
        SHEET, [rectangle(kappa, 0.0, kappa + 30.0, 10.0), rectangle(kappa + 10.0, 2.0, kappa + 20.0, 8.0, hole=True)]
    )
    assert region.area == pytest.approx(240.0, rel=1e-12)
    assert len(region.pieces[0].holes) == 1
    k0, _, k1, _ = region.pieces[0].bounds()
    assert abs(0.5 * (k0 + k1)) <= 0.5 * TURN + 1e-9


def test_a_strip_longer_than_a_turn_is_one_piece():
    strip = region_from_loops(SHEET, [rectangle(0.0, 0.0, 2.5 * TURN, 1.0)])
    assert not strip.pieces[0].winds
    assert strip.area == pytest.approx(2.5 * TURN)


def test_a_sliver_that_samples_do_not_show_holds_no_hole():
    # there and back on one line: rounding leaves it an area of 3e-17
    back = [
        (5.368224535209513, 2.7141107080611255),
        (5.259986644886235, 2.0537582476647738),
        (5.414612202490917, 2.997118905373848),
    ]
    sliver = [*back, (5.306374312167639, 2.336766444977496)]
    loop = Loop(curves=tuple(LineCurve(p0=sliver[i], p1=sliver[(i + 1) % 4]) for i in range(4)), sheet=SHEET)
    region = region_from_loops(SHEET, [rectangle(0.0, 0.0, 20.0, 20.0), rectangle(8.0, 8.0, 12.0, 12.0, hole=True), loop])
    assert region.area == pytest.approx(384.0)
    assert sorted(len(piece.holes) for piece in region.pieces)[-1] == 1


def test_what_lies_over_itself():
    assert overlapping_area(region_from_loops(SHEET, [])) == 0.0
    band, square = ring(0.0, 40.0), rectangle(10.0, 50.0, 30.0, 60.0)
    assert overlapping_area(region_from_loops(SHEET, [*band, square])) == 0.0
    hole = rectangle(10.0, 10.0, 30.0, 20.0, hole=True)
    assert overlapping_area(region_from_loops(SHEET, [*band, hole, rectangle(11.0, 11.0, 29.0, 19.0)])) == 0.0
    over = region_from_loops(SHEET, [*band, rectangle(TURN - 10.0, 30.0, TURN + 10.0, 60.0)])
    assert overlapping_area(over) == pytest.approx(20.0 * 10.0, rel=1e-9)
    helix = [(0.0, 0.0), (2.5 * TURN, 25.0), (2.5 * TURN, 37.0), (0.0, 12.0)]
    strip = Loop(curves=tuple(LineCurve(p0=helix[i], p1=helix[(i + 1) % 4]) for i in range(4)), sheet=SHEET)
    # 2.5 turns of pitch 10 and width 12: 2 mm lie over each other along all but the first turn
    assert overlapping_area(region_from_loops(SHEET, [strip])) == pytest.approx(1.5 * TURN * 2.0, rel=1e-9)
    thin = [(0.0, 0.0), (2.5 * TURN, 25.0), (2.5 * TURN, 34.0), (0.0, 9.0)]
    thread = Loop(curves=tuple(LineCurve(p0=thin[i], p1=thin[(i + 1) % 4]) for i in range(4)), sheet=SHEET)
    assert overlapping_area(region_from_loops(SHEET, [thread])) == 0.0
    bow = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (5.0, 10.0), (5.0, -5.0), (0.0, -5.0)]
    crossed = Loop(curves=tuple(LineCurve(p0=bow[i], p1=bow[(i + 1) % 6]) for i in range(6)), sheet=SHEET)
    assert overlapping_area(region_from_loops(SHEET, [crossed])) == pytest.approx(50.0)


def test_a_hole_in_nothing_is_an_error():
    with pytest.raises(LayerError, match="lies in no piece"):
        region_from_loops(SHEET, [rectangle(0.0, 0.0, 1.0, 1.0, hole=True)])


def test_a_lone_edge_of_a_band_is_an_error():
    with pytest.raises(LayerError, match="do not pair up"):
        region_from_loops(SHEET, ring(0.0, 1.0)[:1])


def test_jogs_do_not_move_the_area_with_the_origin():
    gap = 1e-3
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 5.0)]
    for lift in (0.0, 1e6):
        curves = [LineCurve(p0=np.add(corners[i], (0, lift)), p1=np.add(corners[(i + 1) % 4], (gap, lift))) for i in range(4)]
        assert Loop(curves=tuple(curves), sheet=SHEET).signed_area() == pytest.approx(50.0, abs=10 * gap)
