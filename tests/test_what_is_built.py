"""What is built, what stands, and what is left alone: from how solids touch, or as a user says; and about which axis."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

import brep_slicer as bs
from brep_slicer.errors import InputError, PlanningError

bd = pytest.importorskip("build123d")

from brep_slicer.inspection import inspect_part  # noqa: E402
from tests.role_shapes import (  # noqa: E402
    bar,
    box,
    clad,
    crankshaft,
    file_of,
    gear,
    pin,
    ring,
    round_about,
    united,
    worn_shaft,
)

ROOT = Path(__file__).resolve().parent.parent
PROCESS = bs.Process(layer_thickness=1.0, step_over=2.0)


def planned(shape, **options):
    return bs.plan(shape, PROCESS, axis=options.pop("axis", "Z"), **options)


def areas(plan) -> list[float]:
    return [layer.area for layer in plan.layers]


def command(*words):
    return subprocess.run(
        [sys.executable, "-m", "brep_slicer", *map(str, words)], capture_output=True, text=True, cwd=ROOT, check=False
    )


def teeth(radius: float, count: int, width: float = 10.0) -> float:
    """Area of teeth 2.4 mm thick, by the arc between their flanks."""
    return count * width * 2.0 * radius * math.asin(1.2 / radius)


class TestLoosePins:
    """The whole solid that owns the substrate's cylinder stood: the gear was never built, the pin beside it was."""

    @pytest.mark.parametrize(
        ("options", "pins"),
        [({}, (30.0,)), ({"teeth": 12, "root": 14.0, "tip": 18.0}, (30.0, -35.0)), ({"width": 6.0, "teeth": 8}, (22.0,))],
    )
    def test_the_gear_is_built_and_the_pin_left_alone(self, options, pins):
        names = ["gear", *(f"pin {i}" for i in range(len(pins)))]
        plan = planned(file_of(gear(**options), *(pin(x) for x in pins), names=names))
        root, count, width = options.get("root", 12.0), options.get("teeth", 10), options.get("width", 10.0)
        assert (plan.substrate.radius, plan.substrate.built) == (root, (0,))
        assert plan.substrate.alone == tuple(range(1, len(names)))
        wanted = [teeth(layer.radius, count, width) for layer in plan.layers]
        assert areas(plan) == pytest.approx(wanted, rel=1e-9)
        (alone,) = [w for w in plan.warnings if "left alone" in w and "touches" in w]
        assert all(f"{i} ({name})" in alone for i, name in enumerate(names) if i)

    def test_the_pin_is_built_where_it_is_asked_for(self):
        shape = file_of(gear(), pin(), names=["gear", "pin"])
        plan = planned(shape, build=["pin"])
        assert plan.substrate.built == (0, 1)
        # the pin, R 3 at 30 mm, has metal from R 27 on
        assert plan.highest == pytest.approx(33.0, abs=1e-6)
        assert not any("left alone" in w for w in plan.warnings)

    @pytest.mark.parametrize(("root", "gap", "radius"), [(60.0, 0.3, 3.0), (60.0, 0.1, 4.0), (80.0, 0.45, 3.0)])
    def test_a_pin_that_nearly_touches_is_loose(self, root, gap, radius):
        # as near as facets of a part of this size may be off: a shaft with a lug, and a pin on its other side
        body = united(bar(root, -30.0, 30.0), box((root - 5.0, -4.0, -25.0), (root + 8.0, 4.0, -15.0)))
        beside = bd.Pos(-(root + gap + radius), 0, 10.0) * bd.Cylinder(radius, 20.0)
        found = inspect_part(file_of(body, beside, names=["shaft", "pin"]), axis="Z")
        assert "left alone: 1 (pin)" in found.roles


