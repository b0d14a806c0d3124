"""Metal on air: what of a layer no metal below carries, against closed forms."""

from __future__ import annotations

import math
from functools import reduce

import pytest

import brep_slicer as bs
from brep_slicer.curves import Loop
from brep_slicer.curves.line import LineCurve
from brep_slicer.layers import cylinder as sheet_of
from brep_slicer.notices import NoticeKind
from brep_slicer.planning import cut_layers
from brep_slicer.region import Region, drawn_region, overhang_of, region_from_loops

R, REACH = 40.0, 2.0
SHEET = sheet_of(R)
PERIOD = 2.0 * math.pi * R


def rectangle(k, v, length, height, radius):
    corners = [(k, v), (k + length, v), (k + length, v + height), (k, v + height)]
    return Loop(curves=tuple(LineCurve(p0=corners[i - 1], p1=corners[i]) for i in range(4)), sheet=sheet_of(radius))


def drawn(*boxes, radius=R):
    """Boxes (kappa, v, length, height) on a cylinder."""
    loops = [rectangle(*one, radius) for one in boxes]
    return drawn_region(region_from_loops(sheet_of(radius), loops), chord=0.01)


def hanging(above, below, reach=REACH):
    found = overhang_of(above, [below], reach=reach)
    return None if found is None else (found.over_air, found.beyond)


# where on the turn the shapes lie: in the middle of the chart, over its seam, a turn on
PLACES = [0.0, 0.5 * PERIOD - 5.0, -0.5 * PERIOD, PERIOD + 3.0]


@pytest.mark.parametrize("k", PLACES)
class TestPlaneFormulas:
    """a, h the extent of what is below; s how far the layer reaches beside it; r the reach."""

    A, H = 20.0, 15.0

    @pytest.mark.parametrize("s", [2.3, 3.0, 9.0])
    def test_a_step(self, k, s):
        # over air s h, beyond (s - r) h
        above = drawn((k, 0.0, self.A + s, self.H))
        assert hanging(above, drawn((k, 0.0, self.A, self.H))) == pytest.approx((s * self.H, (s - REACH) * self.H), rel=1e-9)

    @pytest.mark.parametrize("s", [0.0, 1.0, 1.99])
    def test_no_step_wider_than_the_reach(self, k, s):
        assert hanging(drawn((k - s, -s, self.A + 2 * s, self.H + s)), drawn((k, 0.0, self.A, self.H))) is None

    @pytest.mark.parametrize("s", [3.0, 6.0])
    def test_a_corner(self, k, s):
        # the corner of what is below is widened to a quarter circle
        whole, below = (self.A + s) * (self.H + s), self.A * self.H
        beyond = whole - below - REACH * (self.A + self.H) - 0.25 * math.pi * REACH**2
        found = hanging(drawn((k, 0.0, self.A + s, self.H + s)), drawn((k, 0.0, self.A, self.H)))
        assert found == pytest.approx((whole - below, beyond), rel=1e-3)

    @pytest.mark.parametrize(("gap", "bridged"), [(3.9, True), (4.5, False), (12.0, False)])
    def test_a_gap_below(self, k, gap, bridged):
        # the reach from both sides bridges 2 r; a wider gap hangs in full
        below = drawn((k, 0.0, self.A, self.H), (k + self.A + gap, 0.0, self.A, self.H))
        found = hanging(drawn((k, 0.0, 2 * self.A + gap, self.H)), below)
        if bridged:
            assert found is None
        else:
            assert found == pytest.approx((gap * self.H, (gap - 2.0 * REACH) * self.H), rel=1e-9)

    @pytest.mark.parametrize("beta_deg", [50.0, 60.0, 75.0])
    def test_a_slanted_rib(self, k, beta_deg):
        # a layer t = 1.4 higher it has moved by s = t tan(beta): over air s h where s > r
        s = 1.4 * math.tan(math.radians(beta_deg))
        found = hanging(drawn((k + s, 0.0, 12.0, self.H)), drawn((k, 0.0, 12.0, self.H)))
        assert found == (None if s < REACH else pytest.approx((s * self.H, (s - REACH) * self.H), rel=1e-9))

    def test_equal_angles_on_another_radius(self, k):
        # the same angles 10 % farther out: nothing hangs, though every length is greater; s is measured out there
        outer, s = 1.1 * R, 3.0
        below = drawn((k, 0.0, 100.0, self.H))
        assert hanging(drawn((1.1 * k, 0.0, 110.0, self.H), radius=outer), below) is None
        found = hanging(drawn((1.1 * k, 0.0, 110.0 + s, self.H), radius=outer), below)
        assert found == pytest.approx((s * self.H, (s - REACH) * self.H), rel=1e-9)

    def test_nothing_below(self, k):
        assert hanging(drawn((k, 0.0, 10.0, 10.0)), drawn()) == pytest.approx((100.0, 100.0))
        assert hanging(drawn(), drawn((k, 0.0, 10.0, 10.0))) is None


