"""Regions of several solids joined, or taken from one another, on their exact curves.

In: regions on one sheet. Out: their union or difference, with the curves' kinds kept.

1. Where does each outline come near to the other (`contacts`)? There its curves are cut.
2. Ends of cuts that lie within a touch of each other are one node.
3. A piece of outline *apart* from the other is kept or not by whether it lies inside of it; one that runs *along* the other is
   kept once where the metal of both is on one side, and dropped where it is between the two: what touches is joined.
4. What is kept is chained from node to node; where one outline goes over into the other, both are cut again where they cross.
5. On either side of every cut curve the result must hold metal exactly where it should, or the next coarser touch is tried.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from brep_slicer.curves import Curve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.groups import groups_of_pairs
from brep_slicer.layers import Closure, Sheet
from brep_slicer.maps import Array
from brep_slicer.section.chain import Arc, loops_from_arcs

from .contacts import contacts
from .outline import REACH, Outline, drawn_near_each_other, drawn_near_points, projected
from .pieces import Piece
from .region import Region, region_from_loops

Box = tuple[float, float, float, float]

# Two outlines that come as near as this touch, mm: ten times what edges of good files gape. A coarser one where that fails.
TOUCHES = (1e-6, 1e-5)
# Ends this many touches from each other are one node; a piece of outline no longer than that between them is none.
NODE = 3.0
# A stretch within a touch of the other outline whose direction takes it this many touches away is where the two cross or part,
# if it is no longer than so many: lines that cross at 2e-4 rad.
LEAVES, CROSSING = 0.3, 1e4
# Polylines near the other outline are drawn to this share of a touch.
FINE = 0.1
# Where the result is asked on which side its metal lies, in touches from the outline.
SIDE = 4.0


def union_of_regions(sheet: Sheet, regions: Sequence[Region]) -> Region:
    """The union of regions on a sheet; those that touch are one piece.

    Raises
    ------
    LayerError
        If the outlines cross in a way that does not close.
    """
    parts = sorted((region for region in regions if not region.is_empty), key=lambda region: region.pieces[0].bounds())
    while len(parts) > 1:
        # neighbours first, so that no outline is drawn more often than there are rounds
        joined = [_overlay(a, b, union=True) for a, b in zip(parts[0::2], parts[1::2], strict=False)]
        parts = joined + parts[2 * len(joined) :]
    return parts[0] if parts else Region(sheet=sheet)


def difference_of_regions(region: Region, other: Region) -> Region:
    """What of `region` lies outside of `other`.

    Raises
    ------
    LayerError
        If the outlines cross in a way that does not close.
    """
    if region.is_empty or other.is_empty:
        return region
    return _overlay(region, other, union=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Cut:
    """A piece of outline: a curve's parameters, from node to node."""

    parent: Curve
    number: int
    first: bool  # of the first region's outline
    span: tuple[float, float]
    start: int
    end: int
    along: bool  # runs along the other outline

    def points(self, share: float) -> Array:
        s0, s1 = self.span
        return self.parent.points(np.array([s0 + share * (s1 - s0)]))[0]


def _overlay(a: Region, b: Region, *, union: bool) -> Region:
    """The pieces of both whose boxes meet are overlaid, the others stay as they are."""
    flags = _meeting([p.bounds() for p in a.pieces], [p.bounds() for p in b.pieces], a.closure)
    (near_a, far_a), (near_b, far_b) = (_parted(region, near) for region, near in zip((a, b), flags, strict=True))
    found = _near_overlaid(near_a, near_b, union) if near_a.pieces and near_b.pieces else near_a
    pieces = found.pieces + far_a + (far_b if union else ())
    return Region(sheet=a.sheet, pieces=pieces, touch=max(a.touch, b.touch, found.touch))


def _parted(region: Region, near: Array) -> tuple[Region, tuple[Piece, ...]]:
    """A region's pieces with a flag, (n,) of bool, and those without."""
    pieces = tuple(piece for piece, flag in zip(region.pieces, near, strict=True) if flag)
    return replace(region, pieces=pieces), tuple(piece for piece, flag in zip(region.pieces, near, strict=True) if not flag)


def _near_overlaid(a: Region, b: Region, union: bool) -> Region:
    boxes, others = ([c.bounds() for loop in r.loops for c in loop.curves] for r in (a, b))
    near = _meeting(boxes, others, a.closure)
    if not any(flags.any() for flags in near) and not _nested(a, b):
        return replace(a, pieces=a.pieces + b.pieces if union else a.pieces)
    reasons = []
    for touch in TOUCHES:
        try:
            return replace(_Overlay(a, b, near, touch).result(union=union), touch=touch)
        except LayerError as error:
            reasons.append(f"{error} (touch {touch:g} mm)")
    raise LayerError(
        f"the sections of two solids at {a.sheet.label} overlap in a way that cannot be resolved: {'; '.join(reasons)}"
    )