class TestTurbines:
    """A shaft with its end discs owns the cylinder, and vanes between the discs touch it nowhere: discs were not built."""

    DISC = 40.0

    def turbine(self, vanes: int = 4, disc: float = 40.0):
        shaft = united(bar(5.0, -30.0, 30.0), ring(4.0, disc, -28.0, -24.0), ring(4.0, disc, 24.0, 28.0))
        return file_of(shaft, *round_about(box((disc - 8.0, -2.0, -24.0), (disc - 2.0, 2.0, 24.0)), vanes))

    @pytest.mark.parametrize(("vanes", "disc"), [(4, 40.0), (3, 40.0), (5, 30.0)])
    def test_discs_and_vanes_are_built(self, vanes, disc):
        made = bs.plan(self.turbine(vanes, disc), bs.Process(layer_thickness=5.0, step_over=3.0), axis="Z", layers=(0, 5))
        assert made.substrate.built == tuple(range(vanes + 1))
        # below the vanes, two discs 4 mm thick
        for layer in made.layers:
            if layer.radius < disc - 8.5:
                assert layer.area == pytest.approx(2.0 * math.pi * layer.radius * 8.0, rel=1e-9)
            assert layer.area > 0.0


class TestWornShafts:
    """A shaft and the ring that is to be laid on its journal, R 23 to 25, in one file: the flange was built on the collar."""

    @pytest.mark.parametrize(
        "options",
        [{}, {"collar": 20.0}, {"flange": False}, {"collar": None}],
        ids=["collar at the end", "collar between lands", "no flange", "no collar"],
    )
    def test_the_ring_is_built_and_the_shaft_stands(self, options):
        plan = planned(file_of(worn_shaft(**options), clad(-20.0, 10.0), names=["shaft", "clad"]))
        assert (plan.substrate.radius, plan.substrate.built, plan.substrate.solids) == (23.0, (1,), (0,))
        assert areas(plan) == pytest.approx([2.0 * math.pi * r * 30.0 for r in (23.0, 24.0)], rel=1e-9)
        assert "stands: 0 (shaft)" in plan.substrate.roles
        # pi (30^2 - 23^2) 10 and pi (45^2 - 23^2) 12 of the shaft's own stand, and that is said
        lost = math.pi * (
            371.0 * 10.0 * (options.get("collar", 40.0) is not None) + 1496.0 * 12.0 * options.get("flange", True)
        )
        (said,) = [w for w in plan.warnings if "not built" in w]
        assert float(said.split()[0]) == pytest.approx(lost, rel=5e-3)

    @pytest.mark.parametrize(
        ("options", "rims"),
        [
            ({}, [(45.0, 47.0, -48.0, -40.0)]),
            ({"collar": None}, [(45.0, 47.0, -48.0, -40.0)]),
            ({}, [(45.0, 48.0, -50.0, -38.0), (30.0, 33.0, 41.0, 49.0)]),
        ],
        ids=["on the flange", "no collar", "on flange and collar"],
    )
    def test_rings_on_several_cylinders_are_built_from_the_lowest(self, options, rims):
        names = ["shaft", "clad", *(f"rim {i}" for i in range(len(rims)))]
        plan = planned(file_of(worn_shaft(**options), clad(-20.0, 10.0), *(ring(*rim) for rim in rims), names=names))
        assert plan.substrate.radius == 23.0
        assert (plan.substrate.solids, plan.substrate.built) == ((0,), tuple(range(1, len(names))))
        all_rings = [(23.0, 25.0, -20.0, 10.0), *rims]
        for layer in plan.layers:
            wanted = sum(high - low for inner, outer, low, high in all_rings if inner <= layer.radius < outer)
            assert layer.area == pytest.approx(2.0 * math.pi * layer.radius * wanted, rel=1e-9)

    def test_what_is_laid_on_a_standing_flange_is_built_as_well(self):
        shape = file_of(worn_shaft(), clad(-20.0, 10.0), ring(45.0, 47.0, -48.0, -40.0), names=["shaft", "clad", "rim"])
        plan = planned(shape, substrate=23.0)
        assert plan.substrate.built == (1, 2)
        by_radius = {round(layer.radius): layer.area for layer in plan.layers}
        assert by_radius[23] == pytest.approx(2.0 * math.pi * 23.0 * 30.0, rel=1e-9)
        assert by_radius[46] == pytest.approx(2.0 * math.pi * 46.0 * 8.0, rel=1e-9)


