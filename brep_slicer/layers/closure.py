"""The rigid motion of the plane that takes one side of a sheet's chart to the other.

In: points, boxes, shapes in the plane of a sheet. Out: their copies, whole turns away, and which copy is which.

A sheet is unrolled from the generator at theta = 0. Once round the axis, the chart lies beside its own beginning: moved along
kappa by 2 pi R on a cylinder, turned about the apex by 2 pi sin(alpha) on a cone. A plane has no other side. Both motions, and
all between them, are one formula in `length` and `angle`, which does not lose digits as the angle goes to 0.

Words: *turn*, once round the axis, a real number from the generator at theta = 0; *copy*, the same thing whole turns away.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from brep_slicer.maps import TURN, Array

if TYPE_CHECKING:
    from shapely import Polygon

# Segments in which the sides of a window are drawn a turn, where they are arcs: the window is cut outside of what it holds.
ARC_SEGMENTS = 720


class Motion(NamedTuple):
    """A rigid motion of the plane: q = (x cos + y sin, y cos - x sin) + (dx, dy)."""

    cos: float
    sin: float
    dx: float
    dy: float

    @property
    def is_translation(self) -> bool:
        """Whether directions stay as they are."""
        return self.sin == 0.0 and self.cos == 1.0

    @property
    def along_kappa(self) -> float:
        """By how far a motion along kappa moves, mm.

        Raises
        ------
        ValueError
            If it is another one.
        """
        if not self.is_translation or self.dy != 0.0:
            raise ValueError("a curve that is drawn on a cylinder cannot be moved but along kappa")
        return self.dx

    def points(self, points: Array) -> Array:
        """Points (..., 2), moved."""
        if self.is_translation:
            return points + np.array([self.dx, self.dy])
        return self.vectors(points) + np.array([self.dx, self.dy])

    def vectors(self, vectors: Array) -> Array:
        """Directions (..., 2), turned."""
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack([x * self.cos + y * self.sin, y * self.cos - x * self.sin], axis=-1)

    def shape(self, shape: Any) -> Any:
        """A shapely geometry, or an array of them, moved."""
        import shapely

        return shapely.transform(shape, self.points)


@dataclass(frozen=True, slots=True)
class Closure:
    """Of a chart whose ring at height 0 is `length` mm once round, and which turns by `angle` (rad, clockwise) a turn.

    `length` may be an array: of many sheets of one family at once, broadcast against the points' (...).

    `angle` is 0 on a cylinder, -2 pi sin(alpha) on a cone; `length` is infinite on a sheet without a closure (a plane), and may
    be 0 or less on a cone whose ring at height 0 lies beyond its apex. Round a cone's apex the plane is used up after
    2 pi / |angle| turns (1.15 on a cone of 60 degrees): what lies farther than half of that from the generator at theta = 0 is
    taken for a copy nearer by, so that longer ways are followed point by point.
    """

    length: Any
    angle: float = 0.0

    @property
    def is_open(self) -> bool:
        """Whether the chart has no two sides: nothing has copies."""
        return np.ndim(self.length) == 0 and bool(self.length == math.inf)

    @property
    def is_translation(self) -> bool:
        """Whether copies are parallel to each other: what a family of parallel lines needs to meet itself round a full turn."""
        return self.angle == 0.0

    def motion(self, turns: float) -> Motion:
        """The motion by a number of turns."""
        if self.is_open or turns == 0:
            return Motion(1.0, 0.0, 0.0, 0.0)
        if self.angle == 0.0:
            return Motion(1.0, 0.0, turns * self.length, 0.0)
        a = turns * self.angle
        sin, half = math.sin(a), math.sin(0.5 * a)
        return Motion(math.cos(a), sin, self.length * sin / self.angle, -2.0 * self.length * half * half / self.angle)

    def moved(self, points: Array, turns: Array | float) -> Array:
        """Points (..., 2), each moved by its number of turns (broadcast against (...))."""
        if self.is_open:
            return points
        turns = np.asarray(turns, dtype=np.float64)
        if self.angle == 0.0:
            shift = turns * self.length
            return points + np.stack([shift, np.zeros_like(shift)], axis=-1)
        x, y = points[..., 0], points[..., 1]
        a = turns * self.angle
        sin, cos, half = np.sin(a), np.cos(a), np.sin(0.5 * a)
        scale = self.length / self.angle
        return np.stack([x * cos + y * sin + scale * sin, y * cos - x * sin - 2.0 * scale * half * half], axis=-1)

    def turned(self, vectors: Array, turns: Array | float) -> Array:
        """Directions (..., 2), each as its copy so many turns away has it."""
        if self.angle == 0.0:
            return vectors
        a = np.asarray(turns, dtype=np.float64) * self.angle
        x, y = vectors[..., 0], vectors[..., 1]
        return np.stack([x * np.cos(a) + y * np.sin(a), y * np.cos(a) - x * np.sin(a)], axis=-1)

    @property
    def beside(self) -> tuple[int, ...]:
        """The turns by which a thing that lies in one turn is moved to have it beside that, too."""
        return (0,) if self.is_open else (-1, 0, 1)

    def ring_lengths(self, heights: Array) -> Array:
        """Once round at heights (...) in mm, (...), mm; infinite where nothing has copies."""
        return np.asarray(self.length + self.angle * heights)

    def turns_across(self, distance: float, boxes: Array) -> float:
        """At most how many turns apart things in `boxes` (n, 4) are that lie within `distance` mm of each other."""
        if self.angle == 0.0:
            return distance / self.length
        heights = self._sectors(boxes)[:, [1, 3]]
        # seen from the apex, at a slant distance of a ring's length / |angle|
        share = distance * abs(self.angle) / max(float((self.length + self.angle * heights).min()), 1e-300)
        return math.asin(share) / abs(self.angle) if share < 1.0 else 0.5

    def turns_of(self, points: Array) -> Array:
        """Where points (..., 2) lie round the axis, in turns: theta / (2 pi), of the copy that they are."""
        if self.is_open:
            return np.zeros(np.shape(points)[:-1])
        if self.angle == 0.0:
            return points[..., 0] / self.length
        return np.arctan2(self.angle * points[..., 0], self.length + self.angle * points[..., 1]) / self.angle

    def turns_near(self, points: Array, near: float) -> Array:
        """`turns_of` points (..., 2) that are known to lie around the place `near` (turns)."""
        turns = self.turns_of(points)
        if self.angle == 0.0:
            return turns
        once = TURN / abs(self.angle)
        return turns + once * np.round((near - turns) / once)

    def turns_along(self, points: Array) -> Array:
        """`turns_of` a way's points (n, 2), followed from the first one: continuous however far it goes round, (n,)."""
        turns = self.turns_of(points)
        return turns if self.angle == 0.0 else np.unwrap(turns, period=TURN / abs(self.angle))

    def heights_of(self, points: Array) -> Array:
        """How far points (..., 2) lie from the ring of `length` along their generator, mm: v on a cylinder."""
        x, y = points[..., 0], points[..., 1]
        if self.angle == 0.0:
            return y
        # rings round the apex: (length + angle * height)**2 = (angle * x)**2 + (length + angle * y)**2
        size = np.hypot(self.angle * x, self.length + self.angle * y)
        near = (2.0 * self.length * y + self.angle * (x * x + y * y)) / np.where(self.length > 0.0, size + self.length, 1.0)
        return np.where(self.length > 0.0, near, (size - self.length) / self.angle)

    def swept_area(self, points: Array, derivatives: Array) -> Array:
        """What a generator sweeps from the ring of `length` up to points (n, 2) that move by `derivatives` (n, 2): (n,), mm**2.

        h (length + angle h / 2) dturns at height h: v dkappa on a cylinder; its integral is the same for every copy.
        """
        x, y = points[..., 0], self.length + self.angle * points[..., 1]
        h = self.heights_of(points)
        dturns = (y * derivatives[..., 0] - self.angle * x * derivatives[..., 1]) / ((self.angle * x) ** 2 + y * y)
        return h * (self.length + 0.5 * self.angle * h) * dturns

    def at(self, turns: Array, heights: Array) -> Array:
        """The point (..., 2) so many turns round and so high along its generator: the inverse of `turns_of`, `heights_of`."""
        start = np.stack(np.broadcast_arrays(np.zeros_like(np.asarray(turns, dtype=np.float64)), heights), axis=-1)
        return self.moved(start, turns)

    @property
    def apex(self) -> Array:
        """Where a cone's generators meet in the plane, (kappa, v), mm."""
        return np.array([0.0, -self.length / self.angle])

    def heading_of_ring(self, turns: float) -> float:
        """The direction of rings so many turns round, rad from +kappa towards +v, towards more turns."""
        return -self.angle * turns

    def copies_of(self, points: Array, first: float = -0.5) -> Array:
        """Which copy each of points (..., 2) is, (...) whole: 0 from `first` (turns) to a turn further on."""
        return np.floor(self.turns_of(points) - first)

    def canonical(self, points: Array, first: float = -0.5) -> Array:
        """The copy of each of points (..., 2) that lies from `first` (turns) to a turn further on."""
        return self.moved(points, -self.copies_of(points, first))

    def nearest_turns(self, points: Array, targets: Array) -> Array:
        """By how many whole turns each of points (..., 2) has to be moved to lie nearest to its target, (...)."""
        return np.round(self.turns_of(targets) - self.turns_of(points))

    def distances(self, a: Array, b: Array) -> Array:
        """How far a (..., 2) is from the nearest copy of b (..., 2), (...), mm."""
        if self.angle == 0.0:
            d = b - a
            along = d[..., 0] if self.is_open else d[..., 0] - self.length * np.round(d[..., 0] / self.length)
            return np.hypot(along, d[..., 1])
        # a place may be more turns round than the plane tells: a whole circle about the apex is less than two turns
        once, apart = TURN / abs(self.angle), self.turns_of(a) - self.turns_of(b)
        copies = [self.moved(b, np.round(apart + k * once)) for k in (-1.0, 0.0, 1.0)]
        return np.min([np.hypot(*np.moveaxis(copy - a, -1, 0)) for copy in copies], axis=0)

    def span_of(self, box: tuple[float, float, float, float]) -> tuple[float, float]:
        """From where to where a box (x0, y0, x1, y1; mm) reaches round the axis, in turns."""
        x0, y0, x1, y1 = box
        ends = self.turns_of(np.array([[x0, y0], [x0, y1], [x1, y0], [x1, y1]]))
        return float(ends.min()), float(ends.max())

    def boxes_meet(self, first: Array, second: Array, margin: float) -> Array:
        """Which boxes (n, 4; x0, y0, x1, y1, mm) may come within `margin` (mm) of others (m, 4) or their copies, (n, m)."""
        if self.angle == 0.0:
            p, q = first, second
            turn = np.array([0.0]) if self.is_open else np.array([self.length])
        else:
            p, q = self._sectors(first), self._sectors(second)
            ends = np.concatenate([p[:, 1], p[:, 3], q[:, 1], q[:, 3]])
            turn = self.length + self.angle * np.array([ends.min(), ends.max()])
            p, q = (c * np.array([turn.min(), 1.0, turn.min(), 1.0]) for c in (p, q))
        high = (p[:, None, 3] + margin >= q[None, :, 1]) & (q[None, :, 3] + margin >= p[:, None, 1])
        least, most = p[:, None, 0] - q[None, :, 2] - margin, p[:, None, 2] - q[None, :, 0] + margin
        if self.is_open:
            return np.asarray(high & (least <= 0.0) & (most >= 0.0))
        return np.asarray(high & (np.floor(most / turn.min()) >= np.ceil(least / turn.min())))

    def _sectors(self, boxes: Array) -> Array:
        """What boxes (n, 4) cover: turns from and to, heights from and to, in the same columns, (n, 4)."""
        corners = np.stack([boxes[:, [0, 1]], boxes[:, [0, 3]], boxes[:, [2, 1]], boxes[:, [2, 3]]], axis=1)
        turns, heights = self.turns_of(corners), self.heights_of(corners)
        # the ring that touches a box's upper or lower side reaches beyond its corners
        upright = np.clip(0.0, boxes[:, 0], boxes[:, 2])
        sides = np.stack([self.heights_of(np.stack([upright, boxes[:, k]], axis=-1)) for k in (1, 3)], axis=-1)
        heights = np.concatenate([heights, sides], axis=1)
        return np.stack([turns.min(axis=1), heights.min(axis=1), turns.max(axis=1), heights.max(axis=1)], axis=-1)

    def clipped(self, shapes: Array) -> Array:
        """Of shapely geometries what lies within half a turn of theta = 0; all of it where there is no turn."""
        import shapely

        if self.is_open or not len(shapes):
            return shapes
        if self.angle == 0.0:
            _, low, _, high = shapely.total_bounds(shapes)
            return np.asarray(shapely.clip_by_rect(shapes, -0.5 * self.length, low, 0.5 * self.length, high))
        heights = self.heights_of(shapely.get_coordinates(shapes))
        return np.asarray(shapely.intersection(shapes, self.window(-0.5, 0.5, float(heights.min()), float(heights.max()))))

    def copies_between(self, box: tuple[float, float, float, float], low: float, high: float) -> range:
        """The turns by which a thing in `box` can be moved so that it may overlap what lies from `low` to `high` (turns)."""
        if self.is_open:
            return range(1)
        first, last = self.span_of(box)
        return range(math.ceil(low - last), math.floor(high - first) + 1)

    def window(self, low: float, high: float, bottom: float, top: float) -> Polygon:
        """What lies from `low` to `high` (turns) and from the heights `bottom` to `top` (mm), as a polygon."""
        import shapely

        if self.angle == 0.0:
            return shapely.box(low * self.length, bottom, high * self.length, top)
        turns = np.linspace(low, high, 2 + math.ceil(ARC_SEGMENTS * (high - low)))
        # the arc that bulges outwards is drawn outside of its circle, by what a chord's middle lies inside
        out = 1.0 / math.cos(0.5 * self.angle * (turns[1] - turns[0]))
        far = ((self.length + self.angle * (top if self.angle > 0.0 else bottom)) * out - self.length) / self.angle
        bottom, top = (bottom, far) if self.angle > 0.0 else (far, top)
        below, above = (self.at(turns, np.full_like(turns, height)) for height in (bottom, top))
        return shapely.Polygon(np.concatenate([below, above[::-1]]))


# Of a plane, and of what goes round nowhere: nothing has copies.
NO_CLOSURE = Closure(math.inf)
