"""What is built on what: the substrate by what it explains, roles of solids, metal that stands, doubts about the axis."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from typer.testing import CliRunner

import brep_slicer as bs
from brep_slicer.cli import app
from brep_slicer.inspection import inspect_part
from brep_slicer.section import cut_solids

turned = pytest.importorskip("fixtures.turned")
bd = pytest.importorskip("build123d")
bar, ring, box, ribs, lobe, named = turned.bar, turned.ring, turned.box, turned.ribs, turned.lobe, turned.named

PROCESS = bs.Process(layer_thickness=1.0, step_over=2.0)


def chosen(shape, **more):
    part = bs.as_part(shape)
    axis = more.pop("axis", bs.axis_from_text("Z"))
    reach = {s.index: s.critical.highest for s in cut_solids(part, axis)}
    return bs.find_substrate(part, axis, reach=reach, **more)


def worm(root, crest, collar, count, width):
    """Straight threads, so wide that their crests have more area than the root between them, and larger collars at the ends."""
    return bar(root, 0, 60) + ribs(count, 0.5 * root, crest, width, 10, 50) + bar(collar, 0, 5) + bar(collar, 55, 60)


def round_worm(root, crest, collar, count, width):
    """The same with turned crests, coaxial cylinders that the collars' faces rise beside."""
    ends = bar(collar, 0, 10) + bar(collar, 50, 60)
    return bar(root, 0, 60) + (ribs(count, 0.5 * root, 2 * crest, width, 10, 50) & bar(crest, 10, 50)) + ends


def tube(radius, flange, length, notch):
    """A tube with a notched flange at either end, and a lug on each flange."""
    out = bar(radius, 0, length)
    for low in (0.0, length - 10.0):
        cut = box((-flange, -2 * flange, low - 1), (flange, -notch, low + 11))
        out = out + (bar(flange, low, low + 10) - cut) + box((0.9 * flange, -6, low), (flange + 6, 6, low + 10))
    return out - bar(0.85 * radius, -1, length + 1)


def wheel(hub, rim, count, width):
    return ring(0.5 * hub, hub, -20, 20) + ring(rim, rim + 5, -6, 6) + ribs(count, 0.8 * hub, rim + 1, width, -3, 3)


def cam(base, boss, centre, nose):
    return lobe(base, centre, nose, 0, 12) + bar(boss, 12, 20) - bar(0.4 * base, -1, 21)


class TestTheCylinderThatExplainsThePart:
    @pytest.mark.parametrize(
        ("root", "crest", "collar", "count", "width"), [(6, 10, 11, 4, 6), (12, 18, 20, 5, 10), (20, 24, 30, 8, 13)]
    )
    def test_a_worm_s_root_not_its_crest(self, root, crest, collar, count, width):
        found = chosen(round_worm(root, crest, collar, count, width))
        assert found.radius == pytest.approx(root)
        assert f"the next best is R {crest}" in found.reason

    @pytest.mark.parametrize(
        ("radius", "flange", "length", "notch"), [(46.482, 65.88, 1280, 53), (20, 30, 500, 24), (30, 40, 900, 32)]
    )
    def test_a_tube_not_the_flanges_at_its_ends(self, radius, flange, length, notch):
        found = chosen(tube(radius, flange, length, notch))
        assert found.radius == pytest.approx(radius)
        assert f"the next best is R {flange}" in found.reason

    @pytest.mark.parametrize(("hub", "rim", "count", "width"), [(10, 40, 3, 6), (20, 80, 5, 8), (8, 30, 6, 3)])
    def test_a_wheel_s_hub_not_a_shaft_that_fills_its_rim(self, hub, rim, count, width):
        found = chosen(wheel(hub, rim, count, width))
        assert found.radius == pytest.approx(hub)
        assert not any("fills its bore" in w for w in found.warnings)
        assert "0 mm3 outside" in found.left_out

    @pytest.mark.parametrize(("base", "boss", "centre", "nose"), [(20, 24, 14, 14), (30, 36, 25, 20), (15, 20, 14, 10)])
    def test_a_cam_s_base_circle_not_the_boss_beside_it(self, base, boss, centre, nose):
        found = chosen(cam(base, boss, centre, nose))
        assert found.radius == pytest.approx(base)
        assert f"the next best is R {boss}, which leaves" in found.reason

    def test_what_a_given_radius_leaves_out_is_told(self):
        found = chosen(cam(30, 36, 25, 20), radius=36.0)
        # the lobe's metal between the radii, by the sector of the disc that lies inside of its outline: more than 2 % here
        assert any("left out below R 36 mm" in w and "% of the part" in w for w in found.warnings)

    def test_the_wheel_with_its_rim_on_air_stands_on_its_hub(self):
        rim = bar(10, -20, 20) + ring(40, 45, -6, 6) + ribs(3, 9, 41, 6, -3, 3)
        assert chosen(rim).radius == pytest.approx(10.0)

    @pytest.mark.parametrize("name", ["box_on_shaft", "cam", "helical_gear", "propeller", "spur_gear_tooth", "keyed_band"])
    def test_no_question_on_fixtures(self, name, fixture_step):
        found = inspect_part(bs.read_step(fixture_step(name)))
        assert found.substrate_radius is not None
        assert found.left_out.startswith("0")


