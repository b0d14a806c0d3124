"""As much metal as the piece has: the speed of each bead follows from the area that it has to fill.

In: the beads of a layer, its region. Out: the same beads with speed factors, and the metal of each piece over what it needs.

A bead fills what is nearer to it than to any other: half-way to its neighbours, and up to the outline. Where that is wider than
a step-over it is laid slower, where it is narrower faster, within limits, and towards its ends so that its round end fills up
what is before it. What no bead reaches (a lobe too narrow for one) is not made up for elsewhere: that metal is missing.

Words: *amount*, the inverse of a speed factor: metal per length over t d; *served*, the area that a piece's beads have to fill.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from brep_slicer.layers import NO_CLOSURE
from brep_slicer.maps import Array
from brep_slicer.region import Piece

from ..bead import Bead, BeadKind, LayerFill
from ..tools.inset import window_of
from ..tools.lobes import QUARTER_SEGMENTS, Shape
from ..tools.metal import ROUND_END, courses_of, metal_of
from ..tools.nearest import amounts_by_nearest
from ..tools.scanlines import directions
from ..tools.strips import strip_areas
from ..tools.within import LEAST_WITHIN, Within

# A straight bead that meets the outline squarely, half a bead inside of it, needs this much more metal at its very end: its
# round end holds 3 pi / 32 w of the w / 2 that are left there, and the rest is laid on the way to it, over another w / 2.
SQUARE_END = (0.5 - ROUND_END) / (0.25 + ROUND_END)
# Metal is added over so many widths before an end, and taken away over so many.
MORE_OVER, LESS_OVER = 0.5, 1.0
# Beads lie on one line, and run the same way, within this share of the step-over.
ALIKE = 1e-6
# The beads of a piece are all laid slower or faster by this share at most so that its metal comes out: where strips were
# measured, and where they were not.
MOST_MEASURED, MOST_ELSE = 0.25, 0.5
# Along a skeleton the width is measured this often (of the step-over).
EVERY = 0.5
# Metal is what it should be within this share.
CLOSE = 1e-4


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Laid:
    """The beads of one piece as `points` with their `amounts`, and the area `served` (mm**2); how far all may be scaled."""

    points: list[Array]
    amounts: list[Array]
    served: float
    most: float


def wanted_area(shape: Shape, beads: Sequence[Bead], *, inset: float, step_over: float) -> float:
    """The area (mm**2) that a piece's beads have to fill: its own, and more where bead centres come near its outline."""
    return shape.piece.area() if 0.5 * step_over <= inset else wanted_ground(shape, beads, inset, step_over).area


def wanted_ground(shape: Shape, beads: Sequence[Bead], inset: float, step_over: float):
    """What a piece's beads have to fill, as a polygon.

    A bead lays as much to either side. Where its centre is nearer to the outline than half a step-over (fit on or out), what it
    lays beyond is wanted, too.
    """
    import shapely

    beyond = 0.5 * step_over - inset
    if beyond <= 0.0:
        return shape.once
    piece = shape.piece
    lines = shapely.MultiLineString([piece.closure.moved(bead.points, k) for bead in beads for k in piece.beside])
    beside = lines.buffer(0.5 * step_over, cap_style="square", quad_segs=QUARTER_SEGMENTS)
    return shape.once.union(grown(shape, beyond).intersection(beside))


def grown(shape: Shape, distance: float):
    """A piece's polygon moved outwards by `distance` (mm; negative: inwards); one turn of one that goes all the way round."""
    if not distance:
        return shape.once
    moved = shape.whole.buffer(distance, quad_segs=QUARTER_SEGMENTS)
    return moved.intersection(window_of(shape.piece, moved)) if shape.piece.winds else moved