def _meeting(first: Sequence[Box], second: Sequence[Box], closure: Closure) -> tuple[Array, Array]:
    """Which boxes (kappa_min, v_min, kappa_max, v_max) of either kind meet one of the other, (n,) and (m,) of bool."""
    meets = closure.boxes_meet(np.array(first), np.array(second), TOUCHES[-1])
    return np.asarray(meets.any(axis=1)), np.asarray(meets.any(axis=0))


def _nested(a: Region, b: Region) -> bool:
    """Whether outlines that do not meet lie inside of one another."""
    outlines = [Outline(r) for r in (a, b)]
    starts = [np.array([loop.curves[0].start for loop in r.loops]) for r in (a, b)]
    return bool(outlines[0].contains(starts[1]).any() or outlines[1].contains(starts[0]).any())


class _Overlay:
    """Two regions whose outlines are cut where they come within `touch` mm of each other."""

    def __init__(self, a: Region, b: Region, near: tuple[Array, Array], touch: float) -> None:
        self.sheet, self.closure, self.touch = a.sheet, a.closure, touch
        self.near = near
        self.regions, self.outlines = (a, b), drawn_near_each_other(a, b, FINE * touch)
        nodes = itertools.count()
        self.cuts = self._identified([cut for first in (True, False) for cut in self._cut(first, nodes)])

    def result(self, *, union: bool) -> Region:
        """The union, or the first region without the second."""
        kept = self._kept(union)
        arcs = []
        for cut in _rejoined(self._met(kept)):
            curve = cut.parent.trimmed(*cut.span)
            reverse = not (union or cut.first)
            arcs.append(
                Arc(curve=curve.reversed(), start=cut.end, end=cut.start)
                if reverse
                else Arc(curve=curve, start=cut.start, end=cut.end)
            )
        # what is no wider than a node is a scrap of how the outlines were met
        loops = [loop for loop in loops_from_arcs(self.sheet, arcs) if loop.winding or not self._is_scrap(loop)]
        region = region_from_loops(self.sheet, loops)
        self._check(region, union)
        return region

    def _is_scrap(self, loop: Loop) -> bool:
        return 2.0 * abs(loop.signed_area()) <= NODE * self.touch * loop.length()

    def _cut(self, first: bool, nodes: Iterator[int]) -> list[_Cut]:
        """One region's curves in pieces; a loop's curves share the nodes between them."""
        own, other = self.outlines if first else self.outlines[::-1]
        flags = self.near[0 if first else 1]
        marks = self._marks(own, other)
        out: list[_Cut] = []
        number = 0
        for loop in own.loops:
            joints = [next(nodes) for _ in loop.curves]
            for i, curve in enumerate(loop.curves):
                runs = contacts(curve, other, marks[number], self.touch, FINE * self.touch) if flags[number] else []
                places = _places(runs, marks[number])
                names = [joints[i], *(next(nodes) for _ in places[1:-1]), joints[(i + 1) % len(joints)]]
                for span, (start, end) in zip(itertools.pairwise(places), itertools.pairwise(names), strict=True):
                    along = any(r0 <= span[0] and span[1] <= r1 for r0, r1 in runs)
                    out.append(_Cut(parent=curve, number=number, first=first, span=span, start=start, end=end, along=along))
                number += 1
        return out

    def _marks(self, own: Outline, other: Outline) -> list[Array]:
        """For each of one outline's curves, the parameters nearest to the ends of the other's that lie on it."""
        at = own.nearest(other.ends)
        touching = at.distances <= self.touch
        return [at.parameters[touching & (at.curves == i)] for i in range(len(own.curves))]

    def _identified(self, cuts: list[_Cut]) -> list[_Cut]:
        """Nodes that lie together made one, of one outline too; pieces that are only crossings are gone."""
        near = [cut for cut in cuts if cut.along]
        gone = {id(cut): (cut.start, cut.end) for cut in near if self._is_crossing(cut)}
        places = {node: cut.points(share) for cut in cuts for node, share in ((cut.start, 0.0), (cut.end, 1.0))}
        names = list(places)
        at = self.closure.canonical(np.array(list(places.values())))
        met = {node for cut in near for node in (cut.start, cut.end)}
        close = [(names[i], names[j]) for i, j in self._pairs(at, NODE * self.touch)]
        # ends that no piece along the other outline has are one only where an outline touches itself
        same = {(names[i], names[j]) for i, j in self._pairs(at, FINE * self.touch)}
        pairs = [pair for pair in close if met.issuperset(pair) or pair in same]
        group = _groups(names, pairs + list(gone.values()))
        left = [replace(c, start=group.get(c.start, c.start), end=group.get(c.end, c.end)) for c in cuts if id(c) not in gone]
        return [c for c in left if c.start != c.end or self._length(c) > 3.0 * NODE * self.touch]

    def _pairs(self, points: Array, reach: float) -> set[tuple[int, int]]:
        """Which of `points` (n, 2; of one turn) lie within `reach` mm of each other, or of each other's copies: i < j."""
        from scipy.spatial import cKDTree

        tree, found = cKDTree(points), set()
        for turns in self.closure.beside:
            copies = cKDTree(self.closure.moved(points, turns))
            found |= {(i, j) for i, near in enumerate(tree.query_ball_tree(copies, reach)) for j in near if i < j}
        return found

    def _is_crossing(self, cut: _Cut) -> bool:
        """Whether a piece within a touch of the other outline runs away from it, not along it."""
        length = self._length(cut)
        if length > CROSSING * self.touch:
            return False
        s = cut.span[0] + np.array([0.02, 0.5, 0.98]) * (cut.span[1] - cut.span[0])
        own = cut.parent.derivatives(s)
        at = self.outlines[1 if cut.first else 0].nearest(cut.parent.points(s)).directions
        sine = np.abs(own[:, 0] * at[:, 1] - own[:, 1] * at[:, 0]) / np.maximum(np.hypot(*own.T), 1e-300)
        return length * float(sine.max()) > LEAVES * self.touch

    @staticmethod
    def _length(cut: _Cut) -> float:
        return cut.parent.trimmed(*cut.span).length()

    def _kept(self, union: bool) -> list[_Cut]:
        """The pieces that bound the result."""
        kept: list[_Cut] = []
        for first in (True, False):
            own = [cut for cut in self.cuts if cut.first == first]
            if not own:
                continue
            other = self.outlines[1 if first else 0]
            points = np.array([[cut.points(share) for share in (0.25, 0.5, 0.75)] for cut in own])
            at = other.nearest(points.reshape(-1, 2))
            # a piece apart is judged where it is farthest from the other outline, one along it in its middle
            where = at.distances.reshape(-1, 3).argmax(axis=1)
            rows = np.arange(len(own))
            inside = other.contains(points[rows, where])
            for i, cut in enumerate(own):
                if cut.along:
                    direction = cut.parent.derivatives(np.array([0.5 * sum(cut.span)]))[0]
                    same = float(direction @ at.directions[3 * i + 1]) > 0.0
                    keep = first and same == union
                else:
                    keep = bool(inside[i]) != (union or first)
                if keep:
                    kept.append(cut)
        return kept

    def _met(self, kept: list[_Cut]) -> list[_Cut]:
        """Where one outline goes over into the other at a node, both end where their curves cross."""
        cuts = list(kept)
        for node, i, j in _joints(cuts):
            cuts[i], cuts[j] = self._crossed(cuts[i], cuts[j], node)
        return cuts

    def _crossed(self, a: _Cut, b: _Cut, node: int) -> tuple[_Cut, _Cut]:
        """Both pieces ended where their curves cross or, if they run into one another, where one of the curves itself ends."""
        side_a, side_b = int(a.end == node), int(b.end == node)
        s, t = a.span[side_a], b.span[side_b]
        turns = float(self.closure.nearest_turns(b.points(side_b), a.points(side_a)))
        other = b.parent.moved(self.closure.motion(turns)) if turns else b.parent
        trials = [(s, t), _polished(a.parent, other, s, t)]
        trials += [(e, _beside(other, t, a.parent.points(np.array([e])))) for e in (s, float(side_a))]
        trials += [(_beside(a.parent, s, other.points(np.array([e]))), e) for e in (t, float(side_b))]
        gaps = [self._gap(a.parent, other, (s, t), trial) for trial in trials]
        for (s, t), _ in sorted(zip(trials, gaps, strict=True), key=lambda pair: pair[1]):
            if (s > a.span[0] if side_a else s < a.span[1]) and (t > b.span[0] if side_b else t < b.span[1]):
                return _ended(a, side_a, s), _ended(b, side_b, t)
        return a, b

    def _gap(self, a: Curve, b: Curve, before: tuple[float, float], after: tuple[float, float]) -> float:
        """How far two curves gape where they are ended after all; infinite where that is too far from where they were cut."""
        (p0, p), (q0, q) = (c.points(np.array([u, v])) for c, u, v in zip((a, b), before, after, strict=True))
        da, db = (c.derivatives(np.array([u]))[0] for c, u in zip((a, b), after, strict=True))
        sine = abs(da[0] * db[1] - da[1] * db[0]) / max(np.hypot(*da) * np.hypot(*db), 1e-300)
        reach = (NODE + 1.0) * self.touch
        moved = max(np.hypot(*(p - p0)), np.hypot(*(q - q0)))
        return float(np.hypot(*(p - q))) if moved * max(sine, REACH * reach / self.outlines[0].reach) <= reach else np.inf

    def _check(self, region: Region, union: bool) -> None:
        """Hold the result against both regions on either side of every piece that was cut.

        Raises
        ------
        LayerError
            If it has metal where there is none to be, or lacks some.
        """
        probes = []
        for cut in self.cuts:
            if self.near[0 if cut.first else 1][cut.number]:
                s = np.array([0.5 * sum(cut.span)])
                along = cut.parent.derivatives(s)[0]
                left = np.array([-along[1], along[0]]) / max(np.hypot(*along), 1e-300)
                middle = cut.parent.points(s)[0]
                probes += [middle + SIDE * self.touch * left, middle - SIDE * self.touch * left]
        if not probes:
            return
        points = np.array(probes)
        a, b, result = (drawn_near_points(r, points, FINE * self.touch) for r in (*self.regions, region))
        free = (a.nearest(points).distances > self.touch) & (b.nearest(points).distances > self.touch)
        in_a, in_b = a.contains(points[free]), b.contains(points[free])
        wanted = in_a | in_b if union else in_a & ~in_b
        wrong = int(np.sum(result.layers(points[free]) != wanted))
        if wrong:
            raise LayerError(f"metal at {wrong} of {len(wanted)} probed places is wrong")