def worn_shaft(turn=1.0):
    """Journal R 23, collar R 30, flange R 45; with turn = -1 the other way round."""
    parts = [(23, 0, 100), (30, 100, 110), (45, 110, 120)]
    shapes = [bar(r, *sorted((turn * a, turn * b))) for r, a, b in parts]
    return shapes[0] + shapes[1] + shapes[2]


def gear(bore=10.0, tip=48.0, low=40.0):
    """A gear on its axle, one solid; straight flanks, and no land between the teeth but the axle's."""
    return bar(bore, 0, 100) + ribs(12, 0.3 * bore, tip, 6, low, low + 20)


class TestRoles:
    @pytest.mark.parametrize(("bore", "low"), [(10.0, 40.0), (15.0, 20.0), (8.0, 60.0)])
    def test_a_gear_on_its_axle_is_built_though_a_pin_lies_beside_it(self, bore, low):
        plan = bs.plan(named(gear=gear(bore, low=low), pin=bd.Pos(60, 0, 50) * bd.Cylinder(3, 20)), PROCESS, axis="Z")
        assert plan.substrate.radius == pytest.approx(bore)
        assert (plan.substrate.built, plan.substrate.solids, plan.substrate.alone) == ((0,), (), (1,))
        assert not any(layer.region.is_empty for layer in plan.layers)
        assert any("left alone" in w and "1 (pin)" in w for w in plan.warnings)
        # each tooth is 6 mm wide and 20 long: at radius R 2 R asin(3 / R) round
        radius = plan.layers[-2].radius
        assert plan.layers[-2].area == pytest.approx(12 * 20 * 2 * radius * math.asin(3 / radius), rel=1e-9)

    @pytest.mark.parametrize("blades", [4, 6, 9])
    def test_end_discs_of_a_turbine_are_built(self, blades):
        rotor = bar(10, 0, 100) + bar(50, 0, 5) + bar(50, 95, 100)
        vanes = {f"blade{i}": bd.Rot(0, 0, 360 / blades * i) * box((42, -2, 5), (47, 2, 95)) for i in range(blades)}
        plan = bs.plan(named(rotor=rotor, **vanes), PROCESS, axis="Z", layers=(0, 3))
        assert plan.substrate.built == tuple(range(blades + 1))
        # two discs of 5 mm
        assert plan.layers[1].area == pytest.approx(2 * math.pi * 11 * 10, rel=1e-9)

    @pytest.mark.parametrize("turn", [1.0, -1.0])
    @pytest.mark.parametrize(("low", "high", "outer"), [(10, 90, 25), (0, 100, 24), (30, 60, 40)])
    def test_a_ring_is_built_on_a_worn_journal(self, turn, low, high, outer):
        a, b = sorted((turn * low, turn * high))
        plan = bs.plan(named(shaft=worn_shaft(turn), clad=ring(23, outer, a, b)), PROCESS)
        assert plan.substrate.radius == pytest.approx(23.0)
        assert (plan.substrate.built, plan.substrate.solids) == ((1,), (0,))
        assert plan.highest == pytest.approx(outer)
        for layer in plan.layers:
            assert layer.area == pytest.approx(2 * math.pi * layer.radius * (high - low), rel=1e-9)
        assert any("solid 0 (shaft) stands" in w for w in plan.warnings)

    def test_a_flange_and_a_bar_on_it_are_both_built(self):
        hub = bar(5, 0, 40) + bar(20, 0, 4)
        plan = bs.plan(named(hub=hub, bar=box((14, -2, 4), (18, 2, 40))), bs.Process(layer_thickness=0.5, step_over=1.0))
        assert plan.substrate.built == (0, 1)
        for layer in plan.layers:
            r = layer.radius
            # beyond sqrt(14^2 + 2^2) the bar's cross section is as wide as 2 R asin(2 / R), up to R = 18
            if r < 14.0:
                assert layer.area == pytest.approx(2 * math.pi * r * 4, rel=1e-9)
            elif math.hypot(14, 2) < r < 18.0:
                assert layer.area == pytest.approx(2 * math.pi * r * 4 + 36 * 2 * r * math.asin(2 / r), rel=1e-9)

    def test_two_readings_are_a_question_that_names_both(self):
        both = named(gear=gear(), clad=ring(10, 12, 70, 90))
        with pytest.raises(bs.PlanningError, match=r"either solid 1 \(clad\) alone.*--stands 0 or --build 0"):
            bs.plan(both, PROCESS)

    def test_the_options_answer_it(self):
        def both():
            return named(gear=gear(), clad=ring(10, 12, 70, 90))

        stands = bs.plan(both(), PROCESS, stands=["gear"])
        assert (stands.substrate.built, stands.substrate.solids) == ((1,), (0,))
        assert [layer.area for layer in stands.layers] == pytest.approx([2 * math.pi * r * 20 for r in (10, 11)], rel=1e-9)
        built = bs.plan(both(), PROCESS, build=[0], layers=(0, 2))
        assert built.substrate.built == (0, 1)
        # twelve teeth of 6 mm fill the turn so near to the axle: two rings of 20 mm
        assert built.layers[1].area == pytest.approx(2 * math.pi * 11 * 40, rel=1e-9)

    @pytest.mark.parametrize(
        ("more", "said"),
        [
            ({"stands": ["shft"]}, "--stands names 'shft', but there is no such solid; there are 0: shaft, 1: clad"),
            ({"build": [7]}, "--build names 7"),
            ({"build": ["clad"], "stands": [1]}, "named by --build and by --stands"),
        ],
    )
    def test_names_that_are_none(self, more, said):
        with pytest.raises(bs.InputError, match=said):
            chosen(named(shaft=worn_shaft(), clad=ring(23, 25, 10, 90)), **more)

    def test_the_command_says_and_takes_them(self, tmp_path):
        path = tmp_path / "worn.step"
        bd.export_step(named(shaft=worn_shaft(), clad=ring(23, 25, 10, 90)), str(path))
        seen = CliRunner().invoke(app, ["inspect", str(path)])
        assert "roles: built beyond R 23: 1 (clad); stands: 0 (shaft); nothing left alone" in seen.output
        data = json.loads(CliRunner().invoke(app, ["inspect", str(path), "--json", "--build", "shaft"]).output)
        assert data["roles"].startswith("built beyond R 23: 0 (shaft), 1 (clad)")
        done = CliRunner().invoke(app, ["plan", str(path), "-t", "1", "-d", "2", "-o", str(tmp_path / "out"), "--stands", "0"])
        assert done.exit_code == 0, done.output
        assert "roles: built beyond R 23: 1 (clad); stands: 0 (shaft)" in done.output
        report = json.loads((tmp_path / "out" / "report.json").read_text())
        assert [s["built"] for s in report["solids"]] == [False, True]

    def test_a_question_ends_the_command_with_3(self, tmp_path):
        path = tmp_path / "gear.step"
        bd.export_step(named(gear=gear(), clad=ring(10, 12, 70, 90)), str(path))
        done = CliRunner().invoke(app, ["plan", str(path), "-t", "1", "-d", "2", "-o", str(tmp_path / "out")])
        assert isinstance(done.exception, bs.PlanningError)
        assert done.exception.exit_code == 3


