"""Large parts and large plans, each against a base in the same run: pytest tests/benchmarks -m benchmark -n 0 -s.

Seconds are of the processor, each in a process of its own.
"""

from __future__ import annotations

import os
import sys

import pytest

from .test_pictures_and_proofs import BASE, REAL, long_shaft, run, spent

pytestmark = pytest.mark.benchmark

# Sections alone, beads and toolpath on top of them, then the files; megabytes at most after each.
STAGES = """
import pathlib, resource, tempfile
import brep_slicer as bs
from brep_slicer.output.write import write_plan
from brep_slicer.planning import fill_layers
from brep_slicer.planning.estimate import estimate_of
from brep_slicer.planning.sections import cut_layers

def peak():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3

part = bs.read_step({path!r})
begun = time.process_time()
sections = cut_layers(part, bs.Process(**{process!r}))
cut = time.process_time()
estimate = estimate_of(sections)
plan = fill_layers(sections)
filled = time.process_time()
before = peak()
with tempfile.TemporaryDirectory() as folder:
    write_plan(plan, folder, allow_failed=True, write={write!r})
    size = sum(file.stat().st_size for file in pathlib.Path(folder).iterdir()) / 1e6
print(json.dumps({{
    "layers": len(plan.layers), "beads": sum(len(fill.beads) for fill in plan.fills), "points": len(plan.toolpath),
    "sections": cut - begun, "fill": filled - cut, "files": time.process_time() - filled, "all": time.process_time(),
    "MB before files": before, "MB": peak(), "MB of files": size,
    "estimated": [estimate.beads, estimate.points, estimate.seconds, estimate.file_mb, estimate.memory_mb],
}}))
"""
TRAVEL = """
import brep_slicer as bs
part = bs.read_step({path!r})
found = {{}}
for order in ("shortest", "pattern"):
    process = bs.Process(layer_thickness={thickness!r}, step_over={step_over!r}, fill={{"order": order}})
    plan = bs.plan(part, process, allow_failed=True)
    lengths, on = plan.toolpath.segment_lengths(), plan.toolpath.deposits
    found[order], found["laid"] = float(lengths[~on].sum()), float(lengths[on].sum())
print(json.dumps(found))
"""


def real(name):
    path = REAL / name
    if not path.exists():
        pytest.skip(f"{path} is not there")
    return str(path)


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the processor's time of a process is asked of Unix")
@pytest.mark.parametrize("name", ["shaft of 1,000 faces", "gear_spur_m5z10_f360.step", "propeller_6land_D_5axisslicer.step"])
def test_inspecting_against_importing_and_reading(name, tmp_path, capsys):
    path = long_shaft(tmp_path) if name.startswith("shaft") else real(name)
    environment = dict(os.environ)
    base, command = [sys.executable, "-c", BASE, path], [sys.executable, "-m", "brep_slicer", "inspect", path]
    runs = sorted((spent(command, environment)[0], spent(base, environment)[0]) for _ in range(3))
    seconds, whole = runs[1]
    with capsys.disabled():
        print(f"\ninspect {name}: {seconds:.2f} s, {seconds / whole:.2f} times importing and reading ({whole:.2f} s)")
    assert seconds > 0.0


@pytest.mark.parametrize("pictures", [False, True], ids=["without pictures", "with pictures"])
def test_a_propeller_of_200_layers_against_its_sections(pictures, capsys):
    path = real("propeller_3blade_hub_openaxis.step")
    found = run(STAGES, path=path, process={"layer_thickness": 1.0, "step_over": 1.0}, write=None if pictures else "csv,json")
    report(capsys, "propeller_3blade_hub", found)


def test_a_large_plan_of_a_shaft_against_its_sections(tmp_path, capsys):
    # splines filled at a third of a millimetre: what is written is streamed, and takes no memory of its own
    found = run(STAGES, path=long_shaft(tmp_path), process={"layer_thickness": 1.0, "step_over": 0.35}, write="csv,json")
    report(capsys, "shaft of 1,000 faces", found)


def report(capsys, name, found):
    beads, points, seconds, file_mb, memory_mb = found["estimated"]
    with capsys.disabled():
        print(f"\n{name}: {found['layers']} layers, {found['beads']} beads, {found['points']} points in {found['all']:.1f} s")
        for key in ("fill", "files"):
            times = found[key] / found["sections"]
            print(f"  {key} {found[key]:.1f} s, {times:.2f} times the sections ({found['sections']:.1f} s)")
        more = found["MB"] - found["MB before files"]
        print(f"  {found['MB']:.0f} MB at most; files of {found['MB of files']:.0f} MB take {more:.0f} MB more than the plan")
        shares = beads / found["beads"], points / found["points"], seconds / found["all"]
        print("  estimated / true: beads {:.2f}, points {:.2f}, seconds {:.2f}".format(*shares), end="")
        print(f", files {file_mb / found['MB of files']:.2f}, memory {memory_mb / found['MB']:.2f}")
    assert found["beads"]


@pytest.mark.parametrize(
    ("name", "thickness", "step_over"),
    [
        ("impeller_radial_turbo3d.step", 2.0, 2.0),
        ("gear_spur_m5z10_f360.step", 1.0, 1.0),
        ("propeller_6land_D_5axisslicer.step", 1.0, 1.0),
    ],
)
def test_travel_in_short_order_against_the_patterns_own(name, thickness, step_over, capsys):
    found = run(TRAVEL, path=real(name), thickness=thickness, step_over=step_over)
    with capsys.disabled():
        print(
            f"\n{name}: {found['shortest'] / 1e3:.1f} m of travel for {found['laid'] / 1e3:.1f} m of bead,"
            f" {found['shortest'] / found['pattern']:.2f} times that in the pattern's order"
        )
    assert found["shortest"] <= 1.001 * found["pattern"]
