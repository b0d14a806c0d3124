"""Distance from points to the exact boundary curves of a piece, and bead ends brought to an exact inset.

In: points in the plane, the curves of a piece. Out: distances and the directions away from the curves.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from brep_slicer.curves import Curve, LineCurve
from brep_slicer.maps import Array
from brep_slicer.region import Piece, lifts_between

# Feet on curved curves are sought from chords within this share of the distance that matters, then polished by Newton.
SEARCH_SHARE = 0.05

# Steps to a foot, and how often one that leads away from the point is halved.
FOOT_STEPS, HALVINGS = 16, 6
# Distances are good to this, mm.
ROUNDING = 1e-12
# An end slides by no more than this share of its distance from the outline at a time.
MOST_OF_GAP = 0.9


class Outline:
    """The boundary curves of a piece, with what neighbouring turns add, ready to be asked for distances."""

    def __init__(self, piece: Piece, reach: float) -> None:
        loops = list(piece.loops)
        if piece.winds:
            cut = float(piece.outer[0].curves[0].start[0])
            loops = [loop.shifted(k) for loop in loops for k in lifts_between(loop, cut - reach, cut + loop.period + reach)]
        curves = [curve for loop in loops for curve in loop.curves]
        lines = [c for c in curves if isinstance(c, LineCurve)]
        self.p0 = np.array([c.p0 for c in lines]).reshape(-1, 2)
        self.p1 = np.array([c.p1 for c in lines]).reshape(-1, 2)
        self.curved: list[Curve] = [c for c in curves if not isinstance(c, LineCurve)]
        self.period = piece.outer[0].period if piece.winds else 0.0
        self.cut = float(piece.outer[0].curves[0].start[0]) if piece.winds else 0.0
        self.chord = SEARCH_SHARE * reach
        parameters = [_dense(c, self.chord) for c in self.curved]
        drawn = [c.points(s) for c, s in zip(self.curved, parameters, strict=True)]
        self.spans = np.concatenate([np.zeros((0, 2, 2)), *(np.stack([p[:-1], p[1:]], axis=1) for p in drawn)])
        self.span_curve = np.repeat(np.arange(len(self.curved)), [len(s) - 1 for s in parameters])
        self.span_s = np.concatenate([np.zeros((0, 2)), *(np.stack([s[:-1], s[1:]], axis=-1) for s in parameters)])

    @cached_property
    def _tree(self):
        import shapely

        return shapely.STRtree(shapely.linestrings(self.spans))

    def distances(self, points: Array) -> tuple[Array, Array]:
        """Distance (n,) in mm to the nearest curve, and the unit direction (n, 2) away from it."""
        q = points
        if self.period:
            q = points.copy()
            q[:, 0] -= np.floor((q[:, 0] - self.cut) / self.period) * self.period
        best = np.full(len(q), np.inf)
        foot = np.zeros((len(q), 2))
        if len(self.p0):
            best, foot = _nearest_on_segments(q, self.p0, self.p1)
        if len(self.spans):
            rows, feet = self._curved_feet(q, best)
            gaps = np.hypot(*(q[rows] - feet).T)
            # of several feet of one point the nearest comes first, and counts
            order = np.lexsort((gaps, rows))
            rows, at = np.unique(rows[order], return_index=True)
            nearer = gaps[order[at]] < best[rows]
            best[rows[nearer]], foot[rows[nearer]] = gaps[order[at[nearer]]], feet[order[at[nearer]]]
        away = q - foot
        return best, away / np.maximum(best, 1e-300)[:, None]

    def _curved_feet(self, q: Array, best: Array) -> tuple[Array, Array]:
        """Feet (m, 2) on the curved curves, and of which points: from each chord that may be nearest, nearer than `best`."""
        import shapely

        points = shapely.points(q)
        (_, _), reach = self._tree.query_nearest(points, return_distance=True, all_matches=False)
        asked = np.flatnonzero(reach - self.chord < best)
        found, spans = self._tree.query(points[asked], predicate="dwithin", distance=reach[asked] + 2.0 * self.chord)
        rows = asked[found]
        a, along = self.spans[spans, 0], self.spans[spans, 1] - self.spans[spans, 0]
        share = np.einsum("ij,ij->i", q[rows] - a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        s = self.span_s[spans, 0] + np.clip(share, 0.0, 1.0) * (self.span_s[spans, 1] - self.span_s[spans, 0])
        feet = np.empty((len(rows), 2))
        for number in np.unique(self.span_curve[spans]):
            mask = self.span_curve[spans] == number
            feet[mask] = _feet(self.curved[int(number)], s[mask], q[rows[mask]])
        return rows, feet


def _dense(curve: Curve, chord: float) -> Array:
    s = curve.parameters(chord)
    return np.unique(np.concatenate([s, 0.5 * (s[:-1] + s[1:])]))


def _feet(curve: Curve, s: Array, q: Array) -> Array:
    """Newton on (q - c(s)).c'(s) = 0 in [0, 1], never away from q; curvature by differences."""
    h = 1e-5
    p, d = curve.points(s), curve.derivatives(s)
    gap = np.hypot(*(q - p).T)
    inner = np.clip(s, h, 1.0 - h)
    bend = (curve.derivatives(inner + h) - curve.derivatives(inner - h)) / (2.0 * h)
    for _ in range(FOOT_STEPS):
        square = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
        slope = square - np.einsum("ij,ij->i", q - p, bend)
        step = np.einsum("ij,ij->i", q - p, d) / np.where(slope > 0.1 * square, slope, square)
        new = np.clip(s + step, 0.0, 1.0)
        for _ in range(HALVINGS):
            there = curve.points(new)
            reached = np.hypot(*(q - there).T)
            worse = reached > gap + ROUNDING
            if not worse.any():
                break
            new = np.where(worse, 0.5 * (s + new), new)
        new, reached = np.where(worse, s, new), np.where(worse, gap, reached)
        there = np.where(worse[:, None], p, there)
        moved = new - s
        # the distance is stationary at its foot: an error e in s changes it by e**2
        if np.abs(moved).max(initial=0.0) < 1e-9:
            return there
        onwards = curve.derivatives(new)
        enough = np.abs(moved) > 1e-7
        bend = np.where(enough[:, None], (onwards - d) / np.where(enough, moved, 1.0)[:, None], bend)
        s, p, d, gap = new, there, onwards, reached
    return p