def metal_shares(
    beads: Sequence[Bead],
    shapes: Sequence[Shape],
    *,
    step_over: float,
    width: float,
    copies: Sequence[int] = (),
) -> list[tuple[float, float]]:
    """For each piece (the metal of its beads within its outline, the rest of it), over what the piece holds.

    `copies` have what the piece that they equal has.
    """
    mine: list[list[Bead]] = [[] for _ in shapes]
    for bead in beads:
        mine[bead.piece].append(bead)
    out: list[tuple[float, float]] = []
    for i, (shape, each) in enumerate(zip(shapes, mine, strict=True)):
        if copies and copies[i] != i:
            out.append(out[copies[i]])
            continue
        area = shape.piece.area()
        inside = float(metal_of(each, step_over=step_over, width=width, within=Within(shape, width)).sum())
        whole = float(metal_of(each, step_over=step_over, width=width).sum())
        out.append((inside / area, max(whole - inside, 0.0) / area) if area > 0.0 else (0.0, 0.0))
    return out


def metal_from_beside(beads: Sequence[Bead], shapes: Sequence[Shape], *, step_over: float, width: float) -> list[float]:
    """For each piece what the beads of other pieces lay within its outline, over what it holds."""
    import shapely

    out = [0.0] * len(shapes)
    if len(shapes) < 2 or not beads:
        return out
    mine: list[list[Bead]] = [[] for _ in shapes]
    for bead in beads:
        mine[bead.piece].append(bead)
    boxes = np.array([shape.piece.bounds() for shape in shapes])
    reached = boxes.copy()
    for i, each in enumerate(mine):
        if each:
            points = np.concatenate([bead.points for bead in each])
            reached[i] = (*points.min(axis=0), *points.max(axis=0))
    closure = shapes[0].piece.closure
    meets = closure.boxes_meet(boxes, reached, 0.5 * width)
    np.fill_diagonal(meets, False)
    for i in np.flatnonzero(meets.any(axis=1)).tolist():
        shape = shapes[i]
        turns = (0,) if shape.piece.winds else closure.beside
        others = [bead for j in np.flatnonzero(meets[i]).tolist() for bead in mine[j]]
        moved = [replace(bead, points=closure.moved(bead.points, k)) for k in turns for bead in others]
        near = shapely.dwithin(shape.whole, [shapely.LineString(bead.points) for bead in moved], 0.5 * width)
        laid = metal_of(
            [bead for bead, flag in zip(moved, near, strict=True) if flag],
            step_over=step_over,
            width=width,
            within=Within(shape, width),
        )
        out[i] = float(laid.sum()) / max(shape.piece.area(), 1e-300)
    return out


def with_balanced_metal(
    fill: LayerFill,
    *,
    step_over: float,
    width: float,
    inset: float,
    limits: tuple[float, float],
    even: bool = False,
) -> tuple[Bead, ...]:
    """Beads with speed factors between `limits` that give each piece its metal, in the order that they have.

    With `even`, the factors that they have already are scaled piece by piece, and not chosen anew.
    """
    mine: dict[int, list[int]] = {}
    for i, bead in enumerate(fill.beads):
        mine.setdefault(bead.piece, []).append(i)
    out = list(fill.beads)
    amounts = (1.0 / limits[1], 1.0 / limits[0])
    for index, numbers in mine.items():
        leader = index if even or not fill.copies else fill.copies[index]
        if leader != index:
            for i, k in zip(numbers, mine[leader], strict=True):
                way = fill.beads[i].points[0] - fill.beads[k].points[0]
                out[i] = replace(fill.beads[i], points=out[k].points + way, speed=out[k].speed)
            continue
        shape = fill.shapes[index]
        task = _Task(
            shape=shape,
            beads=[fill.beads[i] for i in numbers],
            step_over=step_over,
            width=width,
            inset=inset,
            border=fill.border[index],
            limits=amounts,
        )
        for i, bead in zip(numbers, _scaled(task, task.as_it_is() if even else task.laid()), strict=True):
            out[i] = bead
    return tuple(out)