class TestMetalThatStands:
    """A land R 23 in one solid with what is built on it, and turned metal that goes on inwards through R 23 beside it."""

    @pytest.mark.parametrize("turn", [1.0, -1.0])
    @pytest.mark.parametrize(("low", "high", "outer"), [(10, 90, 25), (5, 50, 30), (20, 95, 24)])
    def test_collar_and_flange_are_not_built_over(self, turn, low, high, outer):
        a, b = sorted((turn * low, turn * high))
        plan = bs.plan(worn_shaft(turn) + bar(outer, a, b), PROCESS, substrate=23.0)
        assert plan.highest == pytest.approx(outer)
        for layer in plan.layers:
            assert layer.area == pytest.approx(2 * math.pi * layer.radius * (high - low), rel=1e-9)
        assert any("collars and flanges that stand" in w for w in plan.warnings)

    def test_collars_at_both_ends(self):
        shaft = worn_shaft() + bar(30, -10, 0) + bar(15, -60, -10)
        plan = bs.plan(shaft + ribs(4, 20, 28, 8, 40, 60), PROCESS, substrate=23.0)
        assert len(plan.substrate.zones) == 2
        radius = plan.layers[2].radius
        assert plan.layers[2].area == pytest.approx(4 * 20 * 2 * radius * math.asin(4 / radius), rel=1e-9)

    def test_travels_keep_clear_of_what_stands(self):
        plan = bs.plan(worn_shaft() + ribs(4, 20, 28, 8, 84, 99), PROCESS, substrate=23.0)
        points = plan.toolpath.points
        beside = points[:, 2] > 101.0
        # whatever passes over the flange does so outside of it
        assert not beside.any() or np.hypot(points[beside, 0], points[beside, 1]).min() > 45.0

    def test_a_collar_between_two_lands_is_built(self):
        plan = bs.plan(bar(23, 0, 160) + bar(30, 100, 110), PROCESS, substrate=23.0, layers=(0, 1))
        assert plan.layers[0].area == pytest.approx(2 * math.pi * 23 * 10, rel=1e-9)

    @pytest.mark.parametrize("count", [8, 12, 20])
    def test_a_gear_at_the_shaft_s_end_is_built(self, count):
        end = bar(10, 0, 60) + bar(24, 40, 60) + ribs(count, 22, 28, 4, 40, 60)
        plan = bs.plan(end + ribs(3, 8, 14, 4, 10, 20), PROCESS, substrate=10.0, layers=(0, 1))
        assert plan.substrate.zones == ()
        assert plan.layers[0].area == pytest.approx(2 * math.pi * 10 * 20 + 3 * 10 * 2 * 10 * math.asin(0.2), rel=1e-9)

    @pytest.mark.parametrize(("low", "high"), [(-5, 25), (10, 45), (-10, 50)])
    def test_a_blade_that_overhangs_its_hub_is_built_whole(self, low, high):
        blade = box((8, -2, 5), (12, 2, 35)) + box((12, -2, low), (30, 2, high))
        plan = bs.plan(bar(10, 0, 40) + blade, PROCESS, substrate=10.0)
        radius = plan.layers[8].radius
        assert plan.layers[8].area == pytest.approx((high - low) * 2 * radius * math.asin(2 / radius), rel=1e-9)

    @pytest.mark.parametrize("end", [100, 90])
    def test_steps_that_cannot_be_told_apart_are_warned_of(self, end):
        flush = worn_shaft() + bar(25, 10, 100)
        doubt = [w for w in chosen(flush, radius=23.0).warnings if "in one piece" in w]
        assert "the steps R 25, R 30, R 45 goes on through R 23 mm" in doubt[0]

    def test_without_a_land_all_is_built(self):
        plan = bs.plan(bar(10, 0, 30), PROCESS, axis="Z", substrate=5.0)
        assert plan.layers[0].area == pytest.approx(2 * math.pi * 5 * 30, rel=1e-9)


