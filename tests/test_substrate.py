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
    return stack_layers(substrate, highest, bs.Process(step_over=1.0, **kwargs))


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
    process = bs.Process(layer_thickness=2.0, step_over=3.0, cut_at=CutAt.MIDDLE)
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

    def test_a_pin_on_the_lug_makes_it_doubtful(self):
        pin = self.box((28.0, -2.0, 8.0), (34.0, 2.0, 12.0))
        found = self.chosen(*self.bars(self.SHAFT, *self.FLANGES), self.lug(), pin)
        assert found.radius == pytest.approx(30.0)
        assert "is it --substrate 20?" in found.warnings[0]

    @pytest.mark.parametrize(
        ("bars", "radius"),
        [
            (((20.0, -60.0, 80.0), (30.0, 0.0, 20.0), (45.0, 40.0, 60.0)), 20.0),
            (((20.0, -60.0, 80.0), (30.0, 0.0, 20.0), (45.0, 20.0, 30.0)), 30.0),
            # relief grooves on either side of the flange, above an end of R 15
            (((15.0, -90.0, 90.0), (20.0, -60.0, -2.0), (19.5, -2.0, 12.0), (45.0, 0.0, 10.0), (20.0, 12.0, 80.0)), 20.0),
        ],
        ids=["apart", "on each other", "relief grooves"],
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

    def test_none_is_told_of(self):
        # a ring that floats over the shaft touches nothing
        from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

        from brep_slicer.kernel.shapes import compound

        ring = BRepAlgoAPI_Cut(self.bar(*self.FLANGES[0]), self.bar(25.0, -30.0, 0.0)).Shape()
        found = bs.find_substrate(bs.as_part(compound([self.bar(*self.SHAFT), ring])), Z, reach={0: 20.0, 1: 45.0})
        assert found.radius == pytest.approx(20.0)
        assert "no metal is seen to stand on R 20" in found.warnings[0]
