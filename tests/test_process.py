"""Process parameters: what is refused, what is assumed, what a file may say."""

from __future__ import annotations

import json
import math

import build123d as bd
import pytest

import brep_slicer as bs
from brep_slicer import Fill, Helix, InputError, Layers, Motion, Process, Spiral, read_process
from brep_slicer.fill import BeadKind
from brep_slicer.process import LastLayer, Rule, process_from_values


@pytest.mark.parametrize(
    ("group", "name"),
    [
        (None, "layer_thickness"),
        (None, "step_over"),
        ("fill", "bead_width"),
        ("motion", "chord"),
        ("motion", "deposition_speed_mm_s"),
        ("laser", "power_w"),
        ("powder", "feed_g_s"),
    ],
)
@pytest.mark.parametrize("value", [0.0, -1.0, math.nan, math.inf])
def test_values_out_of_range_are_named(group, name, value):
    given = {name: value} if group is None else {group: {name: value}}
    with pytest.raises(InputError, match=f"(^|{group}: ){name} is "):
        Process(**{"layer_thickness": 1.0, "step_over": 1.0} | given)


def test_assumed_values_are_named_and_given_ones_are_not():
    process = Process(layer_thickness=1.4, step_over=3.4, motion=Motion(deposition_speed_mm_s=12.0))
    assert process.assumed()["fill"]["bead_width"] == pytest.approx(1.44 * 3.4)
    assert "deposition_speed_mm_s" not in process.assumed()["motion"]
    assert process.as_dict()["fill"]["inset"] == pytest.approx(0.72 * 3.4)
    assert process.as_dict()["laser"]["power_w"] is None


def test_radii_must_increase():
    with pytest.raises(InputError, match="the radii must increase"):
        Process(layer_thickness=1, step_over=1, layers=Layers(radii=(10.0, 10.0)))


