"""A region's outline as short segments: how far points lie from it, which of its curves is nearest, what lies inside.

In: a region. Out: distances, places on curves, inside or not.

A point and its copies, whole turns away by the closure, are one point. An outline is drawn coarsely first, and finer
where it lies near to what it is compared with, as often as it takes: far from there a coarse one tells the same.
"""

from __future__ import annotations

import itertools
from functools import cached_property
from typing import NamedTuple, Self

import numpy as np

from brep_slicer.curves import Curve, Loop
from brep_slicer.curves.base import far_spans
from brep_slicer.maps import Array

from .chart import crossings_below
from .region import Region

# No segment is longer than this share of a turn, and distances are told up to as much: one copy on either side of the
# window is then enough.
REACH = 0.125
# How far a coarse polyline may lie from its curve, mm, and by how much it is refined at a time; a span is refined if it lies
# within so many times its own distance from its curve of what it is compared with (both may be off by one).
COARSE, REFINED, NEAR = 1e-3, 100.0, 4.0
MAXIMUM_HALVINGS = 40
# Steps of Gauss-Newton from the nearest segment to the nearest place on its curve.
PROJECTIONS = 3
# A curve goes on beyond the end of what runs beside it: so many times as far as it is looked for.
GOES_ON = 4.0
# Points that are tested against all segments at once: what bounds the memory.
AT_ONCE = 64


class Nearest(NamedTuple):
    """The places of an outline that are nearest to some points, and on which side of it these lie (+1 left, -1 right)."""

    distances: Array
    curves: Array
    parameters: Array
    directions: Array
    sides: Array

    def rows(self, lines: Array, size: int) -> Nearest:
        """Of points that come `size` at a time, those with the numbers `lines` (n,); each column is then (n, size, ...)."""
        return Nearest(*(column.reshape(-1, size, *column.shape[1:])[lines] for column in self))


