"""Families of parallel lines cut by polygons, all lines and all edges at once.

In: edges of polygons, an angle, a spacing, a phase. Out: for each stretch inside, its line and its two ends.

Words: *across*, the coordinate along the lines' normal (-sin, cos); *along*, the one in their direction (cos, sin); line m
lies at across = phase + m * spacing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stretches:
    """Parts of lines inside of polygons: `line` (n,), `points` (n, 2, 2) from lower to higher along, `edges` (n, 2) that cut
    them. `count` lines were needed to cover the polygons."""

    line: Array
    points: Array
    edges: Array


def directions(angle: float) -> tuple[Array, Array]:
    """Unit vectors along and across lines at `angle` (rad); exact for multiples of a quarter turn."""
    cos, sin = np.cos(angle), np.sin(angle)
    cos, sin = (0.0 if abs(x) < 1e-15 else x for x in (cos, sin))
    return np.array([cos, sin]), np.array([-sin, cos])


def cut_lines(starts: Array, ends: Array, *, angle: float, spacing: float, phase: float) -> Stretches:
    """Cut the family by the edges from `starts` to `ends`, (n, 2) each, by the even-odd rule.

    A line through a vertex counts it for the edge that lies above only, so that the ends always pair up.
    """
    along, across = directions(angle)
    ya, yb = ((p @ across - phase) / spacing for p in (starts, ends))
    first = np.ceil(np.minimum(ya, yb)).astype(np.int64)
    last = np.ceil(np.maximum(ya, yb)).astype(np.int64)
    count = np.maximum(last - first, 0)
    edge = np.repeat(np.arange(len(starts)), count)
    line = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + first[edge]
    share = (line - ya[edge]) / (yb[edge] - ya[edge])
    x = (1.0 - share) * (starts[edge] @ along) + share * (ends[edge] @ along)
    order = np.lexsort((x, line))
    line, x, edge = line[order], x[order], edge[order]
    line, x, pairs = line[0::2], x.reshape(-1, 2), edge.reshape(-1, 2)
    y = phase + line * spacing
    points = x[:, :, None] * along + y[:, None, None] * across
    return Stretches(line=line, points=points, edges=pairs)
