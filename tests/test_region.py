"""Regions: nesting on a periodic plane, exact areas, polygons, unions and differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from brep_slicer.curves import LineCurve, Loop, SinusoidCurve
from brep_slicer.errors import LayerError
from brep_slicer.region import Region, difference_of_regions, region_from_loops, union_of_regions

R = 20.0
TURN = 2.0 * np.pi * R


def rectangle(k0, v0, k1, v1, *, hole=False) -> Loop:
    corners = [(k0, v0), (k1, v0), (k1, v1), (k0, v1)]
    corners = corners[::-1] if hole else corners
    return Loop(curves=tuple(LineCurve(p0=corners[i], p1=corners[(i + 1) % 4]) for i in range(4)), radius=R)


def ring(v0, v1, start=0.0) -> list[Loop]:
    lower = Loop(curves=(LineCurve(p0=(start, v0), p1=(start + TURN, v0)),), radius=R, winding=1)
    upper = Loop(curves=(LineCurve(p0=(start + TURN, v1), p1=(start, v1)),), radius=R, winding=-1)
    return [lower, upper]


def test_a_band_with_a_hole_across_the_seam():
    region = region_from_loops(R, [*ring(0.0, 40.0), rectangle(TURN - 5.0, 10.0, TURN + 7.0, 30.0, hole=True)])
    assert len(region.pieces) == 1
    assert region.pieces[0].winds
    assert region.area == pytest.approx(TURN * 40.0 - 12.0 * 20.0, rel=1e-14)
    assert region.first_moment == pytest.approx(TURN * 40.0 * 20.0 - 12.0 * 20.0 * 20.0, rel=1e-14)
    for seam in (None, 3.0, -1.0):
        assert region.to_shapely(chord=0.01, seam=seam).area == pytest.approx(region.area, rel=1e-12)


@given(st.floats(-300.0, 300.0))
def test_turning_a_region_changes_nothing(kappa):
    region = region_from_loops(
        R, [rectangle(kappa, 0.0, kappa + 30.0, 10.0), rectangle(kappa + 10.0, 2.0, kappa + 20.0, 8.0, hole=True)]
    )
    assert region.area == pytest.approx(240.0, rel=1e-12)
    assert len(region.pieces[0].holes) == 1
    k0, _, k1, _ = region.pieces[0].bounds()
    assert abs(0.5 * (k0 + k1)) <= 0.5 * TURN + 1e-9


def test_a_strip_longer_than_a_turn_is_one_piece():
    strip = region_from_loops(R, [rectangle(0.0, 0.0, 2.5 * TURN, 1.0)])
    assert not strip.pieces[0].winds
    assert strip.area == pytest.approx(2.5 * TURN)


def test_a_hole_in_nothing_is_an_error():
    with pytest.raises(LayerError, match="lies in no piece"):
        region_from_loops(R, [rectangle(0.0, 0.0, 1.0, 1.0, hole=True)])


def test_a_lone_edge_of_a_band_is_an_error():
    with pytest.raises(LayerError, match="do not pair up"):
        region_from_loops(R, ring(0.0, 1.0)[:1])


def test_jogs_do_not_move_the_area_with_the_origin():
    gap = 1e-3
    corners = [(0.0, 0.0), (10.0, 0.0), (10.0, 5.0), (0.0, 5.0)]
    for lift in (0.0, 1e6):
        curves = [LineCurve(p0=np.add(corners[i], (0, lift)), p1=np.add(corners[(i + 1) % 4], (gap, lift))) for i in range(4)]
        assert Loop(curves=tuple(curves), radius=R).signed_area() == pytest.approx(50.0, abs=10 * gap)


class TestOverlay:
    def test_union_and_difference_of_crossing_rectangles(self):
        a, b = (region_from_loops(R, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(15, -5, 25, 5)))
        assert union_of_regions(R, [a, b]).area == pytest.approx(200.0 + 100.0 - 25.0, rel=1e-12)
        assert difference_of_regions(a, b).area == pytest.approx(175.0, rel=1e-12)
        assert difference_of_regions(b, a).area == pytest.approx(75.0, rel=1e-12)

    def test_crossing_over_the_seam(self):
        a = region_from_loops(R, [rectangle(-10, 0, 10, 10)])
        b = region_from_loops(R, [rectangle(TURN + 5, -5, TURN + 15, 5)])
        assert union_of_regions(R, [a, b]).area == pytest.approx(200.0 + 100.0 - 25.0, rel=1e-12)

    def test_a_blade_on_a_band_and_kinds_are_kept(self):
        wave = SinusoidCurve(coefficients=np.array([40.0, 3.0, 0.0]), radius=R, range=(TURN, 0.0))
        lower = Loop(curves=(LineCurve(p0=(0.0, 0.0), p1=(TURN, 0.0)),), radius=R, winding=1)
        band = region_from_loops(R, [lower, Loop(curves=(wave,), radius=R, winding=-1)])
        blade = region_from_loops(R, [rectangle(-5, 30, 5, 60)])
        both = union_of_regions(R, [band, blade])
        outside = difference_of_regions(blade, band)
        assert both.area == pytest.approx(band.area + outside.area, rel=1e-12)
        # the strip of the blade that lies in the band: integral of 40 + 3 cos(k / R) - 30 over |k| < 5
        inside = 2.0 * (10.0 * 5.0 + 3.0 * R * np.sin(5.0 / R))
        assert outside.area == pytest.approx(300.0 - inside, rel=1e-11)
        assert {c.kind.value for loop in outside.loops for c in loop.curves} == {"line", "sinusoid"}

    def test_a_piece_inside_of_another(self):
        a, b = (region_from_loops(R, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(5, 2, 8, 4)))
        assert union_of_regions(R, [a, b]).area == pytest.approx(200.0)
        assert difference_of_regions(b, a).is_empty
        assert difference_of_regions(a, b).area == pytest.approx(194.0)

    def test_pieces_that_only_touch(self):
        a, b = (region_from_loops(R, [r]) for r in (rectangle(0, 0, 20, 10), rectangle(20, 0, 30, 10)))
        assert union_of_regions(R, [a, b]).area == pytest.approx(300.0)
        assert difference_of_regions(a, b).area == pytest.approx(200.0)

    def test_nothing(self):
        a = region_from_loops(R, [rectangle(0, 0, 20, 10)])
        assert union_of_regions(R, []).is_empty
        assert union_of_regions(R, [Region(radius=R), a]).area == pytest.approx(200.0)
        assert difference_of_regions(Region(radius=R), a).is_empty