def test_a_speck_is_no_overhang():
    # a tenth of a circle of the reach: 1.2566 mm2
    side = math.sqrt(0.1 * math.pi) * REACH
    assert hanging(drawn((0.0, 0.0, 0.99 * side, side)), drawn()) is None
    assert hanging(drawn((0.0, 0.0, 1.01 * side, side)), drawn()) is not None


def test_several_regions_below_carry_together():
    halves = [drawn((0.0, 0.0, 10.0, 10.0)), drawn((10.0, 0.0, 10.0, 10.0))]
    assert overhang_of(drawn((0.0, 0.0, 20.0, 10.0)), halves, reach=REACH) is None
    assert overhang_of(drawn((0.0, 0.0, 20.0, 10.0)), halves[:1], reach=REACH).over_air == pytest.approx(100.0)
    assert drawn_region(Region(sheet=SHEET), chord=0.01).polygons == ()


# --- solids ---------------------------------------------------------------------------------------------------------------


def cylinder(radius, low, high):
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, low), gp_Dir(0, 0, 1)), radius, high - low).Shape()


def ring(inner, outer, low, high):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    return BRepAlgoAPI_Cut(cylinder(outer, low, high), cylinder(inner, low - 1, high + 1)).Shape()


def box(size, centre, turn_deg=0.0):
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt, gp_Trsf

    low, high = (gp_Pnt(*(c + sign * 0.5 * s for c, s in zip(centre, size, strict=True))) for sign in (-1, 1))
    turn = gp_Trsf()
    turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), math.radians(turn_deg))
    return BRepBuilderAPI_Transform(BRepPrimAPI_MakeBox(low, high).Shape(), turn, True).Shape()


def fused(*shapes):
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

    return reduce(lambda a, b: BRepAlgoAPI_Fuse(a, b).Shape(), shapes)