class TestZones:
    def region(self, low, high):
        layer = bs.slice_part(bar(10, low, high), [5.0], axis="Z")[0]
        return layer.region

    @pytest.mark.parametrize(
        ("zone", "left"),
        [((20.0, 50.0), 20.0), ((-5.0, 10.0), 20.0), ((10.0, 20.0), 20.0), ((-1.0, 31.0), 0.0), ((40.0, 50.0), 30.0)],
    )
    def test_what_lies_outside(self, zone, left):
        from brep_slicer.region import outside_of_zones

        rest = outside_of_zones(self.region(0, 30), [zone])
        assert rest.area == pytest.approx(2 * math.pi * 5 * left, rel=1e-12)

    def test_reach_of_faces(self):
        from brep_slicer.section import reach_of_faces

        (solid,) = cut_solids(bs.as_part(box((-3, -4, 0), (3, 4, 5))), bs.axis_from_text("Z"))
        reaches = sorted(reach_of_faces(solid, [i]) for i in range(6))
        # every face of the box has corners at sqrt(3^2 + 4^2)
        assert reaches == pytest.approx([5.0] * 6)
        (solid,) = cut_solids(bs.as_part(bd.Pos(20, 0, 0) * bd.Sphere(3)), bs.axis_from_text("Z"))
        assert reach_of_faces(solid, [0]) == pytest.approx(23.0)


