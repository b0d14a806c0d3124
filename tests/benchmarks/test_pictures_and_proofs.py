"""The command against importing and reading, proofs against their plans: pytest tests/benchmarks -m benchmark -n 0 -s.

Seconds are of the processor, each in a process of its own; ratios are medians of runs that take turns.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.benchmark
REAL = Path(__file__).resolve().parents[3] / "shared" / "step"
RUNS = 5
BASE = """
import sys
import OCP, numpy, scipy, shapely, matplotlib
from OCP.STEPControl import STEPControl_Reader
reader = STEPControl_Reader()
reader.ReadFile(sys.argv[1])
reader.TransferRoots()
reader.OneShape()
"""
# A process begins with the memory of the one that starts it, which is large where tests run: a small one starts it.
SPENT = """
import os, subprocess, sys
process = subprocess.Popen(sys.argv[1:], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
_, status, used = os.wait4(process.pid, 0)
print(os.waitstatus_to_exitcode(status), used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0)
"""
PROCESS = ["-t", "1.4", "-d", "3.4"]
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
    code = "import json, time\n" + script.format(**values)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(done.stdout.strip().splitlines()[-1])


def spent(words: list[str], environment: dict[str, str]) -> tuple[float, float]:
    """Seconds of the processor (user and system) and MiB at most of a process from its start to its end."""
    done = subprocess.run([sys.executable, "-c", SPENT, *words], capture_output=True, text=True, check=True, env=environment)
    code, seconds, size = done.stdout.split()
    assert code == "0", words
    return float(seconds), float(size)


@pytest.mark.skipif(not hasattr(os, "wait4"), reason="the processor's time of a process is asked of Unix")
@pytest.mark.parametrize("name", ["helical_gear_tooth", "helical_gear", "propeller"])
def test_the_command_against_importing_and_reading(name, fixture_step, tmp_path, capsys):
    path, folder = str(fixture_step(name)), str(tmp_path)
    # modules are compiled once, as an installation does
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = str(tmp_path / "compiled")
    base = [sys.executable, "-c", BASE, path]
    command = [sys.executable, "-m", "brep_slicer", "plan", path, *PROCESS, "-o", folder]
    for words in (base, command):
        spent(words, environment)
    runs = [(spent(base, environment), spent(command, environment)) for _ in range(RUNS)]
    pictures = [run(PICTURES, path=path, folder=folder) for _ in range(RUNS)]
    bases, commands, peaks = zip(*((b[0], c[0], c[1]) for b, c in runs), strict=True)
    with capsys.disabled():
        whole = statistics.median(bases)
        print(f"\n{name}: import and read {whole:.2f} s")
        ratios = [c / b for b, c in zip(bases, commands, strict=True)]
        print(
            f"  plan {statistics.median(commands):.2f} s, {statistics.median(ratios):.2f} times that"
            f" ({min(ratios):.2f} to {max(ratios):.2f}); {statistics.median(peaks):.0f} MiB at most"
        )
        for key in ("pictures", "layers.png", "toolpath.png"):
            seconds = statistics.median(one[key] for one in pictures)
            print(f"  of it {key} {seconds:.2f} s, {seconds / whole:.2f} times that")
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
        (
            herringbone,
            {"layer_thickness": 1.4, "step_over": 2.0, "fill": {"pattern": "flank"}},
            {"substrate": 45.0, "layers": (0, 4)},
            3,
        ),
        (auger, {"layer_thickness": 1.0, "step_over": 1.5, "fill": {"pattern": "spiral"}}, {"substrate": 5.0}, 1),
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
