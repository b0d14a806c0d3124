"""What reaches a user beside the beads: names with their types, in both kinds of install, the version, `python -m`."""

from __future__ import annotations

import ast
import importlib.util
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import brep_slicer as bs

ROOT = Path(__file__).resolve().parent.parent
SCRIPT = ROOT / "tests" / "typing" / "readme_kind.py"


def outside(words, cwd):
    env = os.environ | {"PYTHONPATH": str(ROOT), "MYPYPATH": str(ROOT)}
    return subprocess.run([sys.executable, *map(str, words)], capture_output=True, text=True, cwd=cwd, env=env)


def test_a_script_of_the_readmes_kind_is_clean_to_strict_mypy(tmp_path):
    done = outside(["-m", "mypy", "--strict", "--follow-imports=silent", f"--cache-dir={tmp_path}", SCRIPT], tmp_path)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize(
    "line",
    [
        "bs.Process(layer_thickness=1.4, step_over=3.4, contours=1)",
        "bs.Process(step_over=3.4)",
        "bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(pattern=3))",
        'bs.Hatch(angle_deg="45")',
        "bs.Hatch(angle=0.7)",
        'bs.Process(layer_thickness="1.4", step_over=3.4)',
        "bs.Process(layer_thickness=1.4, step_over=3.4, fill=bs.Fill(outline_position=bs.Order.PATTERN))",
        'bs.Rule(layers=3, changes={"contours": 2})',
        "bs.find_axes",
    ],
)
def test_strict_mypy_sees_what_is_wrong(line, tmp_path):
    (tmp_path / "script.py").write_text(f"import brep_slicer as bs\n\n{line}\n")
    words = ["-m", "mypy", "--strict", "--follow-imports=silent", f"--cache-dir={tmp_path}", "script.py"]
    assert outside(words, tmp_path).returncode == 1


def test_the_script_runs(tmp_path):
    done = outside([SCRIPT, ROOT / "fixtures" / "step" / "spur_gear_tooth.step"], tmp_path)
    assert done.returncode == 0, done.stderr
    assert "there is no such file.step: there is no such file" in done.stdout


def test_type_checkers_and_the_running_module_have_the_same_names():
    tree = ast.parse((ROOT / "brep_slicer" / "__init__.py").read_text())
    (guarded,) = [n for n in tree.body if isinstance(n, ast.If) and ast.unparse(n.test) == "TYPE_CHECKING"]
    names = [alias for n in guarded.body if isinstance(n, ast.ImportFrom) for alias in n.names]
    assert all(alias.asname == alias.name for alias in names), "write `X as X`: without, type checkers take X as private"
    assert sorted(alias.name for alias in names) == bs.__all__
    for name in bs.__all__:
        assert getattr(bs, name) is not None


def test_an_editable_install_is_a_plain_path():
    # setuptools writes an import hook, which type checkers do not follow, unless all packages come from one mapped folder
    setuptools = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    assert setuptools["package-dir"] == {"": "."}
    assert importlib.util.find_spec("brep_slicer").origin == str(ROOT / "brep_slicer" / "__init__.py")


def test_the_version_and_the_command_as_a_module(tmp_path):
    done = outside(["-m", "brep_slicer", "--version"], tmp_path)
    assert done.stdout.split() == ["brep-slicer", bs.__version__]
    assert bs.__version__[0].isdigit()
    assert "__version__" in dir(bs)
    assert outside(["-m", "brep_slicer", "inspect", "gone.step"], tmp_path).returncode == 2
