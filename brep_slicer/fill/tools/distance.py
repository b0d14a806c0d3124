"""Distance from points to the exact boundary curves of a layer's pieces, and bead ends brought to an exact inset.

In: points in the plane, pieces of one layer. Out: distances and the directions away from the curves.

A point inside of one piece is nearer to that piece's outline than to any other's, so that pieces need not be told apart.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from brep_slicer.curves import CurveBatch, LineCurve
from brep_slicer.maps import Array
from brep_slicer.region import Piece, copies_between

# Feet on curved curves are sought from chords within this share of the distance that matters, then polished by Newton.
SEARCH_SHARE = 0.05
# Steps to a foot, and how often one that leads away from the point is halved.
FOOT_STEPS, HALVINGS = 16, 6
# A step along a curve's parameter for its curvature by differences, and the least that tells it anew.
BEND_STEP, BEND_MOVE = 1e-5, 1e-7
# A foot is found when its parameter moves by no more: the distance is stationary there, an error e changes it by e**2.
FOOT_FOUND = 1e-9
# Distances are good to this, mm.
ROUNDING = 1e-12
# An end slides by no more than this share of its distance from the outline at a time.
MOST_OF_GAP = 0.9


class Outline:
    """The boundary curves of `pieces` of one layer, with what neighbouring turns add, ready to be asked for distances.

    Distances up to `reach` (mm) are the nearest ones; beyond it, a curve on the far side of the seam may be missed.
    """

    def __init__(self, pieces: Sequence[Piece], reach: float) -> None:
        self.closure = pieces[0].closure
        self.cut = next((p for p in pieces if p.winds), pieces[0]).cut
        beside = self.closure.turns_across(reach, np.array([piece.bounds() for piece in pieces]))
        window = self.cut - beside, self.cut + 1.0 + beside
        loops = [loop.moved(k) for piece in pieces for loop in piece.loops for k in copies_between(loop, *window)]
        curves = [curve for loop in loops for curve in loop.curves]
        self.lines = np.array([(c.p0, c.p1) for c in curves if isinstance(c, LineCurve)]).reshape(-1, 2, 2)
        self.curved = CurveBatch([c for c in curves if not isinstance(c, LineCurve)])
        self.chord = SEARCH_SHARE * reach
        parameters = [_dense(c.parameters(self.chord)) for c in self.curved.curves]
        self._span_curve = np.repeat(np.arange(len(self.curved)), [len(s) - 1 for s in parameters])
        self._span_s = np.concatenate([np.zeros((0, 2)), *(np.stack([s[:-1], s[1:]], axis=-1) for s in parameters)])
        self.spans = np.zeros((0, 2, 2))
        if len(self._span_s):
            ends = [self.curved.at(self._span_curve, s)[0] for s in self._span_s.T]
            self.spans = np.stack(ends, axis=1)

    @cached_property
    def _line_tree(self):
        import shapely

        return shapely.STRtree(shapely.linestrings(self.lines))

    @cached_property
    def _span_tree(self):
        import shapely

        return shapely.STRtree(shapely.linestrings(self.spans))

    def distances(self, points: Array) -> tuple[Array, Array]:
        """Distance (n,) in mm to the nearest curve, and the unit direction (n, 2) away from it."""
        import shapely

        copies = self.closure.copies_of(points, self.cut)
        q = self.closure.moved(points, -copies)
        best = np.full(len(q), np.inf)
        foot = np.zeros((len(q), 2))
        if len(self.lines):
            _, near = self._line_tree.query_nearest(shapely.points(q), all_matches=False)
            foot = _feet_on_segments(q, self.lines[near])
            best = np.hypot(*(q - foot).T)
        if len(self.spans):
            rows, feet = self._curved_feet(q, best)
            gaps = np.hypot(*(q[rows] - feet).T)
            # of several feet of one point the nearest comes first, and counts
            order = np.lexsort((gaps, rows))
            rows, at = np.unique(rows[order], return_index=True)
            nearer = gaps[order[at]] < best[rows]
            best[rows[nearer]], foot[rows[nearer]] = gaps[order[at[nearer]]], feet[order[at[nearer]]]
        away = self.closure.turned(q - foot, copies)
        return best, away / np.maximum(best, 1e-300)[:, None]

    def _curved_feet(self, q: Array, best: Array) -> tuple[Array, Array]:
        """Feet (m, 2) on the curved curves, and of which points: from each chord that may be nearest, nearer than `best`."""
        import shapely

        points = shapely.points(q)
        (_, _), reach = self._span_tree.query_nearest(points, return_distance=True, all_matches=False)
        asked = np.flatnonzero(reach - self.chord < best)
        found, spans = self._span_tree.query(points[asked], predicate="dwithin", distance=reach[asked] + 2.0 * self.chord)
        rows = asked[found]
        a, along = self.spans[spans, 0], self.spans[spans, 1] - self.spans[spans, 0]
        share = np.einsum("ij,ij->i", q[rows] - a, along) / np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
        s = self._span_s[spans, 0] + np.clip(share, 0.0, 1.0) * (self._span_s[spans, 1] - self._span_s[spans, 0])
        return rows, _feet(self.curved, self._span_curve[spans], s, q[rows])


def _dense(s: Array) -> Array:
    return np.unique(np.concatenate([s, 0.5 * (s[:-1] + s[1:])]))


def _feet(curves: CurveBatch, number: Array, s: Array, q: Array) -> Array:
    """Newton on (q - c(s)).c'(s) = 0 in [0, 1], never away from q; curvature by differences.

    What has been found is left out of the steps that follow.
    """
    p, d = curves.at(number, s)
    inner = np.clip(s, BEND_STEP, 1.0 - BEND_STEP)
    bend = (curves.at(number, inner + BEND_STEP)[1] - curves.at(number, inner - BEND_STEP)[1]) / (2.0 * BEND_STEP)
    out, open_ = p.copy(), np.arange(len(s))
    for _ in range(FOOT_STEPS):
        gap = np.hypot(*(q - p).T)
        square = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
        slope = square - np.einsum("ij,ij->i", q - p, bend)
        step = np.einsum("ij,ij->i", q - p, d) / np.where(slope > 0.1 * square, slope, square)
        new, there, onwards = _towards(curves, number, s, np.clip(s + step, 0.0, 1.0), q, gap)
        moved = new - s
        stays = np.isnan(moved)
        out[open_] = np.where(stays[:, None], p, there)
        more = ~stays & (np.abs(moved) >= FOOT_FOUND)
        if not more.any():
            break
        enough = np.abs(moved) > BEND_MOVE
        bend = np.where(enough[:, None], (onwards - d) / np.where(enough, moved, 1.0)[:, None], bend)
        open_, number, q, bend = open_[more], number[more], q[more], bend[more]
        s, p, d = new[more], there[more], onwards[more]
    return out


def _towards(curves: CurveBatch, number: Array, s: Array, new: Array, q: Array, gap: Array) -> tuple[Array, Array, Array]:
    """Parameters from `s` to `new`, halved until no farther from q than `gap`; NaN where no step helps; points, derivatives."""
    there, onwards = curves.at(number, new)
    worse = np.hypot(*(q - there).T) > gap + ROUNDING
    for _ in range(HALVINGS):
        if not worse.any():
            return new, there, onwards
        rows = np.flatnonzero(worse)
        new[rows] = 0.5 * (s[rows] + new[rows])
        there[rows], onwards[rows] = curves.at(number[rows], new[rows])
        worse[rows] = np.hypot(*(q[rows] - there[rows]).T) > gap[rows] + ROUNDING
    new[worse] = np.nan
    return new, there, onwards


def _feet_on_segments(q: Array, segments: Array) -> Array:
    """The nearest point (n, 2) of each segment (n, 2, 2) to each point (n, 2)."""
    p0, along = segments[:, 0], segments[:, 1] - segments[:, 0]
    size = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    share = np.clip(np.einsum("ij,ij->i", q - p0, along) / size, 0.0, 1.0)
    return p0 + share[:, None] * along


def ends_at_inset(outline: Outline, points: Array, outwards: Array, *, inset: float, limit: float | Array) -> Array:
    """Slide ends along their lines until they lie at `inset` (mm) from the outline; never nearer, never by more than `limit`.

    Parameters
    ----------
    points : ndarray, shape (n, 2)
        Ends that lie inside by `inset` or a little more.
    outwards : ndarray, shape (n, 2)
        Unit directions in which their lines leave the piece.
    limit : float or ndarray, shape (n,)
        In mm.
    """
    limit = np.broadcast_to(limit, len(points))
    moved, best = np.zeros(len(points)), np.zeros(len(points))
    open_ = np.arange(len(points))
    for _ in range(8):
        gap, away = outline.distances(points[open_] + moved[open_, None] * outwards[open_])
        good = gap >= inset - 1e-12
        best[open_] = np.where(good, np.maximum(moved[open_], best[open_]), best[open_])
        rate = np.minimum(np.einsum("ij,ij->i", away, outwards[open_]), -1e-3)
        # less than the gap at a time: an end does not step over the outline to where it is as far away on the other side
        new = moved[open_] + np.minimum((inset - gap) / rate, MOST_OF_GAP * gap)
        new = np.clip(new, 0.0, limit[open_])
        done = (good & (np.abs(gap - inset) <= 1e-12)) | (good & (new == moved[open_]))
        moved[open_] = np.where(done, moved[open_], new)
        open_ = open_[~done]
        if not len(open_):
            break
    if len(open_):
        gap, _ = outline.distances(points[open_] + moved[open_, None] * outwards[open_])
        moved[open_] = np.where(gap >= inset - 1e-10, moved[open_], best[open_])
    return points + moved[:, None] * outwards