def _nearest_on_segments(q: Array, p0: Array, p1: Array) -> tuple[Array, Array]:
    best = np.full(len(q), np.inf)
    foot = np.zeros((len(q), 2))
    d = p1 - p0
    size = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
    for first in range(0, len(p0), 256):
        block = slice(first, first + 256)
        share = np.clip(np.einsum("nkj,kj->nk", q[:, None] - p0[None, block], d[block]) / size[block], 0.0, 1.0)
        feet = p0[None, block] + share[..., None] * d[None, block]
        gap = np.hypot(*np.moveaxis(q[:, None] - feet, -1, 0))
        nearest = gap.argmin(axis=1)
        rows = np.arange(len(q))
        closer = gap[rows, nearest] < best
        best = np.where(closer, gap[rows, nearest], best)
        foot = np.where(closer[:, None], feet[rows, nearest], foot)
    return best, foot


def ends_at_inset(outline: Outline, points: Array, outwards: Array, *, inset: float, limit: float) -> Array:
    """Slide ends along their lines until they lie at `inset` (mm) from the outline; never nearer, never by more than `limit`.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Ends that lie inside by `inset` or a little more.
    outwards : ndarray, shape (n, 2)
        Unit directions in which their lines leave the piece.
    """
    moved = np.zeros(len(points))
    best = moved.copy()
    for _ in range(8):
        gap, away = outline.distances(points + moved[:, None] * outwards)
        good = gap >= inset - 1e-12
        best = np.where(good & (moved > best), moved, best)
        if (good & (np.abs(gap - inset) <= 1e-12)).all():
            break
        rate = np.einsum("ij,ij->i", away, outwards)
        rate = np.where(rate < -1e-3, rate, -1e-3)
        # less than the gap at a time: an end does not step over the outline to where it is as far away on the other side
        moved = np.clip(moved + np.minimum((inset - gap) / rate, MOST_OF_GAP * gap), 0.0, limit)
    gap, _ = outline.distances(points + moved[:, None] * outwards)
    moved = np.where(gap >= inset - 1e-10, moved, best)
    return points + moved[:, None] * outwards
