"""A region's outline as short segments: how far points lie from it, which of its curves is nearest, what lies inside.

In: a region, and how fine each of its curves is to be drawn. Out: distances, places on curves, inside or not.

Everything is periodic: a point and its copies whole turns away are one point.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import NamedTuple

import numpy as np

from brep_slicer.curves import Curve, Loop
from brep_slicer.maps import Array

from .region import Region

# No segment is longer than this share of a turn, and distances are told up to as much: one copy on either side of the
# window is then enough.
REACH = 0.125
# Points that are tested against all segments at once: what bounds the memory.
AT_ONCE = 64


class Nearest(NamedTuple):
    """The places of an outline that are nearest to some points: distances (mm), curve numbers, parameters, directions."""

    distances: Array
    curves: Array
    parameters: Array
    directions: Array


class Outline:
    """The loops of a `region`, each curve drawn to within `chord(number)` mm; curves are numbered loop by loop."""

    def __init__(self, region: Region, chord: Callable[[int], float]) -> None:
        self.period = region.period
        self.loops: list[Loop] = list(region.loops)
        self.curves: list[Curve] = [curve for loop in self.loops for curve in loop.curves]
        self._parameters = [spaced_parameters(c, chord(i), self.period) for i, c in enumerate(self.curves)]
        self._points = [c.points(s) for c, s in zip(self.curves, self._parameters, strict=True)]

    @cached_property
    def ends(self) -> Array:
        """Where each curve begins, and where it ends, (2 n, 2): starts first."""
        return np.array([p[0] for p in self._points] + [p[-1] for p in self._points]).reshape(-1, 2)

    @cached_property
    def _segments(self) -> tuple[Array, Array, Array, Array]:
        """From, to (n, 2), curve numbers (n,), parameters at both ends (n, 2); in one turn round 0, with copies beside it."""
        a = np.concatenate([p[:-1] for p in self._points])
        b = np.concatenate([p[1:] for p in self._points])
        number = np.repeat(np.arange(len(self.curves)), [len(s) - 1 for s in self._parameters])
        s = np.concatenate([np.stack([s[:-1], s[1:]], axis=-1) for s in self._parameters])
        middle = 0.5 * (a[:, 0] + b[:, 0])
        turns = np.floor(middle / self.period + 0.5)
        place = middle - turns * self.period
        parts = []
        for copy in (-1, 0, 1):
            use = np.abs(place + copy * self.period) < (0.5 + 2.0 * REACH) * self.period
            move = np.stack([(copy - turns[use]) * self.period, np.zeros(int(use.sum()))], axis=-1)
            parts.append((a[use] + move, b[use] + move, number[use], s[use]))
        a, b, number, s = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return a, b, number, s

    @cached_property
    def _tree(self):
        import shapely

        a, b, _, _ = self._segments
        return shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))

    def nearest(self, points: Array) -> Nearest:
        """The nearest place of the outline to each of `points` (n, 2); distances beyond REACH of a turn are cut to that."""
        import shapely

        q = np.array(points, dtype=float).reshape(-1, 2)
        q[:, 0] -= np.floor(q[:, 0] / self.period + 0.5) * self.period
        a, b, number, s = self._segments
        (_, found), distance = self._tree.query_nearest(shapely.points(q), return_distance=True, all_matches=False)
        along = b[found] - a[found]
        square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        share = np.clip(np.einsum("ij,ij->i", q - a[found], along) / square, 0.0, 1.0)
        at = s[found, 0] + share * (s[found, 1] - s[found, 0])
        return Nearest(np.minimum(distance, REACH * self.period), number[found], at, along / np.sqrt(square)[:, None])

    def distances_from(self, polylines: Array) -> Array:
        """Distance (n,) of polylines (n, k, 2), each no wider than REACH of a turn, from the outline; cut to REACH as well."""
        import shapely

        lines = np.array(polylines, dtype=float)
        middle = 0.5 * (lines[:, 0, 0] + lines[:, -1, 0])
        lines[..., 0] -= (np.floor(middle / self.period + 0.5) * self.period)[:, None]
        _, distance = self._tree.query_nearest(shapely.linestrings(lines), return_distance=True, all_matches=False)
        return np.minimum(distance, REACH * self.period)

    def contains(self, points: Array) -> Array:
        """Which of `points` (n, 2) have metal round them, (n,) of bool: the outline below each, counted with its direction."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        below = np.zeros(len(points), dtype=int)
        first = 0
        for loop in self.loops:
            parts = self._points[first : first + len(loop.curves)]
            first += len(loop.curves)
            chain = np.concatenate([*parts, parts[0][:1] + np.array([[loop.winding * self.period, 0.0]])])
            for i in range(0, len(points), AT_ONCE):
                below[i : i + AT_ONCE] += _crossings_below(chain, points[i : i + AT_ONCE], self.period)
        return below > 0


def spaced_parameters(curve: Curve, chord: float, period: float) -> Array:
    """Parameters whose polyline lies within `chord` (mm) of the curve, none of its segments wider than REACH of a turn."""
    s = curve.parameters(chord)
    widths = np.abs(np.diff(curve.points(s)[:, 0]))
    pieces = np.maximum(np.ceil(widths / (REACH * period)).astype(int), 1)
    if pieces.max() == 1:
        return s
    return np.concatenate([*(np.linspace(s[i], s[i + 1], k + 1)[:-1] for i, k in enumerate(pieces)), s[-1:]])


def _crossings_below(chain: Array, points: Array, period: float) -> Array:
    """How often a chain passes below each point towards greater kappa, less how often towards smaller."""
    start = chain[0, 0]
    # within one turn from the chain's start: the vertex at either end of a winding chain is then left or right of both copies
    base = points[:, 0] - np.floor((points[:, 0] - start) / period) * period
    base = np.where(base >= start + period, start, base)
    count = np.zeros(len(points), dtype=int)
    turns = (chain[:, 0] - start) / period
    for lift in range(int(np.floor(turns.min())) - 1, int(np.ceil(turns.max())) + 1):
        kappa = base + lift * period
        right = chain[None, :, 0] > kappa[:, None]
        rows, at = np.nonzero(right[:, 1:] != right[:, :-1])
        (ka, va), (kb, vb) = chain[at].T, chain[at + 1].T
        height = va + (vb - va) * (kappa[rows] - ka) / (kb - ka)
        np.add.at(count, rows, np.where(height < points[rows, 1], np.where(right[rows, at + 1], 1, -1), 0))
    return count
