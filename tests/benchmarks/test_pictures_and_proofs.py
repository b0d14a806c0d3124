"""Pictures against importing and reading, proofs against their plans: pytest tests/benchmarks -m benchmark -n 0 -s.

Seconds are of the processor, each in a process of its own; ratios are medians of runs that take turns.
"""

from __future__ import annotations

import json
import math
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.benchmark
REAL = Path(__file__).resolve().parents[3] / "shared" / "step"
RUNS = 5
BASE = """
import OCP, numpy, scipy, shapely, matplotlib
from OCP.STEPControl import STEPControl_Reader
reader = STEPControl_Reader()
reader.ReadFile({path!r})
reader.TransferRoots()
reader.OneShape()
print(json.dumps({{"base": time.process_time()}}))
"""
PICTURES = """
import brep_slicer as bs
plan = bs.plan(bs.read_step({path!r}), bs.Process(layer_thickness=1.4, step_over=3.4))
start = time.process_time()
from brep_slicer.output.pictures import draw_layers, draw_toolpath
begun = time.process_time()
draw_layers(plan, {folder!r} + "/layers.png")
middle = time.process_time()
draw_toolpath(plan, {folder!r} + "/toolpath.png")
end = time.process_time()
print(json.dumps({{"pictures": end - start, "layers.png": middle - begun, "toolpath.png": end - middle}}))
"""
COMMAND = """
import sys
from brep_slicer.__main__ import main
sys.argv = ["brep-slicer", "plan", {path!r}, "-t", "1.4", "-d", "3.4", "-o", {folder!r}, "--yes"]
try:
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        main()
except SystemExit:
    pass
print(json.dumps({{"command": time.process_time()}}))
"""
PROOF = """
import resource
import brep_slicer as bs
part = bs.read_step({path!r})
plan = bs.plan(part, bs.Process(**{process!r}), **{more!r})
middle = time.process_time()
rows = plan.proof()
end = time.process_time()
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
beads = sum(len(fill.beads) for fill in plan.fills)
print(json.dumps({{"plan": middle, "proof": end - middle, "GB": peak, "layers": len(rows), "beads": beads}}))
"""


def run(script: str, **values) -> dict[str, float]:
    code = "import contextlib, io, json, time\n" + script.format(**values)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.strip().splitlines()[-1])


@pytest.mark.parametrize("name", ["helical_gear_tooth", "helical_gear", "propeller"])
def test_pictures_against_importing_and_reading(name, fixture_step, tmp_path, capsys):
    values = {"path": str(fixture_step(name)), "folder": str(tmp_path)}
    runs = [{**run(BASE, **values), **run(PICTURES, **values), **run(COMMAND, **values)} for _ in range(RUNS)]
    with capsys.disabled():
        base = statistics.median(one["base"] for one in runs)
        print(f"\n{name}: import and read {base:.2f} s")
        for key in ("layers.png", "toolpath.png", "pictures", "command"):
            seconds = statistics.median(one[key] for one in runs)
            ratio = statistics.median(one[key] / one["base"] for one in runs)
            print(f"  {key:14s} {seconds:6.2f} s, {ratio:5.2f} times that")
    assert (tmp_path / "toolpath.png").exists()


def herringbone(folder):
    """20 teeth that turn by 8 degrees and back."""
    bd = pytest.importorskip("build123d")

    def across(z, angle):
        corners = [(44.9, -5.2), (50, -4), (56, -2), (56, 2), (50, 4), (44.9, 5.2)]
        c, s = math.cos(angle), math.sin(angle)
        return bd.Wire.make_polygon([bd.Vector(c * x - s * y, s * x + c * y, z) for x, y in corners], close=True)

    gear, turn = bd.Solid.make_cylinder(45, 40), math.radians(8)
    for k in range(20):
        a = 2.0 * math.pi * k / 20
        halves = ([across(0, a), across(20, a + turn)], [across(20, a + turn), across(40, a)])
        gear = gear + [bd.Solid.make_loft(half, ruled=True) for half in halves]
    bd.export_step(gear, str(folder / "herringbone.step"))
    return str(folder / "herringbone.step")


def long_shaft(folder):
    """1.2 m, nine stretches of 24 splines, eight collars: about 1,000 faces."""
    bd = pytest.importorskip("build123d")
    spline = bd.Box(8, 5, 60)
    splines = [
        bd.Pos(0, 0, 30 + 130 * k) * bd.Rot(0, 0, 15 * i) * bd.Pos(41, 0, 30) * spline for k in range(9) for i in range(24)
    ]
    shaft = bd.Part() + bd.Solid.make_cylinder(40, 1200) + splines
    for k in range(8):
        shaft = shaft + bd.Pos(0, 0, 122 + 130 * k) * bd.Cylinder(46, 24)
    bd.export_step(shaft, str(folder / "long_shaft.step"))
    return str(folder / "long_shaft.step")


def auger(folder):
    path = REAL / "auger_corkscrew_bspline_sse.step"
    if not path.exists():
        pytest.skip(f"{path} is not there")
    return str(path)


@pytest.mark.parametrize(
    ("make", "process", "more", "runs"),
    [
        (herringbone, {"layer_thickness": 1.4, "step_over": 2.0, "pattern": "flank"}, {"substrate": 45.0, "layers": (0, 4)}, 3),
        (auger, {"layer_thickness": 1.0, "step_over": 1.5, "pattern": "spiral"}, {"substrate": 5.0}, 1),
        (long_shaft, {"layer_thickness": 1.0, "step_over": 1.0}, {}, 1),
    ],
    ids=["flank on a herringbone gear", "spiral on an auger", "shaft of 1,000 faces"],
)
def test_proofs_against_their_plans(make, process, more, runs, tmp_path, capsys):
    path = make(tmp_path)
    found = [run(PROOF, path=path, process=process, more=more) for _ in range(runs)]
    one = sorted(found, key=lambda each: each["proof"] / each["plan"])[len(found) // 2]
    ratio = one["proof"] / one["plan"]
    with capsys.disabled():
        print(
            f"\n{make.__name__}: {one['layers']} layers, {one['beads']} beads; plan {one['plan']:.1f} s,"
            f" proof {one['proof']:.1f} s, {ratio:.2f} times that; {one['GB']:.2f} GB at most"
        )
    assert one["layers"]