def _groups(names: list[int], pairs: list[tuple[int, int]]) -> dict[int, int]:
    """For each of `names`, the one that stands for all that `pairs` connect it with."""
    place = {name: i for i, name in enumerate(names)}
    ends = np.array([(place[a], place[b]) for a, b in pairs], dtype=int).reshape(-1, 2)
    labels = groups_of_pairs(len(names), ends)
    _, first = np.unique(labels, return_index=True)
    return {name: names[first[label]] for name, label in zip(names, labels, strict=True)}


def _joints(cuts: list[_Cut]) -> list[tuple[int, int, int]]:
    """Nodes at which one piece of either outline is alone with one of the other, and which two those are."""
    at: dict[int, list[int]] = {}
    for i, cut in enumerate(cuts):
        at.setdefault(cut.start, []).append(i)
        at.setdefault(cut.end, []).append(i)
    pairs = [(node, p[0], p[1]) for node, p in at.items() if len(p) == 2]
    return [(node, i, j) for node, i, j in pairs if cuts[i].first != cuts[j].first]


def _ended(cut: _Cut, side: int, s: float) -> _Cut:
    return replace(cut, span=(cut.span[0], s) if side else (s, cut.span[1]))


def _places(runs: list[tuple[float, float]], marks: Array) -> list[float]:
    """Where a curve is cut, its ends included: at the ends of its runs along the other outline, and at marks inside of them."""
    inner = [float(m) for m in marks if any(r0 < m < r1 for r0, r1 in runs)]
    return sorted({0.0, 1.0, *itertools.chain(*runs), *inner})