class TestThroughMetal:
    """One solid and --substrate 23: beads were laid through collar and flange, which go on inwards to the axis."""

    @pytest.mark.parametrize(
        "options", [{}, {"flange": False}, {"collar": None}], ids=["collar and flange", "collar", "flange"]
    )
    def test_collars_and_flanges_are_not_built(self, options):
        plan = planned(united(worn_shaft(**options), clad()), substrate=23.0)
        alone = planned(united(bar(23.0, -50.0, 50.0), clad()), substrate=23.0)
        assert areas(plan) == pytest.approx([2.0 * math.pi * r * 40.0 for r in (23.0, 24.0)], rel=1e-9)
        assert bead_length(plan) == pytest.approx(bead_length(alone), rel=1e-6)
        assert "collars that stand, at z" in plan.substrate.roles
        assert any("not built" in w for w in plan.warnings)

    def test_a_key_on_the_journal_is_built_and_the_collars_are_not(self):
        plan = planned(united(worn_shaft(), box((20.0, -3.0, -20.0), (26.0, 3.0, 20.0))), substrate=23.0)
        assert areas(plan)[:2] == pytest.approx([40.0 * 2.0 * r * math.asin(3.0 / r) for r in (23.0, 24.0)], rel=1e-9)

    def test_without_anything_else_the_collars_are_what_is_built(self):
        plan = planned(worn_shaft(flange=False), substrate=23.0)
        assert plan.substrate.zones == ()
        assert areas(plan)[0] == pytest.approx(2.0 * math.pi * 23.0 * 10.0, rel=1e-9)


def bead_length(plan) -> float:
    """mm of bead in a plan."""
    return sum(
        sum(math.dist(a, b) for a, b in zip(bead.points[:-1], bead.points[1:], strict=True))
        for fill in plan.fills
        for bead in fill.beads
    )


class TestTwoReadings:
    """A gear on its hub, and a ring on the same hub: is the ring alone to be built, or the teeth as well?"""

    @staticmethod
    def shape(count: int = 10):
        hub = united(gear(teeth=count), bar(12.0, 5.0, 20.0))
        return file_of(hub, ring(12.0, 15.0, 8.0, 16.0), names=["gear", "ring"])

    @staticmethod
    def ring_area(radius: float) -> float:
        return 2.0 * math.pi * radius * 8.0

    @pytest.mark.parametrize("count", [5, 10, 14])
    def test_an_error_that_names_both_and_the_options(self, count):
        with pytest.raises(PlanningError) as caught:
            planned(self.shape(count))
        assert caught.value.exit_code == 3
        for words in ("solid 1 (ring)", "solid 0 (gear)", "--stands 0", "--build 0"):
            assert words in str(caught.value)

    @pytest.mark.parametrize("key", ["gear", 0, "0"])
    def test_what_is_said_decides(self, key):
        standing = planned(self.shape(), stands=[key])
        assert areas(standing) == pytest.approx([self.ring_area(r) for r in (12.0, 13.0, 14.0)], rel=1e-9)
        both = planned(self.shape(), build=[key])
        wanted = [teeth(r, 10) + self.ring_area(r) * (r < 15.0) for r in (12.0, 13.0, 14.0, 15.0)]
        assert areas(both) == pytest.approx(wanted, rel=1e-9)

    def test_names_that_are_none(self):
        for options in ({"stands": ["ringg"]}, {"build": [2]}):
            with pytest.raises(InputError, match="there is no such solid; there are 0: gear, 1: ring"):
                planned(self.shape(), **options)
        with pytest.raises(InputError, match="by --build and by --stands"):
            planned(self.shape(), stands=[0], build=["gear"])

    def test_at_the_command(self, tmp_path):
        path = tmp_path / "two.step"
        bd.export_step(self.shape(), str(path))
        words = ("plan", path, "-t", 1, "-d", 2, "--axis", "Z", "-o", tmp_path / "out", "--layers", "0:1")
        asked = command(*words)
        assert asked.returncode == 3
        assert "--stands 0" in asked.stderr
        assert "Traceback" not in asked.stderr
        assert not (tmp_path / "out" / "toolpath.csv").exists()
        done = command(*words, "--stands", "gear")
        assert done.returncode == 0, done.stderr
        assert "roles: built beyond R 12: 1 (ring); stands: 0 (gear); nothing left alone" in done.stdout
        assert "not built" in done.stderr
        unknown = command("inspect", path, "--axis", "Z", "--build", "nut")
        assert unknown.returncode == 2
        assert "--build names 'nut'" in unknown.stderr
        seen = command("inspect", path, "--axis", "Z", "--build", 0)
        assert "roles: built beyond R 12: 0 (gear), 1 (ring); nothing left alone" in seen.stdout