class Outline:
    """The loops of a `region`, each curve drawn at its `parameters`; curves are numbered loop by loop."""

    def __init__(self, region: Region, parameters: list[Array] | None = None) -> None:
        self.region, self.closure = region, region.closure
        self.loops: list[Loop] = list(region.loops)
        self.curves: list[Curve] = [curve for loop in self.loops for curve in loop.curves]
        if parameters is None:
            parameters = [spaced_parameters(curve, COARSE, self.reach) for curve in self.curves]
        self._parameters = parameters
        self._points = [c.points(s) for c, s in zip(self.curves, self._parameters, strict=True)]

    @cached_property
    def reach(self) -> float:
        """REACH of a turn where that is shortest, mm: as far as distances are told, and segments are wide."""
        ends = np.array([p for loop in self.loops for p in np.reshape(loop.bounds(), (2, 2))]).reshape(-1, 2)
        heights = self.closure.heights_of(ends) if len(ends) else np.zeros(1)
        return REACH * float(self.closure.ring_lengths(heights).min())

    def spans(self) -> Array:
        """Each segment of each curve from point to point, (n, 2, 2), mm."""
        return np.concatenate([np.stack([p[:-1], p[1:]], axis=1) for p in self._points])

    def refined(self, flags: Array, chord: float) -> Self:
        """The outline drawn to within `chord` mm on the spans with a flag, (n,) of bool."""
        counts = np.cumsum([len(s) - 1 for s in self._parameters])[:-1]
        near = np.split(flags, counts)
        parameters = [_halved(c, s, f, chord) for c, s, f in zip(self.curves, self._parameters, near, strict=True)]
        return type(self)(self.region, parameters)

    @cached_property
    def ends(self) -> Array:
        """Where each curve begins, and where it ends, (2 n, 2): starts first."""
        return np.array([p[0] for p in self._points] + [p[-1] for p in self._points]).reshape(-1, 2)

    @cached_property
    def _segments(self) -> tuple[Array, Array, Array, Array, Array]:
        """From, to (n, 2), curve numbers (n,), parameters at both ends (n, 2), and by how many turns they are moved (n,).

        They lie in one turn round 0, with copies beside it.
        """
        a = np.concatenate([p[:-1] for p in self._points])
        b = np.concatenate([p[1:] for p in self._points])
        number = np.repeat(np.arange(len(self.curves)), [len(s) - 1 for s in self._parameters])
        s = np.concatenate([np.stack([s[:-1], s[1:]], axis=-1) for s in self._parameters])
        closure, middle = self.closure, 0.5 * (a + b)
        turns = closure.copies_of(middle)
        place = closure.turns_of(middle) - turns
        parts = []
        for copy in closure.beside:
            use = np.abs(place + copy) < 0.5 + 2.0 * REACH
            moved = copy - turns[use]
            parts.append((closure.moved(a[use], moved), closure.moved(b[use], moved), number[use], s[use], moved))
        a, b, number, s, moved = (np.concatenate(columns) for columns in zip(*parts, strict=True))
        return a, b, number, s, moved

    @cached_property
    def _tree(self):
        import shapely

        a, b, *_ = self._segments
        return shapely.STRtree(shapely.linestrings(np.stack([a, b], axis=1)))

    def nearest(self, points: Array) -> Nearest:
        """The nearest place on the outline's curves to each of `points` (n, 2); distances are cut to REACH of a turn."""
        import shapely

        q = np.array(points, dtype=float).reshape(-1, 2)
        copies = self.closure.copies_of(q)
        q = self.closure.moved(q, -copies)
        a, b, number, s, moved = self._segments
        (_, found), _ = self._tree.query_nearest(shapely.points(q), return_distance=True, all_matches=False)
        along = b[found] - a[found]
        square = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        share = np.clip(np.einsum("ij,ij->i", q - a[found], along) / square, 0.0, 1.0)
        at = s[found, 0] + share * (s[found, 1] - s[found, 0])
        q = self.closure.moved(q, -moved[found])
        directions, offsets = self.closure.turned(along / np.sqrt(square)[:, None], -moved[found]), np.empty((len(q), 2))
        for i in np.unique(number[found]):
            rows = np.flatnonzero(number[found] == i)
            at[rows], offsets[rows], tangents = projected(self.curves[i], at[rows], q[rows])
            size = np.hypot(*tangents.T)
            clear = np.isfinite(size) & (size > 0.0)
            directions[rows[clear]] = tangents[clear] / size[clear, None]
        distances = np.minimum(np.hypot(*offsets.T), self.reach)
        sides = np.sign(directions[:, 0] * offsets[:, 1] - directions[:, 1] * offsets[:, 0])
        return Nearest(distances, number[found], at, self.closure.turned(directions, copies + moved[found]), sides)

    def distances_from(self, polylines: Array) -> Array:
        """Distance (n,) of polylines (n, k, 2), each no wider than REACH of a turn, from the outline; cut to REACH as well."""
        import shapely

        lines = self.in_the_window(polylines)
        _, distance = self._tree.query_nearest(shapely.linestrings(lines), return_distance=True, all_matches=False)
        return np.minimum(distance, self.reach)

    def in_the_window(self, polylines: Array) -> Array:
        """Polylines (n, k, 2) moved by whole turns so that the middle between their ends lies within half a turn of 0."""
        lines = np.array(polylines, dtype=float)
        return self.closure.moved(lines, -self.closure.copies_of(0.5 * (lines[:, 0] + lines[:, -1]))[:, None])

    def runs_beside(self, polylines: Array, at: Nearest, reach: float) -> Array:
        """For which polylines (n, k, 2) all of the outline within `reach` mm of them is one stretch of one curve, on one side.

        It is the stretch between the places `at` (n, k) nearest to their corners, and what goes on at its ends.
        """
        import shapely

        low, high = at.parameters.min(axis=1), at.parameters.max(axis=1)
        # beyond a curve's end its side tells nothing
        beside = (at.curves == at.curves[:, :1]).all(axis=1) & (low > 0.0) & (high < 1.0)
        beside &= np.abs(at.sides.sum(axis=1)) == polylines.shape[1]
        asked = np.flatnonzero(beside)
        lines = self.in_the_window(polylines[asked])
        line, found = self._tree.query(shapely.linestrings(lines), predicate="dwithin", distance=reach)
        a, b, number, s, _ = (column[found] for column in self._segments)
        rows = asked[line]
        between = (s.min(axis=1) <= high[rows]) & (s.max(axis=1) >= low[rows])
        corners = lines[line][:, [0, -1]]
        ends = np.stack([np.hypot(*np.moveaxis(p[:, None] - corners, -1, 0)) for p in (a, b)]).min(axis=0)
        goes_on = np.any(ends <= at.distances[rows][:, [0, -1]] + GOES_ON * reach, axis=1)
        other = (number != at.curves[rows, 0]) | ~(between | goes_on)
        beside[rows[other]] = False
        return beside

    def contains(self, points: Array) -> Array:
        """Which of `points` (n, 2) have metal round them, (n,) of bool."""
        return self.layers(points) > 0

    def layers(self, points: Array) -> Array:
        """How often the region holds each of `points` (n, 2): the outline below each, counted with its direction."""
        points = np.asarray(points, dtype=float).reshape(-1, 2)
        below = np.zeros(len(points), dtype=int)
        first = 0
        for loop in self.loops:
            parts = self._points[first : first + len(loop.curves)]
            first += len(loop.curves)
            chain = np.concatenate([*parts, self.closure.moved(parts[0][:1], loop.winding)])
            for i in range(0, len(points), AT_ONCE):
                below[i : i + AT_ONCE] += crossings_below(chain, points[i : i + AT_ONCE], self.closure)
        return below


