"""Where the time of a plan goes, and how the engines compare: pytest tests/benchmarks -m benchmark -n 0 -s."""

from __future__ import annotations

import time

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.output.write import write_plan
from brep_slicer.planning import planner, sections
from brep_slicer.region import slice_solids
from brep_slicer.section import Engine, cut_solids
from brep_slicer.toolpath import lift_layers

pytestmark = pytest.mark.benchmark
Z = bs.axis_from_text("Z")


class Clock:
    """Seconds by stage, in the order in which they were met."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}

    def timed(self, name, function):
        def run(*args, **kwargs):
            start = time.perf_counter()
            try:
                return function(*args, **kwargs)
            finally:
                self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - start

        return run


@pytest.mark.parametrize(("name", "substrate"), [("helical_gear_tooth", 150.0), ("helical_gear", 87.5)])
def test_stages_of_plan(name, substrate, fixture_step, monkeypatch, tmp_path, capsys):
    clock = Clock()
    monkeypatch.setattr(sections, "cut_solids", clock.timed("geometry", cut_solids))
    monkeypatch.setattr(sections, "find_substrate", clock.timed("substrate", sections.find_substrate))
    monkeypatch.setattr(sections, "slice_solids", clock.timed("sections", slice_solids))
    monkeypatch.setattr(planner, "fill_layer", clock.timed("fill", planner.fill_layer))
    monkeypatch.setattr(planner, "lift_layers", clock.timed("toolpath", lift_layers))
    part = clock.timed("read", bs.read_step)(fixture_step(name))
    process = bs.Process(layer_thickness=1.4, step_over=3.4)
    plan = clock.timed("plan in all", bs.plan)(part, process, axis=Z, substrate=substrate)
    clock.timed("files and pictures", write_plan)(plan, tmp_path)
    with capsys.disabled():
        beads = sum(len(fill.beads) for fill in plan.fills)
        print(f"\n{name}: {len(plan.layers)} layers, {beads} beads, {len(plan.toolpath)} points")
        for stage, seconds in clock.seconds.items():
            print(f"  {stage:20s} {1000 * seconds:9.1f} ms")
    assert beads
    assert set(clock.seconds) >= {"read", "geometry", "substrate", "sections", "fill", "toolpath", "files and pictures"}


@pytest.mark.parametrize("name", ["helical_gear", "propeller"])
def test_analytic_against_boolean(name, fixture_step, capsys):
    """The same part in the same run: 100 layers by level sets, 4 of them by OCCT's boolean (per layer)."""
    solids = cut_solids(bs.read_step(fixture_step(name)), Z)[-1:]
    (solid,) = solids
    low = {"helical_gear": 87.6}.get(name, solid.critical.lowest + 0.1)
    radii = np.linspace(low, solid.critical.highest - 0.1, 100)
    per_layer = {}
    for engine, some in ((Engine.ANALYTIC, radii), (Engine.BOOLEAN, radii[10::25])):
        start = time.perf_counter()
        layers = slice_solids(solids, some, engine=engine)
        per_layer[engine] = (time.perf_counter() - start) / len(some)
        assert not any(layer.failed for layer in layers)
    ratio = per_layer[Engine.BOOLEAN] / per_layer[Engine.ANALYTIC]
    with capsys.disabled():
        print(f"\n{name}: analytic {1e3 * per_layer[Engine.ANALYTIC]:.2f} ms a layer, boolean {ratio:.0f} times that")
    assert ratio > 1.0
