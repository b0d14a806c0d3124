"""What a user types first in Python: it works, or one line says what to write."""

from __future__ import annotations

import math
from pathlib import Path

import build123d as bd
import numpy as np
import pytest

import brep_slicer as bs

ROOT = Path(__file__).resolve().parent.parent
TOOTH = ROOT / "fixtures" / "step" / "spur_gear_tooth.step"
SIZES = {"layer_thickness": 1.4, "step_over": 3.4}


def lug():
    """A block on a shaft of R 20 about Z."""
    block = bd.Solid.make_box(30.0, 10.0, 20.0, bd.Plane((0.0, -5.0, 0.0)))
    return (bd.Solid.make_cylinder(20.0, 40.0, bd.Plane((0.0, 0.0, -10.0))) + block).solids()[0]


class TestAngles:
    def test_degrees_hatch_at_degrees(self):
        for given in (45, 45.0, (45.0,), [45], np.array([45.0]), np.float64(45.0)):
            process = bs.Process(**SIZES, fill=bs.Fill(pattern=bs.Automatic(angle_deg=given)))
            assert process.fill.pattern.angle_deg == (45.0,)
            assert process.as_dict()["fill"]["pattern"]["angle_deg"] == [45.0]
        turned = bs.Process(**SIZES, fill=bs.Fill(pattern=bs.Hatch(angle_deg=(0, 90), angle_step_deg=7.0)))
        plan = bs.plan(TOOTH, turned, layers="0:3")
        assert [fill.angle[0] for fill in plan.fills] == pytest.approx(np.radians([0.0, 97.0, 14.0]), abs=1e-15)

    def test_the_beads_lie_at_that_angle(self):
        plan = bs.plan(TOOTH, bs.Process(**SIZES, fill=bs.Fill(pattern=bs.Hatch(angle_deg=45))), layers="0:1")
        steps = np.array([b.points[-1] - b.points[0] for b in plan.fills[0].beads if b.kind is bs.BeadKind.HATCH])
        assert len(steps) > 10
        angles = np.remainder(np.arctan2(steps[:, 1], steps[:, 0]), math.pi)
        assert angles == pytest.approx(np.full(len(steps), math.pi / 4.0), abs=1e-12)

    @pytest.mark.parametrize(
        ("kind", "name"), [(bs.Hatch, "angle"), (bs.Hatch, "angles"), (bs.Zigzag, "angle_step"), (bs.Helix, "start_angle")]
    )
    def test_the_name_without_its_unit_is_refused_with_the_right_one(self, kind, name):
        right = f"{name.removesuffix('s')}_deg"
        said = rf"{name} is no parameter of pattern {kind.name}; did you mean {right} \(in degrees\)\?"
        with pytest.raises(bs.InputError, match=said):
            kind(**{name: 0.5})
        with pytest.raises(bs.InputError, match=said):
            bs.Process(**SIZES, fill={"pattern": {"name": kind.name, name: 0.5}})
        with pytest.raises(bs.InputError, match=said):
            bs.Rule(changes={"pattern": {"name": kind.name, name: 0.5}})

    def test_what_once_was_radians_does_not_hatch_at_2578_degrees(self):
        with pytest.raises(bs.InputError, match="it is angle_deg of the pattern now"):
            bs.Process(**SIZES, hatch_angles_deg=(45,))
        with pytest.raises(bs.InputError, match="hatch_angles is no process parameter"):
            bs.Process(**SIZES, hatch_angles=(45,))


