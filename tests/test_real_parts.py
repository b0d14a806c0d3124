"""`plan` on parts that nobody here made: a row of real_parts.tsv each (they are read where they are, never copied)."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import brep_slicer as bs
from brep_slicer.cli import app

ROWS = list(csv.DictReader((Path(__file__).parent / "real_parts.tsv").open(), delimiter="\t"))
SLOW = {"propeller_3blade_hub_openaxis.step", "pulley_72t_open5x.step", "propeller_6land_D_5axisslicer.step"}


def _row(row):
    return pytest.param(row, id=row["file"], marks=[pytest.mark.slow] if row["file"] in SLOW else [])


@pytest.mark.parametrize("row", [_row(r) for r in ROWS])
def test_plan_runs_through(row, real_step, tmp_path):
    path = real_step(row["file"])
    done = CliRunner().invoke(app, ["plan", str(path), "-o", str(tmp_path), *row["flags"].split()])
    assert done.exit_code == 0, done.output
    report = json.loads((tmp_path / "report.json").read_text())
    origin, direction = (np.array([float(x) for x in half.split(",")]) for half in row["axis"].split(":"))
    assert np.allclose(report["axis"]["origin"], origin, atol=1e-6)
    assert np.allclose(report["axis"]["direction"], direction, atol=1e-9)
    assert report["substrate"]["radius_mm"] == pytest.approx(float(row["substrate_mm"]), abs=1e-3)
    assert report["layer_count"] == int(row["layers"])
    assert report["totals"]["area_mm2"] == pytest.approx(float(row["area_mm2"]), rel=1e-6)
    # the sum of area times thickness is a Riemann sum of the volume outside of R
    assert report["totals"]["volume_mm3"] == pytest.approx(float(row["volume_outside_mm3"]), rel=float(row["bound"]))
    assert {p.name for p in tmp_path.iterdir()} == {
        "report.json", "toolpath.csv", "toolpath.csv-metadata.json", "toolpath.json", "layers.png", "toolpath.png",
    }  # fmt: skip


def test_an_invalid_solid_is_refused_clearly(real_step):
    with pytest.raises(bs.InputError, match="is invalid and cannot be healed; repair it"):
        bs.read_step(real_step("bad_invalid_brep_brepnet.stp"))


AXES = {
    "gear_spur_m5z10_f360.step": "Z",
    "gear_helical_z9_asu.step": "Z",
    "propeller_3blade_hub_openaxis.step": "Y",
    "propeller_6land_D_5axisslicer.step": "X",
    "impeller_radial_turbo3d.step": "Y",
    "shaft_stepped_jack.stp": "Z",
    "auger_corkscrew_bspline_sse.step": "Y",
    "screw_m6_thread_build123d.step": "Z",
    "rotor_16t_shaft_brepnet.stp": "Y",
    "cyl_single_face_sse.step": "Z",
    "cone_cyl_inch_occtimport.step": "0,0,27.5:1,0,0",
    "pulley_72t_open5x.step": "0,2.5,0:0,0,1",
}


@pytest.mark.parametrize(("name", "expected"), AXES.items())
def test_the_axis_of_every_part_is_found(name, expected, real_step):
    axis, known = bs.find_axis(bs.read_step(real_step(name))), bs.axis_from_text(expected)
    assert np.allclose(axis.direction, known.direction, atol=1e-6)
    assert np.linalg.norm(np.cross(axis.direction, axis.origin - known.origin)) < 1e-4
