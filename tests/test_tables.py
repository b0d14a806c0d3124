"""toolpath.csv and toolpath.json: the same bytes however many rows are in words at a time, in bounded memory."""

from __future__ import annotations

import json
import tracemalloc

import numpy as np
import pytest

import brep_slicer as bs
from brep_slicer.output import tables
from brep_slicer.toolpath import COLUMNS, Toolpath


def toolpath_of(rows, seed=0):
    random = np.random.default_rng(seed)
    return Toolpath(
        layer=np.sort(random.integers(0, 20, rows)),
        bead=np.arange(rows) // 25,
        deposits=random.random(rows) > 0.1,
        points=random.normal(size=(rows, 3)) * 10.0 ** random.integers(-9, 9, (rows, 1)),
        normals=random.normal(size=(rows, 3)),
        kappa=random.normal(size=rows),
        v=np.where(random.random(rows) > 0.5, 0.0, -0.0),
        radius=np.full(rows, 0.1 + 0.2),
        speed=np.full(rows, 9.0),
    )


@pytest.mark.parametrize("rows", [0, 1, 6, 7, 8, 700])
@pytest.mark.parametrize("at_once", [7, 50_000])
def test_every_row_is_there_and_reads_back(rows, at_once, tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "ROWS_AT_ONCE", at_once)
    path = toolpath_of(rows)
    made = tables.Tables(path, {"part": "a part"})
    table, columns = made.write_csv(tmp_path), made.write_json(tmp_path)
    assert sorted(file.name for file in tmp_path.iterdir()) == ["toolpath.csv", "toolpath.json"]
    assert bs.read_toolpath(columns) == path
    # alone, or first, it is the same
    (tmp_path / "alone").mkdir()
    assert tables.Tables(path, {"part": "a part"}).write_json(tmp_path / "alone").read_bytes() == columns.read_bytes()
    lines = table.read_text().splitlines()
    assert lines[0].split(",") == list(COLUMNS)
    values = json.loads(columns.read_text())["columns"]
    # the table says the same, number by number, -0.0 too
    assert lines[1:] == [
        ",".join(v if isinstance(v, str) else repr(v) for v in row) for row in zip(*values.values(), strict=True)
    ]
    assert columns.read_text().startswith('{"format": "brep_slicer toolpath 1", "part": "a part", "columns": {"layer": [')


def test_the_memory_does_not_grow_with_the_toolpath(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "ROWS_AT_ONCE", 500)
    peaks, sizes = [], []
    for rows in (4_000, 32_000):
        path = toolpath_of(rows)
        tracemalloc.start()
        made = tables.Tables(path, {})
        written = made.write_csv(tmp_path), made.write_json(tmp_path)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
        sizes.append(sum(file.stat().st_size for file in written))
    assert sizes[1] > 7.0 * sizes[0]
    # a column is copied a megabyte at a time, at most
    assert peaks[1] < 1.5 * peaks[0] + 4 * tables.COPIED_AT_ONCE
    assert peaks[1] < sizes[1] / 2


def test_a_value_that_is_not_finite_leaves_no_file(tmp_path):
    path = toolpath_of(30)
    speed = path.speed.copy()
    speed[12] = np.inf
    broken = Toolpath(**{name: getattr(path, name) for name in Toolpath.__slots__} | {"speed": speed})
    for write in (tables.Tables(broken, {}).write_csv, tables.Tables(broken, {}).write_json):
        with pytest.raises(ValueError, match="not finite"):
            write(tmp_path)
    assert not list(tmp_path.iterdir())
