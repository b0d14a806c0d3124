"""Parallel straight beads at an exact step-over and any angle, across the seam too.

In: an area. Out: beads that end at the area's inset from the exact outline.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely

from brep_slicer.layers import Closure
from brep_slicer.maps import TURN, Array

from ..bead import Bead, BeadKind
from ..pattern import AreaFill, FillArea
from .distance import Outline, ends_at_inset
from .full_turn import anchor_of, closing_lines, join_across_seam
from .inset import Inset, edges_of, inset_piece
from .meeting import beside, drawn_back, nearest_end, with_room
from .scanlines import cut_lines, directions

# Beads lie on one line if they are no farther from it than this, mm.
SAME_LINE = 1e-6
# Where lobes stick out of a piece, the outermost lines lie where its inset is this share as wide as in the median, looked for
# at so many levels, and then by halving these so many times (to 1e-9 of the extent).
OF_THE_USUAL, LEVELS, HALVINGS = 0.25, 64, 24


@dataclass(frozen=True, slots=True, kw_only=True)
class ParallelLines:
    """Parallel beads at `angle` (rad, counter-clockwise from +kappa seen from outside), one way or both ways.

    The lines are centred on the piece, so that they turn with it; on a full turn they close by the rule of `full_turn`.
    With `stretch` (a share of the step-over), spacings may be that much wider or narrower so that the outermost lines lie at
    the inset on both sides; where that is not enough, the step-over stays, and so it does on a full turn but for rings, since
    the lines have to close. On a full turn, a line begins at the lower edge at the angle `start` round the shaft (rad, theta
    of the axis frame), if that is given.
    """

    angle: float = 0.0
    both_ways: bool = True
    stretch: float = 0.0
    start: float | None = None

    def fill(self, area: FillArea) -> AreaFill:
        return self.fill_all([area])[0]

    def fill_all(self, areas: Sequence[FillArea]) -> list[AreaFill]:
        """All pieces of a layer that do not wind are cut by their lines at once."""
        out = [AreaFill(beads=(), inset=area.inset, angle=self.angle, step_over=area.step_over) for area in areas]
        rooms = [_room(area) for area in areas]
        flat = [i for i, area in enumerate(areas) if not area.piece.winds and not rooms[i].ends.is_empty]
        for i, area in enumerate(areas):
            if area.piece.winds and not rooms[i].ends.is_empty:
                out[i] = replace(self._round(rooms[i]), inset=area.inset)
        if not flat:
            return out
        edges = [edges_of(rooms[i].ends.polygons) for i in flat]
        extents = [_extent(areas[i], *edges_of(rooms[i].lines.polygons), self.angle) for i in flat]
        spacing = np.array(
            [_stretched(p, self.angle, areas[i].step_over, self.stretch) for i, p in zip(flat, extents, strict=True)]
        )
        phase = np.array([_centred(p, self.angle, d) for p, d in zip(extents, spacing.tolist(), strict=True)])
        starts, ends = (np.concatenate([e[k] for e in edges]) for k in (0, 1))
        group = np.repeat(np.arange(len(flat)), [len(e[0]) for e in edges])
        found = cut_lines(starts, ends, angle=self.angle, spacing=spacing, phase=phase, group=group)
        cuts = np.searchsorted(found.group, np.arange(len(flat) + 1))
        sharp = _sharp_ends([rooms[i] for i in flat], found.points, found.group, self.angle)
        for k, i in enumerate(flat):
            ends = sharp[cuts[k] : cuts[k + 1]]
            if areas[i].meets_contour:
                ends = ends[with_room(areas[i], ends)]
            beads = self._beads(areas[i], ends, [False] * len(ends), self.angle, float(spacing[k]), float(phase[k]))
            out[i] = replace(out[i], beads=beads, step_over=float(spacing[k]))
        return out

    def _round(self, room: _Room) -> AreaFill:
        """A piece that winds: its lines close on themselves and go on across the seam."""
        area, inset = room.area, room.ends
        angle, spacing, k = closing_lines(inset.closure.length, self.angle, area.step_over)
        starts, ends = edges_of(inset.polygons)
        extent = _extent(area, *edges_of(room.lines.polygons), angle)
        if k == 0:
            spacing = _stretched(extent, angle, spacing, self.stretch)
        phase = _phase(area, extent, angle, spacing, k)
        if self.start is not None and k:
            phase = float(_lower_edge(area, inset, self.start / TURN) @ directions(angle)[1])
        phase = _off_the_seam(phase, inset, angle, spacing)
        found = join_across_seam(cut_lines(starts, ends, angle=angle, spacing=spacing, phase=phase), inset, k)
        points, closed = np.array([p for p, _ in found]).reshape(-1, 2, 2), np.array([c for _, c in found], dtype=bool)
        group = np.zeros(int((~closed).sum()), dtype=int)
        points[~closed] = _sharp_ends([room], points[~closed], group, angle)
        if area.meets_contour:
            kept = closed | with_room(area, points)
            points, closed = points[kept], closed[kept]
        beads = self._beads(area, points, closed.tolist(), angle, spacing, phase)
        return AreaFill(beads=beads, inset=area.inset, angle=angle, step_over=spacing)

    def _beads(self, area: FillArea, points: Array, closed: list[bool], angle: float, spacing: float, phase: float):
        """In the order of the lines; with `both_ways`, every second line is run backwards."""
        _, across = directions(angle)
        number = np.round((points[:, 0] @ across - phase) / spacing).astype(int)
        along, _ = directions(angle)
        back = (number % 2 == 1) & self.both_ways
        # several beads on a line that is run backwards come in backward order too
        order = np.lexsort((points[:, 0] @ along * np.where(back, -1.0, 1.0), number))
        run = np.where(back[:, None, None], points[:, ::-1], points)
        return tuple(Bead(points=run[i], kind=BeadKind.HATCH, piece=area.index, closed=closed[i]) for i in order.tolist())


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Room:
    """An area whose inset is the one at which its lines are cut (`ends`), and how far they may lie across (`lines`)."""

    area: FillArea
    ends: Inset
    lines: Inset


def _room(area: FillArea) -> _Room:
    """Where an area's lines lie and end: at its inset; beside a contour nearer, by the rules of `meeting`."""
    if not area.meets_contour:
        inset = inset_piece(area.piece, area.inset, chord=area.chord)
        return _Room(area=area, ends=inset, lines=inset)
    contour, sizes = area.inset - area.step_over, (area.step_over, area.width)
    area = replace(area, inset=contour + nearest_end(*sizes))
    ends = inset_piece(area.piece, area.inset, chord=area.chord)
    lines = inset_piece(area.piece, contour + beside(*sizes), chord=area.chord)
    return _Room(area=area, ends=ends, lines=ends if lines.is_empty else lines)


