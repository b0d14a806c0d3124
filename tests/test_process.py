"""Process parameters: what is refused, what is assumed, what a file may say."""

from __future__ import annotations

import math

import build123d as bd
import pytest

import brep_slicer as bs
from brep_slicer import InputError, Process, read_process
from brep_slicer.fill import BeadKind
from brep_slicer.process import InnerPattern, LastLayer, Rule, process_from_values


@pytest.mark.parametrize("name", ["layer_thickness", "step_over", "bead_width", "chord", "deposition_speed_mm_s"])
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_values_out_of_range_are_named(name, value):
    given = {"layer_thickness": 1.0, "step_over": 1.0, name: value}
    with pytest.raises(InputError, match=name):
        Process(**given)


def test_assumed_values_are_named_and_given_ones_are_not():
    process = Process(layer_thickness=1.4, step_over=3.4, deposition_speed_mm_s=12.0)
    assert process.assumed()["bead_width"] == pytest.approx(1.44 * 3.4)
    assert "deposition_speed_mm_s" not in process.assumed()
    assert process.as_dict()["inset"] == pytest.approx(0.72 * 3.4)
    assert process.as_dict()["laser_power_w"] is None


def test_angles_by_layer():
    process = Process(layer_thickness=1, step_over=1, hatch_angles_deg=(0.0, 60.0), hatch_angle_step_deg=6.0)
    assert [process.hatch_angle(i) for i in range(3)] == pytest.approx([0.0, math.radians(66.0), math.radians(12.0)])


def test_radii_must_increase():
    with pytest.raises(InputError, match="the radii must increase"):
        Process(layer_thickness=1, step_over=1, radii=(10.0, 10.0))