def crank(throw, pin):
    """Two webs on a shaft of R 15, and a pin beside the axis between them."""
    webs = [box((-20, -20, low), (throw + pin + 4, 20, low + 8)) for low in (40, 72)]
    return bar(15, 0, 40) + bar(15, 80, 120) + webs[0] + webs[1] + bd.Pos(throw, 0, 60) * bd.Cylinder(pin, 24)


class TestTheAxisOfTheFeatures:
    @pytest.mark.parametrize(("throw", "pin"), [(22, 12), (30, 14), (26, 10)])
    @pytest.mark.parametrize("own", [False, True], ids=["one solid", "two solids"])
    def test_a_band_on_a_crankpin_is_not_about_the_main_axis(self, throw, pin, own):
        place = bd.Pos(throw, 0, 60)
        band = place * (bd.Cylinder(pin + 2, 16) - bd.Cylinder(pin, 16))
        shape = named(crank=crank(throw, pin), band=band) if own else crank(throw, pin) + place * bd.Cylinder(pin + 2, 16)
        said = [w for w in chosen(shape).warnings if "another axis" in w]
        assert f"is it --axis {throw},0,0:0,0,1?" in said[0]
        assert "for 0,0,0:0,0,1, which is used" in said[0]

    def test_and_about_its_own_axis_there_is_no_doubt(self):
        shape = named(crank=crank(22, 12), band=bd.Pos(22, 0, 60) * (bd.Cylinder(14, 16) - bd.Cylinder(12, 16)))
        found = chosen(shape, axis=bs.axis_from_text("22,0,0:0,0,1"))
        assert found.radius == pytest.approx(12.0)
        assert not any("another axis" in w for w in found.warnings)

    def test_noses_studs_and_holes_are_no_axes(self):
        studs = bar(20, 0, 60)
        for turn in (0, 120, 240):
            studs = studs + bd.Rot(0, 0, turn) * (bd.Pos(25, 0, 30) * bd.Rot(0, 90, 0) * bd.Cylinder(4, 20))
        drilled = bar(10, 0, 60) + bar(40, 20, 30)
        for turn in (0, 90, 180, 270):
            drilled = drilled - bd.Rot(0, 0, turn) * (bd.Pos(25, 0, 25) * bd.Cylinder(6, 20))
        for shape in (studs, drilled, cam(20, 24, 14, 14)):
            assert not any("another axis" in w for w in chosen(shape).warnings)

    @pytest.mark.parametrize(("radius", "offset"), [(50.0, 0.07), (50.0, 0.2), (49.98, 0.1)])
    def test_a_shaft_just_off_the_axis_is_named(self, radius, offset):
        shape = named(
            ribs=bar(50, 0, 100) + ribs(4, 45, 60, 8, 20, 60), shaft=bd.Pos(offset, 0, 200) * bd.Cylinder(radius, 200)
        )
        said = [w for w in chosen(shape).warnings if "off the axis" in w]
        assert f"R {radius:g} mm of solid 1" in said[0]
        assert f"lies {offset:g} mm off the axis" in said[0]
        assert f"to R {radius + offset:g}" in said[0]


def test_the_survey_knows_volumes_and_does_not_triangulate_the_part(fixture_step):
    from OCP.BRep import BRep_Tool
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopLoc import TopLoc_Location

    from brep_slicer.kernel.compat import as_face, sub_shapes
    from brep_slicer.substrate.lands import lands_of, levels_of
    from brep_slicer.substrate.survey import survey_of

    part = bs.read_step(fixture_step("tube"))
    axis = bs.find_axis(part)
    survey = survey_of(part, axis, levels_of(lands_of(part, axis)))
    # pi (50^2 - 30^2) 40
    assert survey.volume == pytest.approx(math.pi * (50**2 - 30**2) * 40, rel=1e-6)
    for face in sub_shapes(part.solids[0].wrapped, TopAbs_FACE):
        assert BRep_Tool.Triangulation_s(as_face(face), TopLoc_Location()) is None