def angle_on_layer(angles_deg: Sequence[float], step_deg: float, layer: int) -> float:
    """The angle (rad) of lines on layer number `layer`: of some (degrees) in turn, and turned by a step from layer to layer."""
    return math.radians(angles_deg[layer % len(angles_deg)] + layer * step_deg)


def _met_halfway(before: Array, after: Array, along: Array, closure: Closure) -> Array:
    """Ends that were slid past one another on one line meet in the middle instead: starts first, then as many ends, (2 n, 2).

    The polygons are pinched by their slack where the exact inset is not; a line is then cut in two there.
    """
    count = len(before) // 2
    slid = np.abs((after - before) @ along)
    reach = 2.0 * float(slid.max(initial=0.0))
    if reach == 0.0:
        return after
    # ends in one turn; starts there, too, with their copies beside it
    places = closure.canonical(before, float(closure.turns_of(before).min()))
    copies = np.concatenate([closure.moved(places[:count], turns) for turns in closure.beside])
    end, start = shapely.STRtree(shapely.points(copies)).query(
        shapely.points(places[count:]), predicate="dwithin", distance=reach
    )
    end, start = end + count, start % count
    apart = closure.moved(before[start], closure.nearest_turns(before[start], before[end])) - before[end]
    gap, off = apart @ along, np.abs(apart[:, 0] * along[1] - apart[:, 1] * along[0])
    past = (off < SAME_LINE) & (gap >= 0.0) & (slid[start] + slid[end] > gap)
    most = np.full(len(before), np.inf)
    for side in (start, end):
        np.minimum.at(most, side[past], 0.5 * gap[past])
    way = np.where(np.arange(len(before)) < count, -1.0, 1.0)
    return np.where((most < slid)[:, None], before + (way * most.clip(max=1e9))[:, None] * along, after)


def _extent(area: FillArea, starts: Array, ends: Array, angle: float) -> Array:
    """Points of the edges of an area's inset that say how far it reaches across the lines.

    Where lobes stick out of a piece, its inset reaches a little way into each; no line is to lie there, but where the inset is
    as wide as anywhere else.
    """
    if not area.lobed:
        return starts
    _, across = directions(angle)
    y = starts @ across
    low, high = float(y.min()), float(y.max())
    found = cut_lines(starts, ends, angle=angle, spacing=(high - low) / LEVELS, phase=low + 0.5 * (high - low) / LEVELS)
    lengths = np.bincount(found.line, weights=np.hypot(*(found.points[:, 1] - found.points[:, 0]).T), minlength=LEVELS)
    enough = OF_THE_USUAL * float(np.median(lengths))
    wide = low + (np.flatnonzero(lengths >= enough)[[0, -1]] + 0.5) * (high - low) / LEVELS
    for side, outside in enumerate((low, high)):
        for _ in range(HALVINGS):
            middle = 0.5 * (wide[side] + outside)
            points = cut_lines(starts, ends, angle=angle, spacing=2.0 * (high - low), phase=middle).points
            if float(np.hypot(*(points[:, 1] - points[:, 0]).T).sum()) >= enough:
                wide[side] = middle
            else:
                outside = middle
    return wide[:, None] * across


