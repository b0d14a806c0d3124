"""A pattern and a writer of another package, one file each: the guides' own, used from Python, TOML and the command."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.process.schema import schema_of_process

ROOT = Path(__file__).resolve().parent.parent
TOOTH = ROOT / "fixtures" / "step" / "spur_gear_tooth.step"
PATTERN, WRITER = ROOT / "docs" / "add_a_pattern.md", ROOT / "docs" / "add_an_output.md"


def block(guide: Path, language: str, number: int = 0) -> str:
    """A code block of a guide."""
    return re.findall(rf"^```{language}\n(.*?)^```$", guide.read_text(), re.M | re.S)[number]


def install(folder: Path, package: str, guide: Path, name: str) -> None:
    """What a package manager lays down: the guide's file and its entry point, as its own lines for pyproject.toml have it."""
    (folder / f"{name}.py").write_text(block(guide, "python"))
    groups = tomllib.loads(block(guide, "toml"))["project"]["entry-points"]
    info = folder / f"{package}-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.0\n")
    lines = [f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in points.items()) for group, points in groups.items()]
    (info / "entry_points.txt").write_text("\n".join(lines))


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """A folder on the path with both packages."""
    folder = tmp_path / "site"
    folder.mkdir()
    install(folder, "shop_patterns", PATTERN, "waves")
    install(folder, "shop_writers", WRITER, "layer_table")
    monkeypatch.syspath_prepend(str(folder))
    yield folder
    for name in ("waves", "layer_table"):
        sys.modules.pop(name, None)


@dataclass(frozen=True)
class Done:
    """What a command left: its exit code, and what it said."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Runs the command in this process, in a folder of its own."""
    from brep_slicer import cli

    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")

    def command(*words):
        monkeypatch.setattr(sys, "argv", ["brep-slicer", *map(str, words)])
        with pytest.raises(SystemExit) as done:
            cli.main()
        said = capsys.readouterr()
        return Done(done.value.code or 0, said.out, said.err)

    return command


def waves_of(plan, amplitude, length):
    """Whether every bead lies on its own wave v = v0 +- amplitude sin(2 pi kappa / length)."""
    count = 0
    for layer, fill in zip(plan.layers, plan.fills, strict=True):
        sign = 1.0 if layer.index % 2 == 0 else -1.0
        for bead in fill.beads:
            kappa, v = bead.points.T
            base = v - sign * amplitude * np.sin(2.0 * np.pi * kappa / length)
            # cut ends lie on a chord of the wave, the points between on the wave itself
            assert np.ptp(base[1:-1]) < 1e-9
            assert np.ptp(base) < 0.02
            count += 1
    return count


def test_the_guides_are_linked_and_the_pattern_works_in_python(installed):
    import waves

    process = bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(pattern=waves.Waves(amplitude=0.5), balance=False))
    plan = bs.plan(bs.read_step(TOOTH), process, layers="0:3")
    assert waves_of(plan, 0.5, 12.0) > 30
    # the report has its name and all of its parameters, and what it has is a process again
    echoed = plan.report()["process"]
    assert echoed["fill"]["pattern"] == {"name": "waves", "amplitude": 0.5, "length": 12.0}
    assert bs.Process(**echoed).fill.pattern == waves.Waves(amplitude=0.5)
    with pytest.raises(bs.InputError, match="amplitude is -1; it must be zero or more"):
        waves.Waves(amplitude=-1)
    with pytest.raises(bs.InputError, match="amplitud is no parameter of pattern waves; did you mean amplitude"):
        waves.Waves(amplitud=1)


def test_the_writer_works_in_python(installed, tmp_path):
    import layer_table

    plan = bs.plan(bs.read_step(TOOTH), bs.Process(layer_thickness=1.4, step_over=3.4), layers="0:2")
    written = bs.write_plan(plan, tmp_path / "out", write=layer_table.LayerTable())
    assert [path.name for path in written] == ["report.json", "layers.tsv"]
    rows = [line.split("\t") for line in (tmp_path / "out" / "layers.tsv").read_text().splitlines()]
    assert [float(row[1]) for row in rows[1:]] == [layer.radius for layer in plan.layers]
    by_name = bs.write_plan(plan, tmp_path / "named", write="csv,layer_table")
    assert [path.name for path in by_name] == ["report.json", "toolpath.csv", "toolpath.csv-metadata.json", "layers.tsv"]
    with pytest.raises(bs.InputError, match="'layer_tabel' is no writer; did you mean layer_table"):
        bs.write_plan(plan, tmp_path / "named", write="layer_tabel")


def test_both_work_by_their_names_at_the_command_and_in_a_file(installed, run, tmp_path):
    words = ["plan", TOOTH, "-t", 1.4, "-d", 3.4, "--no-balance", "--layers", "0:3", "--write", "json,layer_table"]
    done = run(*words, "--pattern", "waves:amplitude=0.5", "-o", "a")
    assert done.returncode == 0, done.stderr
    assert {path.name for path in (tmp_path / "a").iterdir()} == {"report.json", "toolpath.json", "layers.tsv"}
    (tmp_path / "process.toml").write_text(block(PATTERN, "toml", 1).replace("[fill]", "[fill]\nbalance = false"))
    words = ["plan", TOOTH, "--process", "process.toml", "--layers", "0:3", "--write", "json", "-o", "b"]
    done = run(*words)
    assert done.returncode == 0, done.stderr
    assert bs.read_toolpath(tmp_path / "a" / "toolpath.json") == bs.read_toolpath(tmp_path / "b" / "toolpath.json")
    for words, said in (
        (["--pattern", "wave"], "'wave' is no pattern; did you mean waves?"),
        (["--pattern", "waves:amplitude=-1"], "amplitude is -1; it must be zero or more"),
        (["--write", "layer_tables"], "'layer_tables' is no writer; did you mean layer_table?"),
    ):
        done = run("plan", TOOTH, "-t", 1.4, "-d", 3.4, *words)
        assert done.returncode == 2
        assert said in done.stderr
        assert len(done.stderr.strip().splitlines()) == 1


