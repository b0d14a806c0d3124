"""The default substrate, and how layers are stacked on it."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import brep_slicer as bs
from brep_slicer.process import CutAt, LastLayer
from brep_slicer.substrate.layers import stack_layers

Z = bs.axis_from_text("Z")


def stack(substrate, highest, **kwargs):
    thickness = kwargs.pop("layer_thickness")
    return stack_layers(substrate, highest, bs.Process(layer_thickness=thickness, step_over=1.0, layers=kwargs))


def test_the_paper_s_layer_counts():
    # Tables 3 and 4: t = 1.4 mm on R = 150 mm, 31 and 24 layers
    assert len(stack(150.0, 150.0 + 43.4, layer_thickness=1.4).radii) == 31
    assert len(stack(150.0, 150.0 + 33.6, layer_thickness=1.4).radii) == 24


@given(st.integers(1, 400), st.floats(0.05, 5.0), st.floats(1.0, 500.0))
def test_a_whole_multiple_is_that_many_layers(n, t, radius):
    made = stack(radius, radius + n * t, layer_thickness=t)
    assert len(made.radii) == n
    assert made.radii[-1] == pytest.approx(radius + (n - 1) * t)


def test_what_becomes_of_the_last_layer():
    kept = stack(10.0, 13.3, layer_thickness=1.0)
    assert (len(kept.radii), kept.overshoot) == (4, pytest.approx(0.7))
    assert "overshoots the part by 0.7 mm" in kept.notes[0]
    dropped = stack(10.0, 13.3, layer_thickness=1.0, last_layer=LastLayer.DROP)
    assert (len(dropped.radii), dropped.overshoot) == (3, 0.0)
    stretched = stack(10.0, 13.3, layer_thickness=1.0, last_layer=LastLayer.STRETCH)
    assert stretched.thicknesses == pytest.approx([1.1] * 3)


class TestSliversOfALastLayer:
    """What the part fills to less than a twentieth of t, or to less than is known of its end, is no layer by default."""

    @pytest.mark.parametrize(
        ("substrate", "highest", "t", "count", "filled"),
        [
            # 20 t + 0.033, which failed an auger; an inch part; a screw; a fine cladding; half a millionth above the share
            (10.0, 40.033, 1.5, 20, 0.033),
            (25.4, 38.6, 1.3, 10, 0.2),
            (3.0, 5.182, 0.06, 36, 0.022),
            (50.0, 50.302, 0.1, 3, 0.002),
            (10.0, 13.05, 1.0, 3, 0.05 - 5e-7),
            (10.0, 13.05, 1.0, 3, 0.05 + 5e-7),
        ],
    )
    def test_the_share(self, substrate, highest, t, count, filled):
        height = count * t + filled
        made = stack(substrate, substrate + height, layer_thickness=t)
        kept = stack(substrate, substrate + height, layer_thickness=t, last_layer="keep")
        assert (len(kept.radii), kept.undershoot) == (count + 1, 0.0)
        assert kept.overshoot == pytest.approx(t - filled)
        assert "overshoots the part by" in kept.notes[0]
        if filled < 0.05 * t:
            assert (len(made.radii), made.overshoot) == (count, 0.0)
            assert made.undershoot == pytest.approx(filled)
            assert f"the part's last {filled:.3g} mm are no layer: less than 5% of the thickness" in made.notes[0]
            assert "--last-layer keep builds it" in made.notes[0]
        else:
            assert made == kept

    def test_lists_count_by_the_thickness_of_their_last_layer(self):
        # 0.4 + 0.8 = 1.2; 0.03 more is 3.75 % of 0.8, and 7.5 % of 0.4
        assert len(stack(10.0, 11.23, layer_thickness=(0.4, 0.8)).radii) == 2
        assert len(stack(10.0, 11.23, layer_thickness=(0.8, 0.4)).radii) == 3

    def test_a_whole_layer_is_never_left_out(self):
        assert len(stack(10.0, 11.0 - 1e-6, layer_thickness=1.0).radii) == 1

    @pytest.mark.parametrize(("noise", "count"), [(0.0, 4), (0.1, 4), (0.31, 3), (50.0, 3)])
    def test_the_noise_of_the_outermost_face(self, noise, count):
        made = stack_layers(10.0, 13.3, bs.Process(step_over=1.0, layer_thickness=1.0), noise=noise)
        assert len(made.radii) == count
        assert ("known of its outermost face" in made.notes[0]) == (count == 3)

    def test_noise_takes_no_more_than_half_a_layer(self):
        assert len(stack_layers(10.0, 13.6, bs.Process(step_over=1.0, layer_thickness=1.0), noise=50.0).radii) == 4

    def test_the_noise_of_real_parts(self, real_step):
        from brep_slicer.section import cut_solids, noise_of_outermost

        # the blades' tips wander between R 299.991 and 300.001, and their edges say so; the hub's are exact
        part = bs.read_step(real_step("propeller_3blade_hub_openaxis.step"))
        hub, *blades = cut_solids(part, bs.find_axis(part))
        assert noise_of_outermost(hub) < 1e-6
        assert all(0.009 < noise_of_outermost(blade) < 0.02 for blade in blades)

    def test_a_plan_says_it(self, fixture_step):
        # 43.4 = 28 * 1.549 + 0.028
        part = bs.read_step(fixture_step("spur_gear_tooth"))
        made = bs.plan(part, bs.Process(layer_thickness=1.549, step_over=3.4), layers="26:")
        assert [layer.index for layer in made.layers] == [26, 27]
        assert made.report()["undershoot_mm"] == pytest.approx(0.028)
        assert any("last 0.028 mm are no layer" in warning for warning in made.warnings)


def test_lists_of_thicknesses_and_of_radii():
    assert stack(10.0, 13.0, layer_thickness=(0.5, 1.0)).radii == pytest.approx((10.0, 10.5, 11.5, 12.5))
    given_radii = stack(10.0, 13.0, layer_thickness=1.0, radii=(10.5, 11.0, 12.0))
    assert given_radii.thicknesses == pytest.approx((0.5, 1.0, 1.0))
    with pytest.raises(bs.InputError, match="lies outside of the part"):
        stack(10.0, 13.0, layer_thickness=1.0, radii=(12.0, 14.0))
    with pytest.raises(bs.InputError, match="lies inside of the substrate"):
        stack(10.0, 13.0, layer_thickness=1.0, radii=(9.0, 11.0))


def test_cut_at_mid_thickness_is_drawn_on_the_nominal_radius():
    bodies = pytest.importorskip("fixtures.bodies")
    body = bodies.BoxOnShaft()
    process = bs.Process(layer_thickness=2.0, step_over=3.0, layers=bs.Layers(cut_at=CutAt.MIDDLE))
    plan = bs.plan(body.solid(), process, axis=Z, layers=(0, 2))
    for layer in plan.layers:
        assert layer.cut_radius == pytest.approx(layer.radius + 1.0)
        assert layer.area == pytest.approx(body.area(layer.cut_radius), rel=1e-12)
        k0, _, k1, _ = layer.region.pieces[0].bounds()
        assert k1 - k0 == pytest.approx(2.0 * layer.radius * math.asin(20.0 / layer.cut_radius), rel=1e-12)


def test_too_thick_and_too_many():
    with pytest.raises(bs.InputError, match="larger than the whole height"):
        stack(10.0, 11.0, layer_thickness=5.0)
    with pytest.raises(bs.InputError, match="check its unit"):
        stack(10.0, 1000.0, layer_thickness=1e-3)


class TestDefaultSubstrate:
    def test_the_largest_shaft_with_metal_beyond(self, fixture_step):
        plan = bs.plan(
            bs.read_step(fixture_step("helical_gear_tooth")), bs.Process(layer_thickness=1.4, step_over=3.4), layers=(0, 1)
        )
        assert plan.substrate.radius == pytest.approx(150.0)
        assert "largest external coaxial cylinder" in plan.substrate.reason

    def test_else_the_largest_bore_with_a_warning(self, fixture_step):
        plan = bs.plan(bs.read_step(fixture_step("keyed_band")), bs.Process(layer_thickness=1.4, step_over=3.4), layers=(0, 1))
        assert plan.substrate.radius == pytest.approx(40.0)
        assert any("fills its bore" in w for w in plan.warnings)

    def test_else_an_error_that_asks(self, fixture_step):
        with pytest.raises(bs.PlanningError, match="give one with --substrate RADIUS"):
            bs.plan(bs.read_step(fixture_step("cylinder")), bs.Process(layer_thickness=1.0, step_over=1.0))

    def test_solids_that_stand_already(self, fixture_step):
        plan = bs.plan(bs.read_step(fixture_step("propeller")), bs.Process(layer_thickness=4.0, step_over=2.0), layers=(0, 2))
        assert plan.substrate.radius == pytest.approx(50.0)
        assert plan.substrate.solids == (0,)
        assert all(len(layer.region.pieces) == 3 for layer in plan.layers)

    def test_outside_of_the_part(self, fixture_step):
        with pytest.raises(bs.InputError, match="leaves nothing to build"):
            bs.plan(bs.read_step(fixture_step("cylinder")), bs.Process(layer_thickness=1.0, step_over=1.0), substrate=10.0)


class TestWhatMetalStandsOn:
    """Turned bars (radius, from z, to z) with lugs: the substrate is the largest cylinder that metal stands on."""

    SHAFT, FLANGES = (20.0, -60.0, 80.0), ((45.0, -20.0, -10.0), (45.0, 30.0, 40.0))

    @staticmethod
    def bar(radius, low, high):
        from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
        from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

        return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, low), gp_Dir(0, 0, 1)), radius, high - low).Solid()

    @staticmethod
    def box(low, high):
        from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
        from OCP.gp import gp_Pnt

        return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Solid()

    def united(self, *shapes):
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse

        out = shapes[0]
        for shape in shapes[1:]:
            out = BRepAlgoAPI_Fuse(out, shape).Shape()
        return out

    def lug(self):
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Common

        return BRepAlgoAPI_Common(self.bar(30.0, 5.0, 15.0), self.box((15.0, -12.0, 5.0), (35.0, 12.0, 15.0))).Shape()

    def chosen(self, *shapes):
        return bs.find_substrate(bs.as_part(self.united(*shapes)), Z, reach={0: 45.0})

    def bars(self, *bars):
        return [self.bar(*b) for b in bars]

    def test_the_turned_top_of_a_lug_is_none(self):
        found = self.chosen(*self.bars(self.SHAFT, *self.FLANGES), self.lug())
        assert found.radius == pytest.approx(20.0)
        assert "that metal stands on" in found.reason
        assert found.warnings == ()

    def test_a_pin_on_the_lug_is_carried_by_the_shaft_like_the_lug(self):
        pin = self.box((28.0, -2.0, 8.0), (34.0, 2.0, 12.0))
        found = self.chosen(*self.bars(self.SHAFT, *self.FLANGES), self.lug(), pin)
        assert found.radius == pytest.approx(20.0)
        assert "the next best is R 30" in found.reason

    @pytest.mark.parametrize(
        ("bars", "radius"),
        [
            (((20.0, -60.0, 80.0), (30.0, 0.0, 20.0), (45.0, 40.0, 60.0)), 20.0),
            # side by side, both stand on the shaft
            (((20.0, -60.0, 80.0), (30.0, 0.0, 20.0), (45.0, 20.0, 30.0)), 20.0),
            # relief grooves on either side of the flange, above an end of R 15
            (((15.0, -90.0, 90.0), (20.0, -60.0, -2.0), (19.5, -2.0, 12.0), (45.0, 0.0, 10.0), (20.0, 12.0, 80.0)), 20.0),
        ],
        ids=["apart", "side by side", "relief grooves"],
    )
    def test_steps(self, bars, radius):
        found = self.chosen(*self.bars(*bars))
        assert found.radius == pytest.approx(radius)
        assert found.warnings == ()

    def test_other_solids_that_touch_it(self):
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

        from brep_slicer.kernel.shapes import compound

        shaft, collar, ring = (self.bar(*b) for b in (self.SHAFT, (30.0, 5.0, 15.0), self.FLANGES[0]))
        parts = [shaft, *(BRepAlgoAPI_Cut(x, shaft).Shape() for x in (collar, ring))]
        found = bs.find_substrate(bs.as_part(compound(parts)), Z, reach={0: 20.0, 1: 30.0, 2: 45.0})
        assert found.radius == pytest.approx(20.0)
        assert found.solids == (0,)

    def test_a_ring_that_touches_nothing_sits_on_a_shaft_that_fills_its_bore(self):
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

        from brep_slicer.kernel.shapes import compound

        ring = BRepAlgoAPI_Cut(self.bar(*self.FLANGES[0]), self.bar(25.0, -30.0, 0.0)).Shape()
        found = bs.find_substrate(bs.as_part(compound([self.bar(*self.SHAFT), ring])), Z, reach={0: 20.0, 1: 45.0})
        assert found.radius == pytest.approx(25.0)
        assert (
            "no shaft surface belongs to the part: it is taken to sit on a shaft that fills its bore, R 25" in found.warnings[0]
        )
        assert (found.solids, found.built) == ((0,), (1,))