class TestWrongAxis:
    """A band on a crank's pin, planned about the main axis: thirty layers of nonsense, exit 0."""

    @pytest.mark.parametrize("throw", [12.0, 15.0, 20.0])
    def test_both_axes_are_named(self, throw):
        found = inspect_part(file_of(*crankshaft(throw=throw), names=["crank", "band"]), axis="Z")
        (doubt,) = [w for w in found.warnings if "another axis" in w]
        assert f"--axis {throw:g},0,0:0,0,1" in doubt
        assert "0,0,0:0,0,1, which is used" in doubt

    @pytest.mark.parametrize("throw", [12.0, 15.0, 20.0])
    def test_not_with_the_right_one(self, throw):
        shape = file_of(*crankshaft(throw=throw), names=["crank", "band"])
        plan = planned(shape, axis=f"{throw:g},0,0:0,0,1", stands=["crank"], substrate=8.0)
        assert areas(plan) == pytest.approx([2.0 * math.pi * r * 20.0 for r in (8.0, 9.0)], rel=1e-9)
        assert not any("another axis" in w for w in plan.warnings)

    def test_studs_square_to_the_axis_are_features_like_others(self):
        stud = bd.Pos(15.0, 0, 0) * bd.Rot(0, 90, 0) * bd.Cylinder(4.0, 30.0)
        found = inspect_part(united(bar(20.0, -40.0, 40.0), *round_about(stud, 3)), axis="Z")
        assert not any("another axis" in w for w in found.warnings)


class TestEccentric:
    """A layer over thousands of mm2 on a cylinder 0.07 mm off the axis is its eccentricity."""

    @pytest.mark.parametrize(("radius", "offset"), [(25.0, 0.07), (20.0, 0.07), (22.0, 0.02)])
    def test_named_as_what_it_is(self, radius, offset):
        shape = united(
            bar(20.0, -40.0, 0.0), bd.Pos(offset, 0, 0) * bar(radius, 0.0, 20.0), box((18.0, -2.0, -15.0), (30.0, 2.0, -10.0))
        )
        found = inspect_part(shape, axis="Z", substrate=20.0)
        (said,) = [w for w in found.warnings if "eccentricity" in w]
        assert f"the cylinder R {radius:g} mm of solid 0" in said
        assert f"{offset:g} mm off the axis: it reaches from R {radius - offset:g} to R {radius + offset:g}" in said

    def test_not_of_one_on_the_axis(self):
        found = inspect_part(united(bar(20.0, -40.0, 40.0), box((18.0, -2.0, 15.0), (30.0, 2.0, 25.0))), axis="Z")
        assert not any("eccentric" in w for w in found.warnings)


class TestDoubles:
    """A file that holds a solid twice: said, since its metal would be taken for two solids'."""

    @staticmethod
    def said(*solids):
        names = [f"n{i}" for i in range(len(solids))]
        return [w for w in inspect_part(file_of(*solids, names=names), axis="Z").warnings if "twice" in w]

    @pytest.mark.parametrize("make", [gear, lambda: worn_shaft(), lambda: united(bar(20.0, -9.0, 9.0), pin(20.0))])
    def test_the_same_one_twice(self, make):
        (said,) = self.said(make(), clad(60.0, 70.0), make())
        assert said.startswith("solids 0 (n0) and 2 (n2) are the same twice")

    def test_equal_ones_elsewhere_are_two(self):
        # bars crossed at plus and minus 30 degrees: the same box, volume and centre
        crossed = [bd.Rot(0, 0, turn) * box((-30.0, -2.0, -2.0), (30.0, 2.0, 2.0)) - bar(5.0, -9.0, 9.0) for turn in (30, -30)]
        halves = [shape.solids()[0] for shape in crossed]
        assert self.said(bar(5.0, -20.0, 20.0), *halves) == []
        assert self.said(gear(), bd.Pos(0, 0, 0.5) * gear()) == []