def _stretched(points: Array, angle: float, spacing: float, most: float) -> float:
    """The spacing next to d that divides the piece's extent across the lines, or d itself if that is more than `most` off."""
    if not most:
        return spacing
    _, across = directions(angle)
    width = float(np.ptp(points @ across))
    count = max(1, round(width / spacing))
    # a hair less than the whole, so that rounding loses no line
    return width / count * (1.0 - 1e-9) if abs(width / count / spacing - 1.0) <= most else spacing


def _phase(area: FillArea, points: Array, angle: float, spacing: float, k: int) -> float:
    """Across-coordinate of line 0 on a full turn: one line goes through its anchor; rings are centred on it."""
    if k == 0:
        return _centred(points, angle, spacing)
    _, across = directions(angle)
    middle = 0.5 * (points[:, 1].min() + points[:, 1].max())
    return float(area.piece.closure.at(np.array(anchor_of(area.piece)), np.array(middle)) @ across)


def _off_the_seam(phase: float, inset: Inset, angle: float, spacing: float) -> float:
    """The phase, moved by a millionth of a spacing if an upright line lies on the window's side: rounding might drop it."""
    along, across = directions(angle)
    place = (float(inset.closure.at(np.array(inset.cut), np.array(0.0)) @ across) - phase) / spacing
    return phase + 1e-6 * spacing if abs(along[0]) < 1e-9 and abs(place - round(place)) < 1e-7 else phase


def _lower_edge(area: FillArea, inset: Inset, turns: float) -> Array:
    """The lowest point at a place round the shaft (turns) that lies at the inset from a band's outline."""
    place = inset.cut + (turns - inset.cut) % 1.0
    heights = inset.closure.heights_of(shapely.get_coordinates(list(inset.polygons)))
    ends = np.array([heights.min() - 1.0, heights.max() + 1.0])
    up = shapely.LineString(inset.closure.at(np.array([place, place]), ends))
    point = np.array([[up.coords[0][0], min(p.intersection(up).bounds[1] for p in inset.polygons if p.intersects(up))]])
    if area.inset <= 0.0:
        return point[0]
    outline = Outline([area.piece], max(area.inset, area.chord))
    return ends_at_inset(outline, point, np.array([[0.0, -1.0]]), inset=area.inset, limit=20.0 * inset.slack)[0]


def _centred(points: Array, angle: float, spacing: float) -> float:
    """Across-coordinate of line 0 where the lines are centred on the points."""
    _, across = directions(angle)
    y = points @ across
    low, high = float(y.min()), float(y.max())
    count = math.floor((high - low) / spacing * (1.0 + 1e-12))
    return low + 0.5 * (high - low - count * spacing)


def _sharp_ends(rooms: Sequence[_Room], points: Array, group: Array, angle: float) -> Array:
    """Both ends of beads (n, 2, 2) of the areas `group` (n,) of one layer, at exactly the inset, or as their contours ask."""
    areas = [room.area for room in rooms]
    along, _ = directions(angle)
    if len(points) and areas[0].inset > 0.0:
        # on or outside of the outline, the polygon's own ends are near enough: inside of it by its slack at most
        points = _slid_outwards(rooms, points, group, angle)
    meets = np.array([area.meets_contour for area in areas])[group]
    if meets.any():
        points = points.copy()
        points[meets] = drawn_back(areas, points[meets], along)
    return points


def _slid_outwards(rooms: Sequence[_Room], points: Array, group: Array, angle: float) -> Array:
    areas = [room.area for room in rooms]
    area = areas[0]
    along, _ = directions(angle)
    slack = np.array([room.ends.slack for room in rooms])
    # its distances have to hold for an end that is not yet at the inset
    outline = Outline([c.piece for c in areas], max(area.inset, area.chord) + 2.0 * float(slack.max()))
    flat = np.concatenate([points[:, 0], points[:, 1]])
    ways = np.concatenate([np.tile(-along, (len(points), 1)), np.tile(along, (len(points), 1))])
    # a line that meets the outline at a grazing angle may have to slide a long way: twenty slacks are 3 degrees, and on a full
    # turn, whose edges mostly run round the shaft, as far as the lines' own angle asks
    winds = np.array([c.piece.winds for c in areas])
    reach = slack * (20.0 + np.where(winds, 2.0 / max(abs(math.sin(angle)), 1e-6), 0.0))
    limit = np.tile(reach[group], 2)
    moved = ends_at_inset(outline, flat, ways, inset=area.inset, limit=limit)
    moved = _met_halfway(flat, moved, along, outline.closure)
    return np.stack([moved[: len(points)], moved[len(points) :]], axis=1)
