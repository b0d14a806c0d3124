"""The proof in tiles and by a tree: the same figures as over the whole plane and by all pairs."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

import brep_slicer as bs
from brep_slicer.fill import Contours, Hatch, Rings, Spiral, fill_region
from brep_slicer.proof import deposit, deposit_of, evenness_of, step_over_of
from brep_slicer.proof.grid import Tile, cells_inside, cells_of_boxes, edges_of_polygons

from .test_fill import ARGS, D, W, band, box

T = 1.4
FILLS = {
    "hatch": (box, Hatch(angle_deg=math.degrees(0.3))),
    "spiral": (box, Spiral(skeleton=False)),
    "contours": (box, Contours(skeleton=False)),
    "rings": (band, Rings()),
}


@pytest.mark.parametrize("size", [61, 256])
@pytest.mark.parametrize(("shape", "pattern"), FILLS.values(), ids=FILLS)
def test_tiles_give_the_figures_of_the_whole_plane(shape, pattern, size, monkeypatch):
    monkeypatch.setattr(deposit, "TILE", size)
    beads = fill_region(shape(), pattern, **ARGS).beads
    whole = deposit_of(shape(), beads, width=W, thickness=T, step_over=D)
    tiles = evenness_of(shape(), beads, width=W, thickness=T, step_over=D, tolerance=0.02)
    assert tiles.mean == pytest.approx(whole.mean, rel=1e-12)
    assert tiles.variation == pytest.approx(whole.variation, rel=1e-9)
    assert tiles.within == whole.share_within(T, 0.02)


def test_a_window_shows_what_the_whole_shows():
    beads = fill_region(box(), Hatch(angle_deg=math.degrees(0.3)), **ARGS).beads
    whole = deposit_of(box(), beads, width=W, thickness=T, step_over=D)
    k0, v0 = whole.kappa[0], whole.v[0]
    half = 0.5 * W / 24.0
    part = deposit_of(box(), beads, width=W, thickness=T, step_over=D, window=(k0 - half, v0 - half, k0 + 3 * W, v0 + 2 * W))
    rows, columns = part.heights.shape
    # the last row and column may stick out of the window
    inner = np.s_[: rows - 1, : columns - 1]
    np.testing.assert_allclose(part.heights[inner], whole.heights[:rows, :columns][inner], atol=1e-9)


def test_cells_inside_of_rings_are_those_that_shapely_calls_inside():
    ring = shapely.Point(3.0, 2.0).buffer(2.0, quad_segs=9).difference(shapely.box(2.03, 1.07, 3.11, 2.53))
    tile = Tile(cell=0.07, origin=(0.0, -0.5), row=3, column=2, shape=(60, 70))
    truth = shapely.contains_xy(ring, *np.meshgrid(tile.kappa, tile.v))
    assert 0 < truth.sum() < truth.size
    np.testing.assert_array_equal(cells_inside(edges_of_polygons(ring), tile), truth)


def test_cells_of_a_slanting_box_are_those_whose_middles_lie_in_it():
    tile = Tile(cell=0.1, origin=(0.0, 0.0), row=0, column=0, shape=(50, 50))
    corners = np.array([[[1.0, 1.0], [3.0, 2.03], [2.51, 2.97], [0.52, 1.96]]])
    _, cells = cells_of_boxes(corners, tile)
    inside = shapely.contains_xy(shapely.Polygon(corners[0]), *np.meshgrid(tile.kappa, tile.v)).ravel()
    np.testing.assert_array_equal(np.sort(cells), np.flatnonzero(inside))


@pytest.mark.parametrize("angle", [0.0, 30.0, 75.0])
def test_neighbours_by_a_tree_are_those_of_all_pairs(angle, fixture_step):
    process = bs.Process(
        layer_thickness=2.0, step_over=D, fill=bs.Fill(bead_width=W, contours=1, pattern=bs.Automatic(angle_deg=(angle,)))
    )
    plan = bs.plan(bs.read_step(fixture_step("keyed_band")), process, axis="Z", substrate=45.0, layers=(0, 1))
    every = step_over_of(plan.toolpath, plan.axis, 0)
    near = step_over_of(plan.toolpath, plan.axis, 0, within=2.0 * D)
    beside = every.spacings < 2.0 * D
    assert 50 < beside.sum() == len(near.spacings)
    np.testing.assert_allclose(near.spacings, every.spacings[beside], rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(near.between, every.between[beside])
    assert math.isclose(near.lowest, every.lowest, abs_tol=1e-12)