def _rejoined(cuts: list[_Cut]) -> list[_Cut]:
    """Pieces of one curve that follow one another at a node of their own, as one."""
    degree: dict[int, int] = {}
    for cut in cuts:
        for node in (cut.start, cut.end):
            degree[node] = degree.get(node, 0) + 1
    out: list[_Cut] = []
    for cut in sorted(cuts, key=lambda c: (not c.first, c.number, c.span[0])):
        last = out[-1] if out else None
        follows = last is not None and (last.first, last.number) == (cut.first, cut.number)
        if last is not None and follows and last.end == cut.start and degree[cut.start] == 2:
            out[-1] = replace(last, span=(last.span[0], cut.span[1]), end=cut.end)
        else:
            out.append(cut)
    return out


def _polished(a: Curve, b: Curve, s: float, t: float) -> tuple[float, float]:
    """Parameters at which two curves cross, by Newton from some nearby."""
    for _ in range(12):
        gap = b.points(np.array([t]))[0] - a.points(np.array([s]))[0]
        da, db = a.derivatives(np.array([s]))[0], b.derivatives(np.array([t]))[0]
        det = da[0] * -db[1] + da[1] * db[0]
        if det == 0.0:
            break
        s = min(max(s + (gap[0] * -db[1] + gap[1] * db[0]) / det, 0.0), 1.0)
        t = min(max(t + (da[0] * gap[1] - da[1] * gap[0]) / det, 0.0), 1.0)
    return s, t


def _beside(curve: Curve, s: float, point: Array) -> float:
    """The parameter near `s` at which a curve is nearest to a point (1, 2)."""
    return float(projected(curve, np.array([s]), point)[0][0])