def test_toml(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text('layer_thickness = 1.4\nstep_over = 3.4\nhatch_angles_deg = [0, 90]\nlast_layer = "drop"\n')
    process = read_process(path, step_over=3.0)
    assert process.step_over == 3.0
    assert process.last_layer is LastLayer.DROP
    assert process.hatch_angles_deg == (0.0, 90.0)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("layer_thickness = 1\nstep_over = 1\nspeed = 3", "speed is no process parameter"),
        ("layer_thickness = 1", "step_over not given"),
        ('layer_thickness = 1\nstep_over = 1\nlast_layer = "x"', "must be one of keep, drop, stretch"),
        ("layer_thickness = ", "not a readable TOML file"),
        ("layer_thickness = 1\nstep_over = 1\ncontours = 1.5", "must be a whole number"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nchord = 1", "chord is no process parameter"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nevery = 2", "a rule changes nothing"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nlayers = 3\ncontours = 1", "layers is 3; give 'a:b'"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nwinds = 3\ncontours = 1", "winds is 3; it must be true or false"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nevery = 0\ncontours = 1", "every is 0"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nnarrower_than = -1\ncontours = 1", "narrower_than is -1"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\npattern = 'x'", "pattern is 'x'"),
        ("layer_thickness = 1\nstep_over = 1\nstarts = 0", "starts is 0; it must be 1 or more"),
        ("layer_thickness = 1\nstep_over = 1\nleft_handed = 1", "left_handed is 1; it must be true or false"),
        ("layer_thickness = 1\nstep_over = 1\nstart_angle_deg = 'x'", "start_angle_deg is 'x'"),
        ("layer_thickness = 1\nstep_over = 1\nstart_angle = 1.0", "start_angle is no process parameter"),
        ("layer_thickness = 1\nstep_over = 1\nrules = 3", "under \\[\\[rules\\]\\]"),
    ],
)
def test_bad_toml_is_one_clear_line(tmp_path, text, said):
    path = tmp_path / "process.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=said) as caught:
        read_process(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_metal_balance_of_the_paper():
    # Table 3: t = 1.4 mm, d = 3.4 mm, 9 mm/s; with 7.99 g/cm**3 and 0.4 g/s of powder the catchment is 0.86
    process = bs.Process(layer_thickness=1.4, step_over=3.4, powder_density_g_cm3=7.99, powder_feed_g_s=0.4)
    assert process.catchment == pytest.approx(1.4 * 3.4 * 9.0 * 7.99e-3 / 0.4)
    assert process.catchment == pytest.approx(0.86, abs=0.005)
    with pytest.raises(bs.InputError, match="times the powder that is fed"):
        bs.Process(layer_thickness=1.4, step_over=3.4, powder_density_g_cm3=7.99, powder_feed_g_s=0.1)
    assert bs.Process(layer_thickness=1.4, step_over=3.4).catchment is None


def test_fit_says_where_the_outermost_bead_runs():
    for fit, inset in ((bs.Fit.IN, 2.45), (bs.Fit.ON, 0.0), (bs.Fit.OUT, -2.45)):
        assert bs.Process(layer_thickness=1.4, step_over=3.4, bead_width=4.9, fit=fit).value("inset") == pytest.approx(inset)


RULES = """
layer_thickness = 2.0
step_over = 3.0
pattern = "hatch"
[[rules]]
layers = "0:4"
every = 2
contours = 1
hatch_angles_deg = [90]
[[rules]]
narrower_than = 12.0
pattern = "skeleton"
"""


def test_a_process_file_reads_back_what_a_report_echoes(tmp_path):
    process = Process(
        layer_thickness=1.0,
        step_over=2.0,
        pattern=InnerPattern.HELIX,
        starts=2,
        start_angle_deg=30.0,
        left_handed=True,
        hatch_angles_deg=(5.0, 10.0),
        rules=(Rule(changes={"pattern": InnerPattern.SPIRAL}, layers=(1, None), winds=False),),
    )
    again = process_from_values({name: value for name, value in process.as_dict().items() if value is not None})
    assert again.as_dict() == process.as_dict()
    assert again.rules == process.rules
    assert again.start_angle_deg == 30.0


def test_rules_hold_where_they_say(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text(RULES)
    process = read_process(path)
    first, second = process.rules
    assert [first.on_layer(i) for i in range(6)] == [True, False, True, False, False, False]
    assert all(second.on_layer(i) for i in range(6))
    assert process.as_dict()["rules"] == [
        {"layers": "0:4", "every": 2, "contours": 1, "hatch_angles_deg": [90.0]},
        {"layers": ":", "every": 1, "narrower_than": 12.0, "pattern": "skeleton"},
    ]


def test_rules_choose_by_layer_and_by_width(tmp_path):
    # two blocks on one shaft: 30 and 10 mm wide
    wide = bd.Solid.make_box(40.0, 30.0, 40.0, bd.Plane((30.0, -15.0, 0.0)))
    narrow = bd.Solid.make_box(40.0, 10.0, 40.0, bd.Plane((30.0, -5.0, 60.0)))
    shaft = bd.Solid.make_cylinder(50.0, 120.0, bd.Plane((0.0, 0.0, -10.0)))
    part = bd.Compound([(shaft + wide + narrow).solids()[0]])
    path = tmp_path / "process.toml"
    path.write_text(RULES)
    made = bs.plan(part, read_process(path), substrate=50.0)
    kinds = [{k: [b for b in fill.beads if b.kind is k] for k in BeadKind} for fill in made.fills]
    # every other of the first four layers: a contour round either block, and hatch across
    for i in (0, 2):
        assert len(kinds[i][BeadKind.CONTOUR]) == 2
        assert not kinds[i][BeadKind.SKELETON]
    for i in (1, 3, 4, 5):
        assert not kinds[i][BeadKind.CONTOUR]
        (piece,) = {bead.piece for bead in kinds[i][BeadKind.SKELETON]}
        assert made.layers[i].region.pieces[piece].bounds()[1] == pytest.approx(60.0)
        assert kinds[i][BeadKind.HATCH]


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"cut_at": "centre"}, "cut_at is 'centre'; it must be one of bottom, middle"),
        ({"pattern": "lines"}, "pattern is 'lines'"),
        ({"contours": 1.5}, "contours is 1.5; it must be a whole number"),
        ({"starts": "2"}, "starts is '2'; it must be a whole number"),
        ({"hatch_angle_step_deg": math.inf}, "hatch_angle_step_deg is inf"),
        ({"chord": 1e-30}, "the finest is 1e-06 mm"),
        ({"inset": -1000.0}, "bead widths outside of the part"),
        ({"radii": 5}, "give a list of increasing radii"),
        ({"bead_width": "4"}, "write the number without quotes"),
    ],
)
def test_values_that_cannot_be_meant(given, said):
    with pytest.raises(InputError, match=said):
        Process(layer_thickness=1.0, step_over=2.0, **given)


def test_choices_are_taken_by_their_names_too():
    process = Process(layer_thickness=1.0, step_over=2.0, cut_at="middle", pattern="helix", fit="out", order="shortest")
    assert process.as_dict()["cut_at"] == "middle"
    assert process.value("inset") == -0.5 * process.width
    assert process.pattern is InnerPattern.HELIX


def test_what_is_assumed_is_finer_for_fine_beads():
    def assumed(d):
        return bs.Process(layer_thickness=0.5 * d, step_over=d).assumed()

    assert [assumed(d)["chord"] for d in (3.4, 1.0, 0.004)] == pytest.approx([0.01, 0.01, 4e-5])
    assert [assumed(d)["clearance"] for d in (3.4, 1.0, 0.004)] == pytest.approx([5.0, 5.0, 5.0])
    assert [assumed(d)["hop_length"] for d in (3.4, 1.0, 0.004)] == pytest.approx([10.2, 3.0, 0.012])
    # an assumed chord can be given, too
    assert bs.Process(layer_thickness=1e-6, step_over=1e-6, chord=assumed(1e-6)["chord"]).chord == pytest.approx(1e-6)