class TestNamesAndValues:
    @pytest.mark.parametrize(
        ("given", "near"),
        [
            ({"contour": 1}, "did you mean contours\\? it stands in the table \\[fill\\]"),
            ({"contours": 1}, r"it stands in the table \[fill\] \(in Python fill=Fill\(contours=...\)\)"),
            ({"step_ovr": 1.0}, "did you mean step_over"),
            ({"patern": "helix"}, "did you mean pattern"),
            ({"deposition_speed": 9.0}, "did you mean deposition_speed_mm_s"),
            ({"fils": {}}, "did you mean fill"),
            ({"fit": "in"}, r"it is outline_position in \[fill\] now"),
            ({"hatch": False}, "the pattern says it"),
        ],
    )
    def test_a_name_that_no_parameter_has_is_told_of_with_the_nearest(self, given, near):
        with pytest.raises(bs.InputError, match=f"is no process parameter; {near}"):
            bs.Process(**SIZES, **given)

    @pytest.mark.parametrize(
        ("given", "said"),
        [
            ({"layer_thickness": "1.4"}, "layer_thickness is '1.4', a text; write the number without quotes"),
            ({"layer_thickness": ["1.4", "1"]}, "layer_thickness is '1.4', a text"),
            ({"layer_thickness": []}, "layer_thickness is an empty list"),
            ({"step_over": "3.4"}, "step_over is '3.4', a text"),
            ({"fill": {"pattern": {"name": "hatch", "angle_deg": "45"}}}, "fill: angle_deg is '45', a text"),
            ({"fill": {"pattern": {"name": "hatch", "angle_deg": ()}}}, "angle_deg is an empty list"),
            ({"fill": {"pattern": {"name": "hatch", "both_ways": "no"}}}, "both_ways is 'no'; it must be true or false"),
            ({"fill": {"pattern": {"angle_deg": 3}}}, "give the pattern's name"),
            ({"fill": {"pattern": 3}}, "give a pattern, its name, or a table"),
            ({"fill": {"alternate": 1}}, "alternate is 1; it must be true or false"),
            ({"fill": {"contours": True}}, "contours is True; it must be a whole number"),
            ({"fill": {"chord": 0.1}}, r"chord is no parameter of fill .*; it stands in the table \[motion\]"),
            ({"motion": {"step_over": 3}}, "it stands at the top of the file"),
            ({"laser": 3}, r"laser: laser is 3; give a table, \[laser\] in a file"),
            ({"rules": "hatch"}, "write each rule as a table"),
            ({"rules": [3]}, "write each rule as a table"),
        ],
    )
    def test_a_value_that_cannot_be_used_is_named(self, given, said):
        with pytest.raises(bs.InputError, match=said):
            bs.Process(**{**SIZES, **given})

    def test_numbers_of_numpy_are_numbers(self):
        process = bs.Process(
            layer_thickness=np.array([1.0, 2.0]), step_over=np.float32(3.0), fill=bs.Fill(contours=np.int64(2))
        )
        assert process.layer_thickness == (1.0, 2.0)
        assert process.fill.contours == 2
        assert type(process.fill.contours) is int
        assert [process.thickness(i) for i in (0, 1, 7)] == [1.0, 2.0, 2.0]


class TestRules:
    def test_layers_as_a_text_and_as_numbers_are_the_same(self):
        for layers in ("0:3", (0, 3), [0, 3]):
            rule = bs.Rule(layers=layers, changes={"contours": 2})
            assert [rule.on_layer(i) for i in range(5)] == [True, True, True, False, False]
            assert rule == bs.Rule(layers=(0, 3), changes={"contours": 2})
        assert bs.Rule(layers="3:", changes={"contours": 2}).layers == (3, None)

    def test_a_dict_is_a_rule(self):
        right = bs.Process(**SIZES, rules=(bs.Rule(layers=(0, 3), changes={"pattern": bs.Zigzag()}),))
        table = {"layers": "0:3", "pattern": "zigzag"}
        nested = {"layers": "0:3", "changes": {"pattern": "zigzag"}}
        for rules in ([table], (table,), table, [nested], [bs.Rule(layers="0:3", changes={"pattern": "zigzag"})]):
            assert bs.Process(**SIZES, rules=rules).rules == right.rules

    @pytest.mark.parametrize(
        ("make", "said"),
        [
            (lambda: bs.Rule(layers="0:3", contours=2), r"write changes=\{'contours': 2\}"),
            (lambda: bs.Rule(layer="0:3", changes={"contours": 2}), "layer is no field of a rule; did you mean layers"),
            (lambda: bs.Rule(layers="first", changes={"contours": 2}), "give 'a:b', as '0:3'"),
            (lambda: bs.Rule(layers=3, changes={"contours": 2}), "layers is 3; give 'a:b'"),
            (lambda: bs.Rule(layers="3:1", changes={"contours": 2}), "holds no layer"),
            (lambda: bs.Rule(changes=[("contours", 2)]), "give names and values"),
            (lambda: bs.Rule(full_turn="yes", changes={"contours": 2}), "full_turn is 'yes'; it must be true or false"),
            (lambda: bs.Process(**SIZES, rules=[{"contours": 1.5}]), "in a rule: contours is 1.5"),
            (lambda: bs.Process(**SIZES, rules=[{"layers": "0:3", "contour": 1}]), "contour is no .*; did you mean contours"),
            (lambda: bs.Process(**SIZES, rules=[{"pattern": "lines"}]), "in a rule: 'lines' is no pattern"),
        ],
    )
    def test_what_is_no_rule_is_told_of_at_once(self, make, said):
        with pytest.raises(bs.InputError, match=said):
            make()