def test_both_are_in_the_help_and_the_pattern_is_in_the_schema(installed, run, tmp_path):
    said = " ".join(run("plan", "--help").stdout.split())
    assert "waves beads in waves along the circumference" in said
    assert "amplitude: How far a bead swings to either side (mm, zero or more, default 1)" in said
    assert "layer_table layers.tsv: a row a layer" in said
    done = run("init", "shop.toml")
    assert done.returncode == 0, done.stderr
    schema = json.loads((tmp_path / "shop.schema.json").read_text())
    assert schema == schema_of_process()
    (table,) = [
        one for one in schema["properties"]["fill"]["properties"]["pattern"]["anyOf"] if "waves" in str(one.get("properties"))
    ]
    assert table["properties"]["amplitude"]["minimum"] == 0.0
    assert table["properties"]["length"]["exclusiveMinimum"] == 0.0
    assert 'pattern = { name = "waves", amplitude = 1.0, length = 12.0 }' in (tmp_path / "shop.toml").read_text()


def test_entry_points_are_looked_for_only_where_a_name_needs_them(installed, monkeypatch):
    from importlib import metadata

    from brep_slicer.output.write import writers_of

    asked = []
    real = metadata.entry_points
    monkeypatch.setattr(metadata, "entry_points", lambda **group: asked.append(group["group"]) or real(**group))
    bs.Process(layer_thickness=1, step_over=1, fill=bs.Fill(pattern="helix"))
    assert len(writers_of("csv,dxf")) == 3
    assert len(writers_of(None)) == 4
    assert asked == []
    bs.Fill(pattern="waves")
    writers_of("layer_table")
    assert asked == ["brep_slicer.patterns", "brep_slicer.writers"]


def broken(folder: Path, text: str) -> None:
    (folder / "waves.py").write_text(text)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import there_is_no_such_module\n", "of package shop_patterns cannot be loaded (ModuleNotFoundError"),
        ("Waves = 3\n", "is no subclass of brep_slicer.Pattern"),
        ("from brep_slicer import Hatch as Waves\n", "calls itself 'hatch'"),
    ],
)
def test_a_broken_package_is_named(installed, run, text, said):
    broken(installed, text)
    done = run("plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "waves")
    assert done.returncode == 2
    assert said in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    # who does not name it does not notice
    assert run("plan", "gone.step", "-t", 1, "-d", 1).stderr.count("gone.step") == 1


def test_a_name_that_two_packages_have_is_refused_and_ours_come_first(installed, run, monkeypatch):
    (installed / "other").mkdir()
    install(installed / "other", "rival", PATTERN, "waves")
    monkeypatch.syspath_prepend(str(installed / "other"))
    done = run("plan", TOOTH, "-t", 1, "-d", 1, "--pattern", "waves")
    assert "pattern 'waves' is in several packages, rival, shop_patterns; remove all but one" in done.stderr
    (installed / "shop_patterns-1.0.dist-info" / "entry_points.txt").write_text("[brep_slicer.patterns]\nhatch = waves:Waves\n")
    assert bs.Fill(pattern="hatch").pattern == bs.Hatch()


def test_the_guides_files_are_clean_to_strict_mypy(installed, tmp_path):
    env = os.environ | {"PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}
    words = [sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports", "--follow-imports=silent"]
    words += [f"--cache-dir={tmp_path}"]
    files = [str(installed / "waves.py"), str(installed / "layer_table.py")]
    done = subprocess.run([*words, *files], capture_output=True, text=True, env=env, cwd=tmp_path)
    assert done.returncode == 0, done.stdout


def test_init_writes_over_nothing_unless_told_to(run, tmp_path):
    assert run("init", "process.toml", "-t", 1.2, "-d", 3).returncode == 0
    assert bs.read_process(tmp_path / "process.toml") == bs.Process(layer_thickness=1.2, step_over=3.0)
    before = (tmp_path / "process.toml").read_bytes()
    done = run("init", "process.toml")
    assert done.returncode == 2
    assert "process.toml: this file is there already; --force writes over it" in done.stderr
    assert (tmp_path / "process.toml").read_bytes() == before
    assert run("init", "process.toml", "--force").returncode == 0
    assert bs.read_process(tmp_path / "process.toml").layer_thickness == 1.4
    # what it wrote is planned as it is
    done = run("plan", TOOTH, "--process", "process.toml", "--layers", "0:1", "--write", "csv", "-o", "out")
    assert done.returncode == 0, done.stderr
    assert run("init", "other.toml", "-t", -1).returncode == 2
    assert not (tmp_path / "other.toml").exists()
