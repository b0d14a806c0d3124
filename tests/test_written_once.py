"""What is found once for many: texts of numbers, the nearest place of a grid's cells; and the command's end."""

from __future__ import annotations

import csv
import gc
import io
import json
import os
import sys

import numpy as np
import pytest

from brep_slicer.fill.tools.nearest import _nearest
from brep_slicer.output import tables
from brep_slicer.toolpath import COLUMNS, Toolpath


def toolpath(n, seed=0):
    """Rows with numbers that come again, zeros of both signs, and numbers of all sizes."""
    rng = np.random.default_rng(seed)
    some = rng.choice([0.0, -0.0, 0.1, 1.0 / 3.0, 1e-320, 1e22, -123456.789], size=(n, 10))
    some[:, :2] = rng.normal(size=(n, 2)) * 10.0 ** rng.integers(-12, 12, size=(n, 2))
    return Toolpath(
        layer=np.arange(n) // 3,
        bead=np.arange(n) // 2,
        deposits=rng.random(n) < 0.5,
        points=some[:, :3],
        normals=some[:, 3:6],
        kappa=some[:, 6],
        v=some[:, 7],
        radius=some[:, 8],
        speed=some[:, 9],
    )


@pytest.mark.parametrize("n", [0, 1, 7, 8, 100])
def test_both_tables_hold_each_number_to_the_bit(n, monkeypatch, tmp_path):
    # in several stretches of rows, and in one
    monkeypatch.setattr(tables, "ROWS_AT_ONCE", 7)
    path = toolpath(n)
    both = tables.Tables(path, {"a": 1})
    table, columns = both.write_csv(tmp_path), both.write_json(tmp_path)
    assert tables.read_toolpath(columns) == path
    assert json.loads(columns.read_text())["a"] == 1
    rows = list(csv.reader(io.StringIO(table.read_text())))
    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == n + 1
    found = np.array([row[3:] for row in rows[1:]], dtype=float).reshape(-1, 10)
    true = np.column_stack([path.points, path.normals, path.kappa, path.v, path.radius, path.speed])
    # bits, so that zeros of both signs are told apart
    assert np.array_equal(found.view(np.int64), np.ascontiguousarray(true).view(np.int64))
    assert [row[2] for row in rows[1:]] == ["deposit" if laid else "travel" for laid in path.deposits]


def test_a_toolpath_with_what_is_no_number_is_not_written(tmp_path):
    path = toolpath(5)
    broken = path.speed.copy()
    broken[2] = np.nan
    values = {name: broken if name == "speed" else getattr(path, name) for name in Toolpath.__slots__}
    both = tables.Tables(Toolpath(**values), {})
    for write in (both.write_csv, both.write_json):
        with pytest.raises(ValueError, match="not finite"):
            write(tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("seed", "reach"), [(0, 2.0), (1, 3.7), (2, 0.4), (3, 30.0)])
def test_the_place_nearest_to_a_cell_is_that_of_all_pairs(seed, reach):
    rng = np.random.default_rng(seed)
    inside = rng.random((9, 14)) < 0.8
    places = rng.uniform([-4.0, -4.0], [18.0, 13.0], size=(20, 2))
    row, column = np.indices(inside.shape)
    apart = np.hypot(column[..., None] - places[:, 0], row[..., None] - places[:, 1])
    true = np.where(inside & (apart.min(axis=2) <= reach), apart.argmin(axis=2), -1)
    assert np.array_equal(_nearest(places, inside, reach), true)


class Closed(io.StringIO):
    """A pipe that nobody reads any more."""

    def flush(self):
        raise BrokenPipeError


@pytest.mark.parametrize(("code", "ends"), [(0, 0), (2, 2), (4, 4), ("words", 1)])
@pytest.mark.parametrize("stream", [io.StringIO, Closed])
def test_the_process_ends_at_once_with_the_commands_code(code, ends, stream, monkeypatch):
    from brep_slicer.cli import commands

    ended: list[int] = []
    threshold = gc.get_threshold()
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    monkeypatch.setattr(commands, "main", lambda: sys.exit(code))
    monkeypatch.setattr(os, "_exit", ended.append)
    monkeypatch.setattr(sys, "stdout", stream())
    try:
        commands.run()
    finally:
        gc.set_threshold(*threshold)
    assert ended == [ends]
    # what a user has set stays
    assert os.environ["OPENBLAS_NUM_THREADS"] == "2"
