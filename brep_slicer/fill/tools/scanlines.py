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
    """Parts of lines inside of polygons: `line` (n,), `points` (n, 2, 2) from lower to higher along, the `group` (n,) of edges
    that cut them, in rising order."""

    line: Array
    points: Array
    group: Array


# Line numbers of one group are told from those of the next by this.
APART = 1 << 32


def directions(angle: float) -> tuple[Array, Array]:
    """Unit vectors along and across lines at `angle` (rad); exact for multiples of a quarter turn."""
    cos, sin = np.cos(angle), np.sin(angle)
    cos, sin = (0.0 if abs(x) < 1e-15 else x for x in (cos, sin))
    return np.array([cos, sin]), np.array([-sin, cos])


def cut_lines(
    starts: Array,
    ends: Array,
    *,
    angle: float,
    spacing: float | Array,
    phase: float | Array,
    group: Array | None = None,
) -> Stretches:
    """Cut the family by the edges from `starts` to `ends`, (n, 2) each, by the even-odd rule.

    A line through a vertex counts it for the edge that lies above only, so that the ends always pair up. Several families at
    once: with `group` (n,), whole numbers, edges of different groups do not meet; `spacing` and `phase` are then one a group.
    """
    along, across = directions(angle)
    number = np.zeros(len(starts), dtype=np.int64) if group is None else group
    spacings, phases = (np.broadcast_to(np.atleast_1d(x), (int(number.max(initial=0)) + 1,)) for x in (spacing, phase))
    ya, yb = ((p @ across - phases[number]) / spacings[number] for p in (starts, ends))
    first = np.ceil(np.minimum(ya, yb)).astype(np.int64)
    count = np.ceil(np.maximum(ya, yb)).astype(np.int64) - first
    edge = np.repeat(np.arange(len(starts)), count)
    line = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count - first, count)
    share = (line - ya[edge]) / (yb - ya)[edge]
    xa = starts @ along
    x = xa[edge] + share * (ends @ along - xa)[edge]
    order = np.lexsort((x, line + number[edge] * APART))
    cut, x = edge[order[0::2]], x[order].reshape(-1, 2)
    line, owner = line[order[0::2]], number[cut]
    y = phases[owner] + line * spacings[owner]
    points = x[:, :, None] * along + y[:, None, None] * across
    return Stretches(line=line, points=points, group=owner)