def spaced_parameters(curve: Curve, chord: float, reach: float) -> Array:
    """Parameters whose polyline lies within `chord` (mm) of the curve, none of its segments wider than `reach` (mm)."""
    s = curve.parameters(chord)
    widths = np.abs(np.diff(curve.points(s)[:, 0]))
    pieces = np.maximum(np.ceil(widths / reach).astype(int), 1)
    if pieces.max() == 1:
        return s
    return np.concatenate([*(np.linspace(s[i], s[i + 1], k + 1)[:-1] for i, k in enumerate(pieces)), s[-1:]])


def projected(curve: Curve, s: Array, points: Array) -> tuple[Array, Array, Array]:
    """From parameters near to them the places on a curve nearest to `points`: parameters, offsets, derivatives."""
    p, d = curve.at(s)
    best = np.hypot(*(points - p).T)
    for _ in range(PROJECTIONS):
        t = np.clip(s + np.einsum("ij,ij->i", points - p, d) / np.maximum(np.einsum("ij,ij->i", d, d), 1e-300), 0.0, 1.0)
        q, e = curve.at(t)
        distance = np.hypot(*(points - q).T)
        better = distance < best
        s, best = np.where(better, t, s), np.where(better, distance, best)
        p, d = np.where(better[:, None], q, p), np.where(better[:, None], e, d)
    return s, points - p, d


def _halved(curve: Curve, s: Array, flags: Array, chord: float) -> Array:
    """Parameters with more of them on the spans with a flag, so that the polyline there lies within `chord` of the curve."""
    a, b = s[:-1][flags], s[1:][flags]
    found = [s]
    for _ in range(MAXIMUM_HALVINGS):
        far = far_spans(curve, a, b, chord)
        if not far.any():
            break
        middle = 0.5 * (a + b)[far]
        found.append(middle)
        a, b = np.concatenate([a[far], middle]), np.concatenate([middle, b[far]])
    return np.sort(np.concatenate(found))


def _levels(fine: float) -> list[tuple[float, float]]:
    """From how far a polyline lies from its curve to how far it is to lie, step by step down to `fine`."""
    chords = [COARSE]
    while chords[-1] > fine:
        chords.append(max(chords[-1] / REFINED, fine))
    return list(itertools.pairwise(chords))


def drawn_near_each_other(a: Region, b: Region, fine: float) -> tuple[Outline, Outline]:
    """The outlines of two regions, within `fine` mm of their curves where they come near to each other."""
    one, other = Outline(a), Outline(b)
    for before, chord in _levels(fine):
        near = (other.distances_from(one.spans()) <= NEAR * before, one.distances_from(other.spans()) <= NEAR * before)
        one, other = one.refined(near[0], chord), other.refined(near[1], chord)
    return one, other


def drawn_near_points(region: Region, points: Array, fine: float) -> Outline:
    """The outline of a region, within `fine` mm of its curves where they come near to `points` (n, 2)."""
    import shapely

    out = Outline(region)
    if not out.curves:
        return out
    at = out.closure.canonical(np.array(points, dtype=float))
    copies = np.concatenate([out.closure.moved(at, turns) for turns in out.closure.beside])
    tree = shapely.STRtree(shapely.points(copies))
    for before, chord in _levels(fine):
        spans = out.in_the_window(out.spans())
        found = tree.query(shapely.linestrings(spans), predicate="dwithin", distance=NEAR * before)[0]
        out = out.refined(np.isin(np.arange(len(spans)), found), chord)
    return out
