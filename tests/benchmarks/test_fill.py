"""Filling against shapely's own intersections, travel against a solver: pytest tests/benchmarks -m benchmark -n 0 -s."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
import shapely

import brep_slicer as bs
from brep_slicer.fill import Hatch, fill_region, in_short_order
from brep_slicer.fill.passes.order import travel_of
from brep_slicer.fill.tools.inset import edges_of, inset_piece
from brep_slicer.fill.tools.scanlines import cut_lines

pytestmark = pytest.mark.benchmark
ARGS = {"step_over": 1.0, "width": 1.44, "inset": 0.72, "chord": 0.01}
ANGLE = math.radians(30.0)


@pytest.fixture(scope="module")
def regions():
    part = bs.read_step("fixtures/step/helical_gear.step")
    layers = bs.slice_part(part, np.linspace(87.6, 109.9, 100), axis=bs.axis_from_text("Z"))
    return [layer.region for layer in layers]


def lines_and_polygons(regions):
    """For every piece: its inset polygon, its edges, and the hatch lines over it."""
    along, across = np.array([math.cos(ANGLE), math.sin(ANGLE)]), np.array([-math.sin(ANGLE), math.cos(ANGLE)])
    out = []
    for piece in (piece for region in regions for piece in region.pieces):
        polygons = inset_piece(piece, ARGS["inset"], chord=ARGS["chord"]).polygons
        if not polygons:
            continue
        points = shapely.get_coordinates(list(polygons))
        y, x = points @ across, points @ along
        number = math.floor((y.max() - y.min()) / ARGS["step_over"] * (1.0 + 1e-12))
        phase = y.min() + 0.5 * (y.max() - y.min() - number * ARGS["step_over"])
        base = (phase + np.arange(number + 1) * ARGS["step_over"])[:, None] * across
        lines = np.stack([base + (x.min() - 1.0) * along, base + (x.max() + 1.0) * along], axis=1)
        out.append((shapely.union_all(list(polygons)), edges_of(polygons), phase, shapely.linestrings(lines)))
    return out


def test_filling_against_shapely(regions, capsys):
    pattern = Hatch(angle_deg=math.degrees(ANGLE))
    fill_region(regions[0], pattern, **ARGS)
    whole, fills = timed(lambda: [fill_region(region, pattern, **ARGS) for region in regions])
    beads = sum(len(fill.beads) for fill in fills)
    ready = [lines_and_polygons([region]) for region in regions]
    spacing = ARGS["step_over"]
    together = [
        (
            *(np.concatenate([edges[k] for _, edges, _, _ in layer]) for k in (0, 1)),
            np.array([phase for _, _, phase, _ in layer]),
            np.repeat(np.arange(len(layer)), [len(edges[0]) for _, edges, _, _ in layer]),
        )
        for layer in ready
    ]
    core, cut = timed(lambda: [cut_lines(a, b, angle=ANGLE, spacing=spacing, phase=p, group=g) for a, b, p, g in together])
    ready = [piece for layer in ready for piece in layer]
    alone, found = timed(lambda: [[shape.intersection(line) for line in lines] for shape, _, _, lines in ready])
    at_once, _ = timed(lambda: [shapely.intersection(shape, lines) for shape, _, _, lines in ready])
    theirs = sum(len(shapely.get_parts(piece)) for piece in found)
    with capsys.disabled():
        print(f"\n{beads} beads, insets, exact ends and all, in {whole:.3f} s: {beads / whole:.0f} a second")
        print(f"lines cut with polygons: {core:.3f} s; shapely one by one {alone:.3f} s, {alone / core:.1f} times;", end=" ")
        print(f"shapely on arrays {at_once:.3f} s, {at_once / core:.1f} times")
    assert sum(len(s.line) for s in cut) == beads
    assert theirs == pytest.approx(beads, rel=1e-3)
    assert core < at_once


def timed(function):
    """(seconds, what the function gave)."""
    start = time.perf_counter()
    made = function()
    return time.perf_counter() - start, made


def test_travel_against_a_solver(regions, capsys):
    solver = pytest.importorskip("ortools.constraint_solver.pywrapcp", reason="pip install ortools for this comparison")
    region = regions[30]
    beads = fill_region(region, Hatch(angle_deg=math.degrees(ANGLE)), **{**ARGS, "step_over": 3.0}).beads
    start = time.perf_counter()
    ordered = in_short_order(beads, region.closure)
    took = time.perf_counter() - start
    ends = np.array([[b.points[0], b.points[-1]] for b in ordered])
    ours = travel_of(ends, [(i, False) for i in range(len(ends))], region.closure)
    theirs = by_solver(solver, ends, region.closure.length)
    with capsys.disabled():
        print(
            f"\n{len(beads)} beads: travel {ours:.1f} mm in {took:.2f} s, OR-tools {theirs:.1f} mm in 20 s: {ours / theirs:.3f}"
        )
    assert ours <= 1.1 * theirs


def by_solver(solver, ends, period: float) -> float:
    """Open path over beads that may be reversed: two nodes a bead, joined at no cost; guided local search for 20 s."""
    from ortools.constraint_solver import routing_enums_pb2 as enums

    n = len(ends)
    nodes = ends.reshape(-1, 2)
    across = np.abs(nodes[:, None, 0] - nodes[None, :, 0]) % period
    far = np.hypot(np.minimum(across, period - across), nodes[:, None, 1] - nodes[None, :, 1])
    cost = np.zeros((2 * n + 1, 2 * n + 1))
    cost[:-1, :-1] = far + 1e5
    for i in range(n):
        cost[2 * i, 2 * i + 1] = cost[2 * i + 1, 2 * i] = 0.0
    whole = (cost * 1000.0).astype(np.int64)
    manager = solver.RoutingIndexManager(2 * n + 1, 1, 2 * n)
    model = solver.RoutingModel(manager)
    index = model.RegisterTransitCallback(lambda a, b: int(whole[manager.IndexToNode(a), manager.IndexToNode(b)]))
    model.SetArcCostEvaluatorOfAllVehicles(index)
    options = solver.DefaultRoutingSearchParameters()
    options.first_solution_strategy = enums.FirstSolutionStrategy.PATH_CHEAPEST_ARC
    options.local_search_metaheuristic = enums.LocalSearchMetaheuristic.GUIDED_LOCAL_SEARCH
    options.time_limit.seconds = 20
    found = model.SolveWithParameters(options)
    return float(found.ObjectiveValue()) / 1000.0 - 1e5 * (n - 1)