def _scaled(task: _Task, laid: Laid) -> list[Bead]:
    """The beads with their amounts within the limits, all scaled so that they hold the metal that they have to."""
    low, high = task.limits
    courses = courses_of(laid.points, [bead.closed for bead in task.beads], task.width).within(task.within)
    # of what lies beyond the outline because the fit asks for it, the piece gets nothing
    served = laid.served / task.wanted * task.shape.piece.area()
    chosen = np.concatenate(laid.amounts)
    amounts = np.clip(chosen, low, high)
    factor = 1.0
    for _ in range(4):
        metal = float(courses.metal(1.0 / amounts, task.step_over).sum())
        if abs(metal - served) <= CLOSE * served or metal <= 0.0:
            break
        factor = min(max(factor * served / metal, 1.0 - laid.most), 1.0 + laid.most)
        amounts = np.clip(factor * chosen, low, high)
    speeds = np.split(1.0 / amounts, courses.first[1:])
    return [replace(b, points=p, speed=s) for b, p, s in zip(task.beads, laid.points, speeds, strict=True)]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Task:
    """One piece with its beads."""

    shape: Shape
    beads: list[Bead]
    step_over: float
    width: float
    inset: float
    border: float
    limits: tuple[float, float]

    @cached_property
    def wanted(self) -> float:
        return wanted_area(self.shape, self.beads, inset=self.inset, step_over=self.step_over)

    @cached_property
    def within(self) -> Within:
        return Within(self.shape, self.width)

    def as_it_is(self) -> Laid:
        """The amounts that the beads have."""
        amounts = [np.ones(len(b.points)) if b.speed is None else 1.0 / b.speed for b in self.beads]
        return Laid(points=[b.points for b in self.beads], amounts=amounts, served=self.wanted, most=MOST_ELSE)

    def laid(self) -> Laid:
        """The amounts by what kinds of beads there are."""
        straight = [i for i, b in enumerate(self.beads) if b.kind in (BeadKind.HATCH, BeadKind.RING, BeadKind.HELIX)]
        straight = straight or [i for i, b in enumerate(self.beads) if b.kind is BeadKind.FLANK]
        others = {b.kind for i, b in enumerate(self.beads) if i not in set(straight)}
        angle = _common_angle([self.beads[i] for i in straight])
        if angle is not None and others <= {BeadKind.CONTOUR, BeadKind.SKELETON}:
            return self._by_strips(straight, angle)
        if not straight and others == {BeadKind.SKELETON}:
            return self._along_skeletons(range(len(self.beads)), self.wanted)
        return self._by_nearest()

    def _by_nearest(self) -> Laid:
        ground = wanted_ground(self.shape, self.beads, self.inset, self.step_over)
        piece = self.shape.piece
        closure = piece.closure if piece.winds else NO_CLOSURE
        points, amounts, share = amounts_by_nearest(
            ground, self.beads, step_over=self.step_over, width=self.width, closure=closure, within=self.within
        )
        return Laid(points=points, amounts=amounts, served=share * self.wanted, most=MOST_ELSE)

    def _by_strips(self, straight: list[int], angle: float) -> Laid:
        """Straight beads by their strips, contours by what is outside of those, skeletons of lobes by their width."""
        kinds = [b.kind for b in self.beads]
        contours = [i for i, kind in enumerate(kinds) if kind is BeadKind.CONTOUR]
        skeletons = [i for i, kind in enumerate(kinds) if kind is BeadKind.SKELETON]
        lobes = self.shape.lobes if self.inset >= 0.499 * self.width or skeletons else ()
        beyond = max(0.0, 0.5 * self.step_over - self.inset)
        inner = (
            grown(self.shape, -self.border) if contours else wanted_ground(self.shape, self.beads, self.inset, self.step_over)
        )
        wanted = self.wanted
        in_lobes = sum(lobe.area for lobe in lobes)
        if lobes:
            inner = _without(inner, lobes, self.shape.piece)
        points: list[Array] = [np.zeros((0, 2))] * len(self.beads)
        amounts: list[Array] = [np.zeros(0)] * len(self.beads)
        served = 0.0
        whole = self.shape.once.area + 1e-300

        def put(numbers, laid: Laid) -> None:
            nonlocal served
            served += laid.served
            for k, i in enumerate(numbers):
                points[i], amounts[i] = laid.points[k], laid.amounts[k]

        # the polygon errs by its chord: all areas are brought to what the exact curves enclose
        exact = 1.0 if beyond else wanted / whole
        put(straight, self._straight(straight, angle, inner, exact))
        if contours:
            put(contours, self._contours(contours, wanted - exact * (inner.area + in_lobes)))
        if skeletons:
            put(skeletons, self._along_skeletons(skeletons, exact * in_lobes))
        slanted = self.shape.piece.winds and abs(np.sin(angle)) > ALIKE
        return Laid(points=points, amounts=amounts, served=served, most=MOST_ELSE if slanted else MOST_MEASURED)

    def _straight(self, numbers: list[int], angle: float, ground, exact: float) -> Laid:
        ends = np.array([self.beads[i].points for i in numbers])
        is_open = ~np.array([self.beads[i].closed for i in numbers])
        lengths = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
        caps = np.where(is_open, 2.0 * ROUND_END * self.width, 0.0)
        served = exact * ground.area
        if self.shape.piece.winds and abs(np.sin(angle)) > ALIKE:
            base, extra = np.ones(len(ends)), np.full(len(ends), SQUARE_END)
        else:
            base, extra = self._by_lines(ends, angle, lengths, caps, ground, exact)
        points, amounts = _ramped(ends, lengths, base, np.where(is_open, extra, 0.0), self.width)
        return Laid(points=points, amounts=amounts, served=served, most=MOST_MEASURED)

    def _by_lines(self, ends: Array, angle: float, lengths: Array, caps: Array, ground, exact: float) -> tuple[Array, Array]:
        """For each bead the amount along its middle, and the share more of it at its ends."""
        low, high = self.limits
        y = ends.mean(axis=1) @ directions(angle)[1]
        order = np.argsort(y)
        new = np.append(True, np.diff(y[order]) > ALIKE * self.step_over)
        line = np.empty(len(y), dtype=int)
        line[order] = np.cumsum(new) - 1
        places = y[order][new]
        areas = exact * strip_areas(ground, angle, places)
        held = lengths + caps
        want = areas[line] * held / np.bincount(line, weights=held)[line] / self.step_over
        spaces = np.full(len(places), np.nan)
        spaces[1:-1] = 0.5 * (places[2:] - places[:-2])
        base = spaces[line] / self.step_over
        with np.errstate(invalid="ignore"):
            short = want / base - held
            extra = short / np.where(short > 0.0, *(_over(lengths, m * self.width) + caps for m in (MORE_OVER, LESS_OVER)))
            extra = np.clip(extra, np.maximum(low / base - 1.0, -0.5), np.maximum(high / base - 1.0, 0.0))
        # the outermost lines have no middle between neighbours: all along them the amount is what their strip asks for
        extra = np.where(np.isfinite(extra), extra, SQUARE_END)
        extra = np.where(caps > 0.0, extra, 0.0)
        over = np.where(extra > 0.0, _over(lengths, MORE_OVER * self.width), _over(lengths, LESS_OVER * self.width))
        return want / np.maximum(held + extra * (over + caps), 1e-300), extra

    def _contours(self, numbers: list[int], area: float) -> Laid:
        """Contours share what they fill by their lengths; the outermost ones fill up to the outline."""
        import shapely

        beads = [self.beads[i] for i in numbers]
        edge = self.shape.whole.boundary
        outermost = np.array([shapely.Point(b.points[0]).distance(edge) for b in beads]) < self.inset + 0.5 * self.step_over
        share = np.where(outermost, (max(self.inset, 0.5 * self.step_over) + 0.5 * self.step_over) / self.step_over, 1.0)
        weight = float((share * [b.length() for b in beads]).sum()) * self.step_over
        share = share * max(area, 0.0) / max(weight, 1e-300)
        amounts = [np.full(len(b.points), s) for b, s in zip(beads, share, strict=True)]
        return Laid(points=[b.points for b in beads], amounts=amounts, served=max(area, 0.0), most=MOST_MEASURED)

    def _along_skeletons(self, numbers: Sequence[int], area: float) -> Laid:
        """Beads along skeletons: by the width that they run through, all scaled to the area."""
        import shapely

        edge = self.shape.whole.boundary
        shapely.prepare(edge)
        lines = [shapely.segmentize(shapely.LineString(self.beads[i].points), EVERY * self.step_over) for i in numbers]
        points = [shapely.get_coordinates(line) for line in lines]
        counts = np.cumsum([len(p) for p in points])[:-1]
        places = np.concatenate(points)
        widths = 2.0 * shapely.distance(shapely.points(places), edge)
        ways = np.concatenate([np.gradient(p, axis=0) for p in points])
        ways /= np.maximum(np.hypot(*ways.T), 1e-300)[:, None]
        shares = np.maximum(self.within.shares(places, ways), LEAST_WITHIN)
        amounts = np.split(np.maximum(widths / self.step_over / shares, 1e-6), counts)
        courses = courses_of(points, [self.beads[i].closed for i in numbers], self.width).within(self.within)
        metal = float(courses.metal(1.0 / np.concatenate(amounts), self.step_over).sum())
        return Laid(points=points, amounts=[a * area / metal for a in amounts], served=area, most=MOST_ELSE)


