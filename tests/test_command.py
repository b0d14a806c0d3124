"""The command and its files: exit codes, one line for every error, nothing half written, everything read back."""

from __future__ import annotations

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import brep_slicer as bs

ROOT = Path(__file__).resolve().parent.parent
TOOTH = ROOT / "fixtures" / "step" / "spur_gear_tooth.step"
FILES = {"report.json", "toolpath.csv", "toolpath.csv-metadata.json", "toolpath.json", "layers.png", "toolpath.png"}


def run(*words, cwd=ROOT):
    env = os.environ | {"PYTHONPATH": str(ROOT)}
    return subprocess.run(
        [sys.executable, "-m", "brep_slicer.cli", *map(str, words)], capture_output=True, text=True, cwd=cwd, env=env
    )


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    out = tmp_path_factory.mktemp("plan")
    done = run(
        "plan",
        TOOTH,
        "-t",
        1.4,
        "-d",
        3.4,
        "-o",
        out,
        "--layers",
        "0:3",
        "--contours",
        1,
        "--angle",
        0,
        "--angle",
        45,
        "--write",
        "+step,dxf",
    )
    assert done.returncode == 0, done.stderr
    return out, done


def test_all_files_are_written(planned):
    out, done = planned
    assert {p.name for p in out.iterdir()} == FILES | {"beads.step", "layers.dxf"}
    assert "3 layers on R 150 mm, numbers 0 to 2 at R 150 to 152.8 mm" in done.stdout
    assert "3 by analytic" in done.stdout


def test_lengths_and_times_are_said_in_units_of_their_size():
    from brep_slicer.wording import in_words_of_length, in_words_of_time

    assert [in_words_of_length(mm) for mm in (0.0, 2.08, 999.0, 5812.4, 2.5e6)] == [
        "0 mm",
        "2.08 mm",
        "999 mm",
        "5.812 m",
        "2.5 km",
    ]
    assert [in_words_of_time(s) for s in (0.231, 119.0, 645.6, 36000.0)] == ["0.231 s", "119 s", "10.76 min", "10 h"]


def test_the_report_says_what_was_done(planned):
    report = json.loads((planned[0] / "report.json").read_text())
    assert report["process"]["fill"]["contours"] == 1
    assert report["assumed"]["motion"]["deposition_speed_mm_s"] == 9.0
    assert "contours" not in report["assumed"]["fill"]
    assert report["totals"]["powder_mass_g"] is None
    assert report["process"]["laser"]["power_w"] is None
    assert [la["layer"] for la in report["layers"]] == [0, 1, 2]
    assert {la["engine"] for la in report["layers"]} == {"analytic"}
    assert report["layers"][1]["hatch_angle_deg"] == pytest.approx([45.0])


def test_csv_json_and_the_toolpath_are_the_same(planned):
    path = bs.read_toolpath(planned[0] / "toolpath.json")
    with (planned[0] / "toolpath.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(path)
    names = "layer,bead,kind,x,y,z,nx,ny,nz,kappa,v,radius,speed"
    assert ",".join(rows[0]) == names
    for name, column in (("x", path.points[:, 0]), ("nz", path.normals[:, 2]), ("kappa", path.kappa), ("speed", path.speed)):
        assert np.array_equal([float(r[name]) for r in rows], column)
    assert {r["kind"] for r in rows} == {"deposit", "travel"}
    again = bs.plan(
        bs.read_step(TOOTH),
        bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(contours=1, pattern=bs.Automatic(angle_deg=(0.0, 45.0)))),
        layers=(0, 3),
    )
    assert again.toolpath == path


def test_every_output_says_with_what_it_was_made(planned):
    from PIL import Image

    out = planned[0]
    for name in ("report.json", "toolpath.json"):
        data = json.loads((out / name).read_text())
        assert data["process"]["step_over"] == 3.4
        assert data["brep_slicer"]
    assert json.loads((out / "toolpath.csv-metadata.json").read_text())["notes"][0]["process"]["step_over"] == 3.4
    for name in ("layers.png", "toolpath.png"):
        assert json.loads(Image.open(out / name).text["Description"])["process"]["step_over"] == 3.4