def turned(*profile):
    """A solid of revolution of a closed (rho, z) polygon."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    polygon = BRepBuilderAPI_MakePolygon()
    for rho, z in profile:
        polygon.Add(gp_Pnt(rho, 0, z))
    polygon.Close()
    face = BRepBuilderAPI_MakeFace(polygon.Wire()).Face()
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()


def on_air(shape, t=1.4, **given):
    """{layer: (over air, beyond)} of the notices, one for each layer, and their sentence."""
    process = bs.Process(layer_thickness=t, step_over=3.4, fill=bs.Fill(bead_width=2.0 * REACH))
    sections = cut_layers(shape, process, axis="Z", **given)
    said = [n for n in sections.notices if n.kind is NoticeKind.ON_AIR]
    assert len(said) <= 1
    return said[0] if said else None


class TestSolids:
    @pytest.mark.parametrize(
        ("hub", "inner", "outer", "spokes", "layers"), [(10, 40, 45, 3, None), (12, 30, 36, 5, None), (10, 40, 45, 3, "22:23")]
    )
    def test_a_rim_on_spokes(self, hub, inner, outer, spokes, layers):
        # 12 mm wide, on spokes of 6 by 6 mm: over air 2 pi R 12 - n 6 (2 R asin(3 / R_below)), R the first layer in the rim
        bars = [box((inner - 6.0, 6, 6), (0.5 * inner + 4.0, 0, 0), 360.0 * i / spokes) for i in range(spokes)]
        wheel = fused(cylinder(hub, -20, 20), ring(inner, outer, -6, 6), *bars)
        said = on_air(wheel, substrate=float(hub), layers=layers)
        first = math.ceil((inner - hub) / 1.4)
        radius, below = hub + 1.4 * first, hub + 1.4 * (first - 1)
        over_air = 2 * math.pi * radius * 12.0 - spokes * 6.0 * 2 * radius * math.asin(3.0 / below)
        assert said.layers == (first,)
        assert said.figures["over_air_mm2"] == pytest.approx((over_air, over_air), rel=1e-3)
        assert said.figures["per_cent"][0] == pytest.approx(100.0 * over_air / (2 * math.pi * radius * 12.0), rel=1e-3)

    @pytest.mark.parametrize(("slope", "hangs"), [(1.0, False), (1.4, False), (1.6, True), (3.0, True)])
    def test_an_overhanging_cone(self, slope, hangs):
        # a disc that grows by `slope` mm a mm on either side: 2 (2 pi R) t slope over air, where t slope > r
        top = 10.0 * slope
        disc = turned((0, -60), (20, -60), (20, -5), (30, -5 - top), (30, 5 + top), (20, 5), (20, 60), (0, 60))
        said = on_air(disc, t=1.4)
        if not hangs:
            assert said is None
            return
        assert said.layers == tuple(range(1, 8))
        expected = [2 * 2 * math.pi * (20.0 + 1.4 * i) * 1.4 * slope for i in (1, 7)]
        assert said.figures["over_air_mm2"] == pytest.approx(tuple(expected), rel=1e-6)

    @pytest.mark.parametrize(("low", "high", "over"), [(-10, 10, 0.0), (0, 31.5, 0.0), (10, 50, 20.0), (25, 45, 15.0)])
    def test_layer_0_on_the_shaft_that_is_there(self, low, high, over):
        # a shaft of R 20 ends at z = 30, the ring on it does not
        said = on_air(fused(cylinder(20, -30, 30), ring(20, 30, low, high)))
        if not over:
            assert said is None
            return
        assert said.layers == (0,)
        assert said.figures["over_air_mm2"][0] == pytest.approx(2 * math.pi * 20.0 * over, rel=1e-6)

    def test_layer_0_on_a_shaft_that_the_file_has_not_got(self):
        # a ring of its own, and one with a flat in its bore
        assert on_air(ring(20, 30, -10, 10)) is None
        assert on_air(fused(ring(20, 30, -10, 10), box((4, 20, 20), (17, 0, 0))), substrate=20.0) is None

    @pytest.mark.parametrize("flange", [True, False])
    def test_what_stands_carries(self, flange):
        from OCP.BRep import BRep_Builder
        from OCP.TopoDS import TopoDS_Compound

        # a lug of 8 by 20 mm on a flange of R 30 of the shaft that stands, from R 29 on; without the flange it floats
        shaft = fused(cylinder(20, -40, 40), ring(20, 30, -15, 15)) if flange else cylinder(20, -40, 40)
        both, builder = TopoDS_Compound(), BRep_Builder()
        builder.MakeCompound(both)
        builder.Add(both, shaft)
        builder.Add(both, box((8, 8, 20), (33, 0, 0)))
        said = on_air(both, substrate=20.0, stands=[0])
        if flange:
            assert said is None
        else:
            first = math.ceil((29.0 - 20.0) / 1.4)
            # the lug's corners lie at hypot(29, 4): at this radius all of it is inside of its flat foot, or none
            radius = 20.0 + 1.4 * first
            area = 20.0 * 2.0 * radius * math.asin(4.0 / radius)
            assert said.layers[0] in (first - 1, first)
            assert said.figures["over_air_mm2"][1] == pytest.approx(area, rel=1e-3)


NOTHING_HANGS = [
    "box_on_shaft",
    "cam",
    "drilled_tube",
    "helical_gear",
    "helical_gear_tooth",
    "keyed_band",
    "oblique_tube",
    "propeller",
    "spur_gear",
    "spur_gear_tooth",
    "tube",
    "wind_blade",
]


@pytest.mark.parametrize("t", [1.4, 0.4])
@pytest.mark.parametrize("name", NOTHING_HANGS)
def test_no_false_alarm_on_fixtures(name, t, fixture_step):
    process = bs.Process(layer_thickness=t, step_over=2.4 * t)
    sections = cut_layers(bs.read_step(fixture_step(name)), process, axis="Z", layers=None if t > 1.0 else ":40")
    assert not [str(n) for n in sections.notices if n.kind in (NoticeKind.ON_AIR, NoticeKind.EMPTY)]