def test_toml(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text(
        'layer_thickness = 1.4\nstep_over = 3.4\n[layers]\nlast_layer = "drop"\n'
        '[fill]\ncontours = 2\npattern = { name = "hatch", angle_deg = [0, 90], both_ways = false }\n'
    )
    process = read_process(path, step_over=3.0, fill={"pattern": {"angle_deg": 30.0}})
    assert process.step_over == 3.0
    assert process.layers.last_layer is LastLayer.DROP
    assert process.fill.contours == 2
    assert process.fill.pattern == bs.Hatch(angle_deg=30.0, both_ways=False)
    # another pattern does not take over the parameters of the file's
    assert read_process(path, fill={"pattern": {"name": "zigzag"}}).fill.pattern == bs.Zigzag()
    assert read_process(path).fill.pattern == bs.Hatch(angle_deg=(0.0, 90.0), both_ways=False)


HELIX = "layer_thickness = 1\nstep_over = 1\n[fill]\npattern = {name = 'helix', "


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("layer_thickness = 1\nstep_over = 1\nspeed = 3", "speed is no process parameter"),
        ("layer_thickness = 1", "step_over not given"),
        ('layer_thickness = 1\nstep_over = 1\n[layers]\nlast_layer = "x"', "must be one of keep, drop, stretch"),
        ("layer_thickness = ", "not a readable TOML file"),
        ("layer_thickness = 1\nstep_over = 1\n[fill]\ncontours = 1.5", "must be a whole number"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nchord = 1", "chord is no process parameter"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nevery = 2", "a rule changes nothing"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nlayers = 3\ncontours = 1", "layers is 3; give 'a:b'"),
        (
            "layer_thickness = 1\nstep_over = 1\n[[rules]]\nfull_turn = 3\ncontours = 1",
            "full_turn is 3; it must be true or false",
        ),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nevery = 0\ncontours = 1", "every is 0"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nnarrower_than = -1\ncontours = 1", "narrower_than is -1"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\npattern = 'x'", "in a rule: 'x' is no pattern"),
        (HELIX + "starts = 0}", "fill: starts is 0; it must be 1 or more"),
        (HELIX + "left_handed = 1}", "left_handed is 1; it must be true or false"),
        (HELIX + "start_angle_deg = 'x'}", "start_angle_deg is 'x'"),
        (
            HELIX + "start_angle = 1.0}",
            r"start_angle is no .* helix; did you mean start_angle_deg \(in degrees\)",
        ),
        ("layer_thickness = 1\nstep_over = 1\ncontours = 2", r"contours is no .*; it stands in the table \[fill\]"),
        ("layer_thickness = 1\nstep_over = 1\npowder_feed_g_s = 2", r"it is feed_g_s in \[powder\] now"),
        ("layer_thickness = 1\nstep_over = 1\n[fil]\ncontours = 2", "fil is no process parameter; did you mean fill"),
        ("layer_thickness = 1\nstep_over = 1\n[fill]\ncontour = 2", "contour is no .*; did you mean contours"),
        ("layer_thickness = 1\nstep_over = 1\nfill = 2", r"give a table, \[fill\]"),
        ("layer_thickness = 1\nstep_over = 1\n[[rules]]\nhatch_angles_deg = 1", "it is angle_deg of the pattern now"),
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
    process = bs.Process(layer_thickness=1.4, step_over=3.4, powder=bs.Powder(density_g_cm3=7.99, feed_g_s=0.4))
    assert process.catchment == pytest.approx(1.4 * 3.4 * 9.0 * 7.99e-3 / 0.4)
    assert process.catchment == pytest.approx(0.86, abs=0.005)
    with pytest.raises(bs.InputError, match="times the powder that is fed"):
        bs.Process(layer_thickness=1.4, step_over=3.4, powder=bs.Powder(density_g_cm3=7.99, feed_g_s=0.1))
    assert bs.Process(layer_thickness=1.4, step_over=3.4).catchment is None


def test_fit_says_where_the_outermost_bead_runs():
    for place, inset in ((bs.OutlinePosition.IN, 2.45), ("on", 0.0), (bs.OutlinePosition.OUT, -2.45)):
        process = bs.Process(layer_thickness=1.4, step_over=3.4, fill=Fill(bead_width=4.9, outline_position=place))
        assert process.inset == pytest.approx(inset)


RULES = """
layer_thickness = 2.0
step_over = 3.0
[fill]
pattern = "hatch"
[[rules]]
layers = "0:4"
every = 2
contours = 1
pattern = { name = "hatch", angle_deg = 90 }
[[rules]]
narrower_than = 12.0
pattern = "skeleton"
"""


def test_a_process_file_reads_back_what_a_report_echoes(tmp_path):
    process = Process(
        layer_thickness=[1.0, 2.0],
        step_over=2.0,
        layers=Layers(radii=(10.0, 11.0)),
        fill=Fill(pattern=Helix(starts=2, start_angle_deg=30.0, left_handed=True), order="pattern"),
        rules=(Rule(changes={"pattern": Spiral(outwards=True)}, layers=(1, None), full_turn=False),),
    )
    again = process_from_values(json.loads(json.dumps(process.as_dict())))
    assert again.as_dict() == process.as_dict()
    assert again.rules == process.rules
    assert again.fill.pattern == process.fill.pattern


def test_rules_hold_where_they_say(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text(RULES)
    process = read_process(path)
    first, second = process.rules
    assert [first.on_layer(i) for i in range(6)] == [True, False, True, False, False, False]
    assert all(second.on_layer(i) for i in range(6))
    hatch = bs.Hatch(angle_deg=90.0)
    assert process.as_dict()["rules"] == [
        {"layers": "0:4", "every": 2, "contours": 1, "pattern": hatch.as_dict()},
        {"layers": ":", "every": 1, "narrower_than": 12.0, "pattern": {"name": "skeleton"}},
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
        ({"layers": {"cut_at": "centre"}}, "layers: cut_at is 'centre'; it must be one of bottom, middle"),
        ({"layers": {"cut_at": "midle"}}, "did you mean middle"),
        ({"fill": {"pattern": "lines"}}, "fill: 'lines' is no pattern; did you mean rings"),
        ({"fill": {"contours": 1.5}}, "contours is 1.5; it must be a whole number"),
        ({"fill": {"contours": -1}}, "contours is -1; it must be zero or more"),
        ({"fill": {"pattern": {"name": "helix", "starts": "2"}}}, "starts is '2'; it must be a whole number"),
        ({"fill": {"pattern": {"name": "hatch", "angle_step_deg": math.inf}}}, "angle_step_deg is inf"),
        ({"fill": {"pattern": {"name": "hatch", "stretch": 0.5}}}, "it must be zero or more and less than 0.5"),
        ({"fill": {"slowest": 1.5}}, "slowest is 1.5; it must be 0.001 or more and 1 at most"),
        ({"fill": {"fastest": 0.5}}, "fastest is 0.5; it must be 1 or more and 1000 at most"),
        ({"motion": {"chord": 1e-30}}, "chord is 1e-30; it must be 1e-06 or more"),
        ({"motion": {"travel_speed_mm_s": 1e-30}}, "no machine moves like that"),
        ({"fill": {"inset": -1000.0}}, "bead widths outside of the part"),
        ({"layers": {"radii": 5}}, "give a list of increasing radii"),
        ({"fill": {"bead_width": "4"}}, "write the number without quotes"),
    ],
)
def test_values_that_cannot_be_meant(given, said):
    with pytest.raises(InputError, match=said):
        Process(layer_thickness=1.0, step_over=2.0, **given)


def test_choices_are_taken_by_their_names_too():
    fill = Fill(outline_position="out", order="shortest", pattern="helix")
    process = Process(layer_thickness=1.0, step_over=2.0, layers={"cut_at": "middle"}, fill=fill)
    assert process.as_dict()["layers"]["cut_at"] == "middle"
    assert process.inset == -0.5 * process.width
    assert process.fill.pattern == Helix()
    assert process.fill.pattern.as_dict()["name"] == "helix"


def test_a_copy_is_changed_where_it_is_told_to_be():
    process = Process(layer_thickness=1.0, step_over=2.0, fill=Fill(contours=2, pattern="zigzag"), motion=Motion(chord=0.1))
    changed = process.updated(step_over=3.0, fill={"contours": 1})
    assert changed == Process(
        layer_thickness=1.0, step_over=3.0, fill=Fill(contours=1, pattern="zigzag"), motion=Motion(chord=0.1)
    )
    with pytest.raises(InputError, match="it stands in the table"):
        process.updated(contours=1)


def test_what_is_assumed_is_finer_for_fine_beads():
    def assumed(d):
        return bs.Process(layer_thickness=0.5 * d, step_over=d).assumed()

    assert [assumed(d)["motion"]["chord"] for d in (3.4, 1.0, 0.004)] == pytest.approx([0.01, 0.01, 4e-5])
    assert [assumed(d)["motion"]["clearance"] for d in (3.4, 1.0, 0.004)] == pytest.approx([5.0, 5.0, 5.0])
    assert [assumed(d)["motion"]["hop_length"] for d in (3.4, 1.0, 0.004)] == pytest.approx([10.2, 3.0, 0.012])
    # an assumed chord can be given, too
    given = bs.Motion(chord=assumed(1e-6)["motion"]["chord"])
    assert bs.Process(layer_thickness=1e-6, step_over=1e-6, motion=given).chord == pytest.approx(1e-6)


class TestForms:
    """What is made from the declarations: the schema, the file that `init` writes, the reference page."""

    def test_the_reference_page_is_up_to_date(self):
        from brep_slicer.process.reference import reference_page
        from docs.reference import PAGE

        assert PAGE.read_text(encoding="utf-8") == reference_page(), "python -m docs.reference writes it"

    def test_every_parameter_is_in_the_schema_the_file_and_the_page(self):
        from brep_slicer.process import GROUPS
        from brep_slicer.process.parameter import declarations_of
        from brep_slicer.process.reference import reference_page
        from brep_slicer.process.schema import schema_of_process
        from brep_slicer.process.template import process_template

        schema, page = schema_of_process()["properties"], reference_page()
        text = " ".join(process_template(1.4, 3.4, schema="x").replace("\n#", "\n").split())
        count = 0
        for table, group in GROUPS.items():
            for name, one in declarations_of(group).items():
                assert one.help
                assert one.help in schema[table]["properties"][name]["description"]
                assert one.help in page
                assert one.help in text, name
                count += 1
        assert count > 35

    def test_the_file_that_init_writes_is_a_process_as_it_is_and_with_all_that_is_in_it(self, tmp_path):
        import re

        from brep_slicer.process.template import process_template

        path = tmp_path / "process.toml"
        text = process_template(1.2, 3.0, schema="./process.schema.json")
        assert text.startswith("#:schema ./process.schema.json\n")
        path.write_text(text)
        plain = Process(layer_thickness=1.2, step_over=3.0)
        assert read_process(path) == plain
        # every parameter that is switched off there, switched on
        on = re.sub(r"^# (\[\[rules\]\]|\w+ = )", r"\1", text, flags=re.M)
        path.write_text(on)
        given = read_process(path)
        assert len(given.rules) == 1
        assert given.layers.radii == (50.0, 51.4, 52.8)
        # nothing but what has no default is then otherwise than without
        same = given.updated(rules=(), layers={"radii": None}, laser={"power_w": None}, powder=None)
        same = same.updated(fill={"overlap": None}, motion={"contour_speed_mm_s": None})
        assert same.as_dict() == plain.as_dict()

    @pytest.mark.parametrize(
        ("text", "right"),
        [
            ("", True),
            ('[fill]\npattern = "helix"\ncontours = 2', True),
            ('[fill]\npattern = { name = "hatch", angle_deg = [0, 90], both_ways = false }', True),
            ('[fill]\npattern = { name = "hatch", angle_deg = 45 }', True),
            ('[layers]\nlast_layer = "drop"\nradii = [10, 11]', True),
            ('[[rules]]\nlayers = "0:3"\ncontours = 2', True),
            ("contours = 1", False),
            ("[fill]\ncontours = -1", False),
            ("[fill]\ncontours = 1.5", False),
            ('[fill]\npattern = "hutch"', False),
            ('[fill]\npattern = { name = "rings", angle_deg = 45 }', False),
            ('[fill]\npattern = { name = "hatch", stretch = 0.5 }', False),
            ('[layers]\nlast_layer = "eat"', False),
            ("[motion]\ntravel_speed_mm_s = 1e30", False),
            ("[[rules]]\nchord = 2", False),
        ],
    )
    def test_the_schema_says_what_the_reading_says(self, text, right, tmp_path):
        import tomllib

        from brep_slicer.process.schema import schema_of_process

        jsonschema = pytest.importorskip("jsonschema")
        path = tmp_path / "process.toml"
        path.write_text(f"layer_thickness = 1.4\nstep_over = 3.4\n{text}")
        checker = jsonschema.Draft7Validator(schema_of_process())
        assert checker.is_valid(tomllib.loads(path.read_text())) == right
        if right:
            read_process(path)
        else:
            with pytest.raises(InputError):
                read_process(path)