class TestShapes:
    def test_functions_of_a_part_take_shapes_and_paths(self):
        solid = lug()
        assert bs.find_axis(solid).direction.tolist() == [0.0, 0.0, 1.0]
        assert bs.axis_candidates(solid)[0].share == pytest.approx(1.0)
        assert [c.radius for c in bs.coaxial_cylinders(solid)] == [pytest.approx(20.0)]
        assert [c.radius for c in bs.coaxial_cylinders(solid, "Z")] == [pytest.approx(20.0)]
        assert bs.coaxial_cylinders(solid, "X") == []
        for path in (TOOTH, str(TOOTH)):
            assert bs.find_axis(path).direction.tolist() == [0.0, 0.0, 1.0]
            assert bs.as_part(path).source == str(TOOTH)
            assert max(c.radius for c in bs.coaxial_cylinders(path) if c.external) == pytest.approx(193.4)

    def test_a_path_that_leads_nowhere_is_named(self):
        for use in (lambda p: bs.plan(p, bs.Process(**SIZES)), bs.find_axis, bs.inspect_part, bs.coaxial_cylinders):
            with pytest.raises(bs.InputError, match=r"gone\.step: there is no such file"):
                use("gone.step")
        with pytest.raises(bs.InputError, match="a int is no shape"):
            bs.find_axis(3)


class Vector:
    """Shaped as CadQuery's."""

    def __init__(self, *xyz):
        self.xyz = xyz

    def toTuple(self):
        return self.xyz


class Plane:
    """Shaped as CadQuery's."""

    def __init__(self, origin, normal):
        self.origin, self.zDir = Vector(*origin), Vector(*normal)


def ax1():
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    return gp_Ax1(gp_Pnt(1.0, 2.0, 7.0), gp_Dir(0.0, 0.0, -1.0))


LINES = {
    "build123d Axis": (lambda: bd.Axis((1.0, 2.0, 7.0), (0.0, 0.0, -1.0)), (1.0, 2.0, 0.0)),
    "build123d Plane": (lambda: bd.Plane((1.0, 2.0, 7.0)), (1.0, 2.0, 0.0)),
    "build123d Vector": (lambda: bd.Vector(0.0, 0.0, 3.0), (0.0, 0.0, 0.0)),
    "CadQuery Vector": (lambda: Vector(0.0, 0.0, 3.0), (0.0, 0.0, 0.0)),
    "CadQuery Plane": (lambda: Plane((1.0, 2.0, 7.0), (0.0, 0.0, 2.0)), (1.0, 2.0, 0.0)),
    "OCCT": (ax1, (1.0, 2.0, 0.0)),
    "numbers": (lambda: (0, 0, 1), (0.0, 0.0, 0.0)),
    "array": (lambda: np.array([0.0, 0.0, 1.0]), (0.0, 0.0, 0.0)),
    "point and direction": (lambda: ((1, 2, 7), (0, 0, 1)), (1.0, 2.0, 0.0)),
    "vectors": (lambda: (Vector(1, 2, 7), bd.Vector(0, 0, 1)), (1.0, 2.0, 0.0)),
    "text": (lambda: "1,2,7:0,0,1", (1.0, 2.0, 0.0)),
}


@pytest.mark.parametrize(("make", "origin"), LINES.values(), ids=LINES)
def test_an_axis_is_taken_as_the_hosts_have_it(make, origin):
    shape = lug()
    found = bs.inspect_part(shape, axis=make()).axis
    assert found.direction.tolist() == [0.0, 0.0, 1.0]
    assert found.origin.tolist() == pytest.approx(origin, abs=1e-12)
    (layer,) = bs.slice_part(shape, [25.0], axis=make())
    assert layer.area > 0.0


@pytest.mark.parametrize("given", [3, (0, 1), ("a", "b", "c"), [[0, 0], [1, 0]], object(), (0, 0, 0), (0.0, math.nan, 1.0)])
def test_what_is_no_axis_is_told_of(given):
    with pytest.raises(bs.InputError, match="axis") as caught:
        bs.inspect_part(lug(), axis=given)
    assert "\n" not in str(caught.value)