def test_the_beads_come_back_from_step_and_dxf(planned):
    import ezdxf

    text = (planned[0] / "beads.step").read_text()
    assert text.count("TRIMMED_CURVE(") > 10
    assert '"step_over": 3.4' in text.replace("\n", "")
    drawing = ezdxf.readfile(planned[0] / "layers.dxf")
    report = json.loads((planned[0] / "report.json").read_text())
    assert json.loads(dict(drawing.header.custom_vars.properties)["brep_slicer"])["process"]["step_over"] == 3.4
    assert len(drawing.modelspace().query("LWPOLYLINE[layer=='BEADS-0000']")) == report["layers"][0]["beads"]


BAD = {
    "no such file": (["plan", "none.step", "-t", 1, "-d", 1], 2, "none.step: there is no such file"),
    "no thickness": (["plan", TOOTH, "-d", 1], 2, "give -t and -d"),
    "zero": (["plan", TOOTH, "-t", 0, "-d", 1], 2, "layer_thickness is 0; it must be greater than zero"),
    "negative": (["plan", TOOTH, "-t", 1, "-d", -3], 2, "step_over is -3"),
    "not a number": (["plan", TOOTH, "-t", "nan", "-d", 1], 2, "must be a finite number"),
    "thicker than the part": (["plan", TOOTH, "-t", 90, "-d", 1], 2, "larger than the whole height"),
    "wider than the part": (["plan", TOOTH, "-t", 1, "-d", 900], 2, "step-over 900 mm is larger than the part"),
    "far too fine": (["plan", TOOTH, "-t", 1.4, "-d", 1e-5], 2, "--yes plans it all the same"),
    "no axis like that": (["plan", TOOTH, "-t", 1, "-d", 1, "--axis", "Q"], 2, "axis 'Q' is not understood"),
    "substrate outside": (["plan", TOOTH, "-t", 1, "-d", 1, "--substrate", 500], 2, "leaves nothing to build"),
    "substrate too small": (
        ["plan", TOOTH, "-t", 1, "-d", 1, "--substrate", 1e-300],
        2,
        "the substrate radius 1e-300 mm is too small",
    ),
    "too slow": (["plan", TOOTH, "-t", 1, "-d", 1, "--speed", 1e-320], 2, "no machine moves like that"),
    "no such solid": (["plan", TOOTH, "-t", 1, "-d", 1, "--solid", "x"], 2, "there is no solid 'x'"),
    "no such layers": (["plan", TOOTH, "-t", 1.4, "-d", 1, "--layers", "99:"], 2, "give a:b within 0:31"),
    "layers in words": (["plan", TOOTH, "-t", 1.4, "-d", 1, "--layers", "all"], 2, "give 'a:b'"),
    "last layer": (["plan", TOOTH, "-t", 1.4, "-d", 1, "--last-layer", "eat"], 2, "keep, drop, stretch"),
    "engine": (["plan", TOOTH, "-t", 1.4, "-d", 1, "--engine", "steam"], 2, "analytic, boolean"),
    "no bead fits": (["plan", TOOTH, "-t", 1.4, "-d", 80, "--layers", "0:1"], 3, "no bead fits into any layer"),
    "nothing beyond": (["plan", ROOT / "fixtures/step/cylinder.step", "-t", 1, "-d", 1], 3, "--substrate RADIUS"),
    "nothing to view": (["view", ROOT / "tests"], 2, "run brep-slicer plan first"),
    "layers the wrong way round": (["plan", TOOTH, "-t", 1.4, "-d", 1, "--layers", "5:2"], 2, "a less than b"),
    "usage": (["plan"], 2, "Missing argument"),
    "no such option": (["plan", TOOTH, "--thickness", 1], 2, "No such option: --thickness"),
    "a number in words": (["plan", TOOTH, "-t", "abc", "-d", 1], 2, "Invalid value for '-t'"),
    "no such pattern": (
        ["plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "hutch"],
        2,
        "'hutch' is no pattern; did you mean hatch?",
    ),
    "no such parameter": (
        ["plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "helix:start=2"],
        2,
        "start is no parameter of pattern helix; did you mean starts?",
    ),
    "a parameter of another pattern": (
        ["plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "rings", "--angle", 3],
        2,
        "pattern rings",
    ),
    "a pattern's words": (["plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "helix:starts"], 2, "as helix:starts=2"),
    "no such writer": (["plan", TOOTH, "-t", 1, "-d", 1, "--write", "csv,dfx"], 2, "'dfx' is no writer; did you mean dxf?"),
    "no such command": (["slice"], 2, "No such command 'slice'"),
}


@pytest.mark.parametrize(("words", "code", "said"), BAD.values(), ids=BAD)
def test_bad_input_is_one_clear_line(words, code, said, tmp_path):
    out = tmp_path / "out"
    done = run(*words, *(["-o", out] if words[0] == "plan" and len(words) > 1 else []))
    assert done.returncode == code, done.stderr
    assert said in done.stderr
    assert "Traceback" not in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert not out.exists() or not any(out.iterdir())


def nan_step(path):
    path.write_text((ROOT / "fixtures/step/box_on_shaft.step").read_text().replace("50.", "NAN", 3))


def marked_step(path):
    path.write_bytes(b"\xef\xbb\xbf" + TOOTH.read_bytes())


def nested_toml(path):
    path.write_text("layer_thickness = " + "[" * 2000 + "]" * 2000)


FILES_GIVEN = {
    "no numbers": (["inspect"], "part.step", nan_step, "solid 'SOLID' is broken: the CAD kernel fails on it"),
    "byte-order mark": (["inspect"], "part.step", marked_step, "begins with a byte-order mark"),
    "nested lists": (["plan", TOOTH, "--process"], "deep.toml", nested_toml, "nested too deeply"),
}


@pytest.mark.parametrize(("words", "name", "write", "said"), FILES_GIVEN.values(), ids=FILES_GIVEN)
def test_bad_files_are_one_clear_line(words, name, write, said, tmp_path):
    write(tmp_path / name)
    done = run(*words, tmp_path / name)
    assert done.returncode == 2, done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert f"{name}: " in done.stderr
    assert said in done.stderr


def test_a_solid_that_is_chosen_twice_is_one():
    part = bs.read_step(TOOTH, solids=[0, "0"])
    assert [s.index for s in part.solids] == [0]
    assert part.others == ()


def test_an_output_folder_that_is_a_file(tmp_path):
    (tmp_path / "out").write_text("here first")
    done = run("plan", TOOTH, "-t", 1.4, "-d", 3.4, "-o", tmp_path / "out")
    assert done.returncode == 2
    assert "this is a file; give a folder" in done.stderr
    assert (tmp_path / "out").read_text() == "here first"


def test_inspect_for_people_and_for_programs():
    done = run("inspect", TOOTH)
    assert done.returncode == 0
    assert "substrate: R 150 mm" in done.stdout
    data = json.loads(run("inspect", TOOTH, "--json").stdout)
    assert data["substrate_radius_mm"] == pytest.approx(150.0)
    assert data["axis"]["direction"] == [0.0, 0.0, 1.0]
    assert data["overhang_share"] == 0.0
    blade = json.loads(run("inspect", ROOT / "fixtures/step/wind_blade.step", "--axis", "Z", "--json").stdout)
    assert blade["overhang_share"] > 0.05


def test_view_names_the_pictures(planned):
    done = run("view", planned[0])
    assert done.stdout.split() == [str(planned[0] / "layers.png"), str(planned[0] / "toolpath.png")]


def test_help_is_there():
    for words in (["--help"], ["plan", "--help"], ["inspect", "--help"], ["view", "--help"], ["--version"]):
        done = run(*words)
        assert done.returncode == 0
        assert done.stdout


@pytest.fixture
def broken_at(monkeypatch):
    """Makes both engines fail at the given radii (None: at all)."""
    from brep_slicer.errors import LayerError
    from brep_slicer.section import engines

    real = engines.sections_by_analysis

    def no_second_opinion(*args, **kwargs):
        raise LayerError("neither can this one")

    def break_at(*bad):
        def broken(solid, radii):
            near = [any(abs(r - b) < 0.1 for b in bad) for r in radii]
            return [LayerError("made to fail") if n else f for n, f in zip(near, real(solid, radii), strict=True)]

        monkeypatch.setattr(engines, "sections_by_analysis", broken)
        monkeypatch.setattr(engines, "section_by_boolean", no_second_opinion)

    return break_at


PROCESS = bs.Process(layer_thickness=1.4, step_over=3.4)


def test_a_failed_layer_raises_before_anything_is_filled(broken_at, monkeypatch):
    from brep_slicer.errors import LayerError
    from brep_slicer.planning import planner

    broken_at(151.4, 154.2)
    monkeypatch.setattr(planner, "fill_layer", lambda *args, **kwargs: pytest.fail("a layer was filled"))
    with pytest.raises(LayerError, match=r"2 of 5 layers failed, first layer 1 .*then 3 .*--allow-failed") as caught:
        bs.plan(bs.read_step(TOOTH), PROCESS, layers=(0, 5))
    assert caught.value.exit_code == 4
    assert [(layer.index, layer.failed) for layer in caught.value.failed] == [(1, True), (3, True)]
    assert "\n" not in str(caught.value)


def test_a_failed_layer_writes_the_report_alone(tmp_path, broken_at):
    from brep_slicer.errors import LayerError
    from brep_slicer.output.write import write_plan

    broken_at(151.4)
    plan = bs.plan(bs.read_step(TOOTH), PROCESS, layers=(0, 3), allow_failed=True)
    # no mixture of types: whatever is said of all layers holds
    assert [layer.index for layer in plan.layers] == [0, 2]
    assert all(layer.area > 0.0 for layer in plan.layers)
    assert len(plan.fills) == 2
    assert [layer.index for layer in plan.failed] == [1]
    with pytest.raises(LayerError, match="1 of 3 layers failed"):
        write_plan(plan, tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["report.json"]
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["failed_layers"] == 1
    assert [row["layer"] for row in report["layers"]] == [0, 1, 2]
    assert "area_mm2" not in report["layers"][1]
    assert len(write_plan(plan, tmp_path / "anyway", allow_failed=True)) == len(FILES)


def test_the_command_writes_the_report_alone_and_says_which_layers_failed(tmp_path, broken_at, monkeypatch, capsys):
    from brep_slicer import cli

    broken_at(151.4, 152.8)
    words = ["brep-slicer", "plan", str(TOOTH), "-t", "1.4", "-d", "3.4", "--layers", "0:4", "-o", str(tmp_path / "out")]
    for more, code, files in (([], 4, 1), (["--allow-failed"], 0, len(FILES))):
        monkeypatch.setattr(sys, "argv", [*words, *more])
        with pytest.raises(SystemExit) as done:
            cli.main()
        said = capsys.readouterr()
        assert done.value.code == code
        assert len(list((tmp_path / "out").iterdir())) == files
        # the layers, by number and reason, in one line
        assert "warning: layers 1 to 2: failed (R 151.4 to 152.8 mm): " in said.err
        report = json.loads((tmp_path / "out" / "report.json").read_text())
        assert [row["failed"] for row in report["layers"]] == [False, True, True, False]
        assert ("beads" in report["layers"][0]) == (code == 0)
    assert said.out.startswith("roles: ")
    assert "\nsections: 2 by analytic, 2 failed" in said.out


def test_a_failed_sliver_of_a_last_layer_names_its_remedy(monkeypatch):
    from brep_slicer.errors import LayerError
    from brep_slicer.section import engines

    def no_second_opinion(*args, **kwargs):
        raise LayerError("neither can this one")

    # the tooth is 43.4 mm high: of 31 layers of 1.4 mm the last is whole, of 28 of 1.6 mm an eighth of one
    monkeypatch.setattr(engines, "sections_by_analysis", lambda solid, radii: [LayerError("made to fail")] * len(radii))
    monkeypatch.setattr(engines, "section_by_boolean", no_second_opinion)
    for thickness, last, remedy in ((1.4, 30, "--allow-failed plans"), (1.6, 27, "--last-layer drop")):
        process = bs.Process(layer_thickness=thickness, step_over=3.4)
        with pytest.raises(LayerError, match=remedy):
            bs.plan(bs.read_step(TOOTH), process, layers=(last, last + 1))


def test_a_fallback_is_said(monkeypatch):
    from brep_slicer.errors import LayerError
    from brep_slicer.section import engines

    monkeypatch.setattr(engines, "sections_by_analysis", lambda solid, radii: [LayerError("made to fail")] * len(radii))
    (layer,) = bs.slice_part(bs.read_step(TOOTH), [170.0])
    assert layer.certificate.engine is bs.Engine.BOOLEAN
    assert layer.certificate.fallback == "made to fail"


def test_the_help_has_an_example_groups_patterns_writers_and_every_parameter():
    from brep_slicer.output.writers import WRITERS
    from brep_slicer.process import GROUPS, PATTERNS
    from brep_slicer.process.parameter import declarations_of, option_names

    env = os.environ | {"PYTHONPATH": str(ROOT), "COLUMNS": "250"}
    words = [sys.executable, "-m", "brep_slicer", "plan", "--help"]
    said = subprocess.run(words, capture_output=True, text=True, env=env).stdout
    assert "brep-slicer plan gear.step -t 1.4 -d 3.4" in said
    for group in ("What is written", "Part: what is built, on what", "How it is computed", "Patterns' parameters"):
        assert f"─ {group} ─" in said
    for group in GROUPS.values():
        assert f"─ {group.title} ─" in said
    for kind in (*PATTERNS.all().values(), *WRITERS.all().values()):
        assert kind.help in said, kind
    kinds = [bs.Process, *GROUPS.values(), *PATTERNS.all().values()]
    declared = [(name, one) for kind in kinds for name, one in declarations_of(kind).items()]
    assert len(declared) > 50
    for name, one in declared:
        assert all(option in said for names in option_names(name, one) for option in names.split("/")), name
        assert one.help in " ".join(said.split()) or name == "pattern", name


def test_the_example_of_the_help_works(tmp_path):
    from brep_slicer.cli.help import plan_help

    (line,) = [line.strip() for line in plan_help().splitlines() if line.strip().startswith("brep-slicer plan gear.step")]
    words = [str(TOOTH) if word == "gear.step" else word for word in line.split()[1:]]
    done = run(*words, "--layers", "0:2", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out" / "toolpath.csv").exists()


def test_the_summary_has_a_line_a_layer(planned):
    rows = [line.split() for line in planned[1].stdout.splitlines()]
    head = next(i for i, row in enumerate(rows) if row[:2] == ["layer", "R"])
    report = json.loads((planned[0] / "report.json").read_text())
    for row, layer in zip(rows[head + 1 : head + 4], report["layers"], strict=True):
        assert [int(row[0]), float(row[1]), int(row[3])] == [layer["layer"], layer["radius_mm"], layer["beads"]]
        # metal: step-over times thickness along the beads, 1.4 x 3.4 mm here
        laid = 1.4 * 3.4 * layer["deposition_length_mm"]
        assert float(row[4]) == pytest.approx(laid / 1000.0, rel=1e-3)
        assert int(row[5]) == pytest.approx(100.0 * laid / (1.4 * layer["area_mm2"]), abs=0.51)
    assert "catchment not known" in planned[1].stdout


def test_long_tables_are_cut_in_the_middle():
    from brep_slicer.cli.summary import MOST_ROWS, table_of_layers

    row = {"failed": False, "radius_mm": 10.0, "thickness_mm": 1.0, "area_mm2": 50.0, "beads": 3}
    row |= {"deposition_length_mm": 50.0, "travel_length_mm": 1.0, "deposition_time_s": 100.0, "travel_time_s": 80.0}
    for count in (1, MOST_ROWS, MOST_ROWS + 1, 200):
        lines = table_of_layers([row | {"layer": i} for i in range(count)], 1.0)
        assert len(lines) == 1 + min(count, MOST_ROWS + 1)
        assert all(len(line) <= 80 for line in lines)
        assert lines[-1].split() == [str(count - 1), "10", "50", "3", "0.05", "100", "%", "3", "min"]
        assert (f"{count - MOST_ROWS} layer" in "".join(lines)) == (count > MOST_ROWS)


def test_the_catchment_is_said_where_it_is_known(tmp_path):
    path = tmp_path / "process.toml"
    path.write_text("layer_thickness = 1.4\nstep_over = 3.4\n[powder]\ndensity_g_cm3 = 7.99\nfeed_g_s = 0.4\n")
    done = run("plan", TOOTH, "--process", path, "--layers", "0:1", "-o", tmp_path / "out")
    # eta = t d speed density / feed
    assert f"catchment {100 * 1.4 * 3.4 * 9.0 * 7.99e-3 / 0.4:.3g} %" in done.stdout