def _common_angle(beads: Sequence[Bead]) -> float | None:
    """The direction (rad) of straight beads that are all parallel, or None."""
    if not beads or any(len(b.points) != 2 for b in beads):
        return None
    ends = np.array([b.points for b in beads])
    ways = ends[:, 1] - ends[:, 0]
    lengths = np.hypot(*ways.T)
    longest = ways[lengths.argmax()] / lengths.max()
    off = np.abs(ways[:, 0] * longest[1] - ways[:, 1] * longest[0])
    return None if (off > ALIKE * lengths.max()).any() else float(np.arctan2(longest[1], longest[0]))


def _without(ground, lobes, piece: Piece):
    """A piece's polygon without lobes; of a full turn, without their copies a turn away, too."""
    import shapely

    copies = [piece.closure.motion(turns).shape(lobe) for lobe in lobes for turns in piece.beside]
    return ground.difference(shapely.union_all(copies))


def _over(lengths: Array, most: float) -> Array:
    """How far from an end metal is added or taken away: not beyond the middle."""
    return np.minimum(most, 0.5 * lengths)


def _ramped(ends: Array, lengths: Array, base: Array, extra: Array, width: float) -> tuple[list[Array], list[Array]]:
    """Beads (points, amounts) that hold `base` along their middle and (1 + extra) times that at their ends."""
    over = np.where(extra > 0.0, _over(lengths, MORE_OVER * width), _over(lengths, LESS_OVER * width))
    share = np.where(lengths > 0.0, over / np.maximum(lengths, 1e-300), 0.0)[:, None]
    a, b = ends[:, 0], ends[:, 1]
    whole = np.stack([a, a + share * (b - a), b - share * (b - a), b], axis=1)
    amounts = np.stack([base * (1.0 + extra), base, base, base * (1.0 + extra)], axis=1)
    plain = np.abs(extra) < ALIKE
    # a bead that is short has no middle: its two ramps meet
    rows = [np.array(r) for r in ([0, 3], [0, 1, 3], [0, 1, 2, 3])]
    kind = np.where(plain, 0, np.where(share[:, 0] > 0.5 - 1e-9, 1, 2)).tolist()
    return [p[rows[k]] for p, k in zip(whole, kind, strict=True)], [v[rows[k]] for v, k in zip(amounts, kind, strict=True)]
