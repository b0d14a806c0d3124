"""A part looked at along rays from its axis: where there is metal, from which radius to which, and whose.

In: a part and its axis. Out: a Survey, arrays of rays and of the stretches of metal along them. It serves to choose (what is
built on, what stands); layers are cut from the exact faces.

Words: *ray*, a half-line from the axis, square to it; *station*, the height z of a ring of rays; *column*, an angle that all
stations share; *stretch*, an interval of a ray inside of one solid.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.groups import groups_of_pairs
from brep_slicer.maps import TURN, Array
from brep_slicer.part import Part, Solid

from .axis import Axis

if TYPE_CHECKING:
    from brep_slicer.kernel.facets import Facets

# Rays round the axis (a prime, so that no pattern of teeth falls into step with them), and the least and the most stations.
COLUMNS, STATIONS, MOST_STATIONS = 241, 160, 420
# Stations between two neighbouring heights of corners, where the profile may step; heights nearer than this share of the
# part's length are one.
BETWEEN, SAME_HEIGHT = 2, 5e-4
# Metal that covers less than LOOSE of a turn at its radius is a feature (a tooth, a blade, a lobe), from TURNED on it is a
# turned body with a hole or a keyway; in between it counts in part.
LOOSE, TURNED = 0.6, 0.9
# A rim on spokes whose wall is less than this share of its radius is a thin-walled ring (the bound of thin-wall theory), which
# hangs on them rather than that it carries what is built.
LEAST_RIM = 0.05
RINGS = 256
# Radii of rings that differ by less than this share of the outermost one are one.
SAME_RING = 1e-7
# Solids nearer than this (mm) touch: more than files part what lies on one another. Seen to overlap on so many rays, they do.
CONTACT, OFTEN = 1e-2, 4
# Facets lie off curved faces by up to this share of the radius (1 - cos of half of the mesh's angle): what is nearer to a
# cylinder cannot be told from it, unless its radius is known exactly.
SAG = 8e-3
# Columns lie this share of their distance off x, where CAD systems put their seams.
PHASE = 0.3719


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Stretches:
    """Along `ray` (n,), solid number `solid` (n,) from `start` to `end` (n,), mm, through the faces `first` and `last`.

    A stretch that begins on the axis has start 0 and first -1. `exact_start` and `exact_end` tell where the radius is that of a
    coaxial face, not of a facet. Solids are numbered as in the part's tuple.
    """

    ray: Array
    solid: Array
    start: Array
    end: Array
    first: Array
    last: Array
    exact_start: Array
    exact_end: Array

    def chosen(self, flags: Array) -> Stretches:
        """Those with a flag."""
        return Stretches(**{name: getattr(self, name)[flags] for name in self.__dataclass_fields__})

    def volumes(self, weights: Array, inner: float = 0.0, outer: float = np.inf) -> Array:
        """mm**3 of each stretch between two radii; `weights` are those of the rays."""
        a, b = np.clip(self.start, inner, outer), np.clip(self.end, inner, outer)
        return 0.5 * (b**2 - a**2) * weights[self.ray]


@dataclass(frozen=True, kw_only=True, eq=False)
class Survey:
    """Rays at `heights` (s,) of stations, `edges` (s + 1,) between them (mm), and what they meet. Ray number = station *
    COLUMNS + column. `touching` (solids, solids) tells which solids touch one another (each touches itself)."""

    heights: Array
    edges: Array
    stretches: Stretches
    touching: Array

    @property
    def shape(self) -> tuple[int, int]:
        """(stations, columns)."""
        return len(self.heights), COLUMNS

    @cached_property
    def weights(self) -> Array:
        """(rays,), d theta d z of each ray, so that volumes are sums of (b**2 - a**2) / 2 times it."""
        return np.repeat(np.diff(self.edges) * TURN / COLUMNS, COLUMNS)

    @cached_property
    def volume(self) -> float:
        """mm**3 of all solids, what lies in two of them twice."""
        return float(self.stretches.volumes(self.weights).sum())

    @cached_property
    def highest(self) -> float:
        """The outermost radius met, mm."""
        return float(self.stretches.end.max(initial=0.0))

    @cached_property
    def _rings(self) -> tuple[Array, Array]:
        """(rings + 1,) radii, and the share of the turn that is metal, (stations, rings).

        Rings end at the exact radii of coaxial faces: one that held a shaft's surface inside would seem half full.
        """
        s = self.stretches
        exact = np.concatenate([s.start[s.exact_start], s.end[s.exact_end]])
        even = np.linspace(0.0, self.highest, RINGS + 1)
        radii = np.unique(np.concatenate([even, exact]))
        # those of a file with rounded coordinates are one, and no even one is needed beside them
        radii = radii[np.append(True, np.diff(radii) > SAME_RING * self.highest)]
        station, count = s.ray // COLUMNS, len(radii) - 1
        share = np.zeros((len(self.heights), count + 1))
        for place, sign in ((s.start, 1.0), (s.end, -1.0)):
            k = self._ring_of(radii, place)
            beyond = np.clip((place - radii[k]) / (radii[k + 1] - radii[k]), 0.0, 1.0)
            # a step at `place` in the running sum, its foot in the ring that holds it
            np.add.at(share, (station, k), sign * (1.0 - beyond))
            np.add.at(share, (station, k + 1), sign * beyond)
        return radii, np.minimum(np.cumsum(share, axis=1)[:, :count] / COLUMNS, 1.0)

    @staticmethod
    def _ring_of(radii: Array, places: Array) -> Array:
        """The number of the ring that holds each radius."""
        return np.clip(np.searchsorted(radii, places * (1.0 + SAME_RING), side="right") - 1, 0, len(radii) - 2)

    @cached_property
    def _loose(self) -> Array:
        """(stations, rings) how far the metal of a ring is no turned body, 0 to 1."""
        return np.clip((TURNED - self._rings[1]) / (TURNED - LOOSE), 0.0, 1.0)

    def loose_below(self, radius: float) -> float:
        """mm**3 inside of a radius that is no turned body: teeth, lobes and blades, by the share of the turn they cover.

        Spokes, and what is left between the holes of a web, do not count: they carry a rim that goes round outside of them.
        Blades that end within a rim carry nothing, nor does a thin-walled rim that ends at the radius: a ring on struts.
        """
        pieces, number, carries = self._loose_pieces(radius)
        return float(self.loose_volumes(pieces.chosen(~carries[number]), inner=0.0).sum())

    def _loose_pieces(self, radius: float) -> tuple[Stretches, Array, Array]:
        """Stretches of metal inside of a radius, in rings that are not closed; (n,) the connected piece that each belongs to,
        and for each piece whether it goes on outwards into a rim: rings that are closed, thick enough to be built on if
        they reach the radius."""
        radii, share = self._rings
        inside = radii[:-1] < radius * (1.0 - SAME_RING)
        closed, top = (share >= TURNED) & inside, np.minimum(radii[1:], radius)
        # runs of rings that are not closed, one after the other over all stations; each run and what it is bounded by
        flags = np.pad(inside & ~closed, ((0, 0), (1, 1)))
        change = np.diff(flags.astype(int), axis=1)
        (station, first), last = np.nonzero(change > 0), np.nonzero(change < 0)[1]
        low, high = radii[first], top[last - 1]
        bounded = np.pad(closed, ((0, 0), (0, 1)))[station, last]
        bounded[bounded] = self._is_rim(closed, radius)[station[bounded], last[bounded]]
        s = self.stretches
        begin = np.searchsorted(station, np.arange(len(self.heights) + 1))
        count = np.diff(begin)[s.ray // COLUMNS]
        which = np.repeat(np.arange(len(s.ray)), count)
        run = begin[s.ray // COLUMNS][which] + _counted(count)
        a, b = np.maximum(s.start[which], low[run]), np.minimum(s.end[which], high[run])
        keep = b > a * (1.0 + SAME_RING)
        which, run, a, b = which[keep], run[keep], a[keep], b[keep]
        pieces = replace(s.chosen(which), start=a, end=b)
        number = connected_stretches(self, pieces, slack=CONTACT)
        carries = np.zeros(int(number.max(initial=-1)) + 1, dtype=bool)
        carries[number[bounded[run] & (b >= high[run] - CONTACT)]] = True
        return pieces, number, carries

    def _is_rim(self, closed: Array, radius: float) -> Array:
        """(stations, rings) whether closed rings, from this one outwards, can carry what stands on the radius."""
        radii, count = self._rings[0], closed.shape[1]
        # the first ring from here on that is not closed
        until = np.where(closed, count, np.arange(count))
        until = np.minimum.accumulate(until[:, ::-1], axis=1)[:, ::-1]
        reaches = radii[until] >= radius * (1.0 - SAME_RING)
        return ~reaches | (radius - radii[:-1] >= LEAST_RIM * radius)

    def loose_volumes(self, stretches: Stretches, inner: float) -> Array:
        """mm**3 of each stretch beyond a radius that is no turned body."""
        radii, _ = self._rings
        area = 0.5 * np.diff(radii**2)
        running = np.concatenate([np.zeros((len(self.heights), 1)), np.cumsum(self._loose * area, axis=1)], axis=1)
        station = stretches.ray // COLUMNS

        def below(radius: Array) -> Array:
            k = self._ring_of(radii, radius)
            part = self._loose[station, k] * 0.5 * (radius**2 - radii[k] ** 2)
            return running[station, k] + part

        a, b = np.maximum(stretches.start, inner), np.maximum(stretches.end, inner)
        return (below(b) - below(a)) * self.weights[stretches.ray]


def connected_stretches(survey: Survey, s: Stretches, *, slack: float) -> Array:
    """(stretches,) the number of the connected metal that each of some stretches belongs to.

    Stretches on neighbouring rays are connected where their intervals overlap, those on one ray where they are no more than
    `slack` (mm) apart; those of several solids only if the solids touch.
    """
    order = np.argsort(s.ray, kind="stable")
    ray, start, end, solid = s.ray[order], s.start[order], s.end[order], s.solid[order]
    rows, columns = survey.shape
    station, column = ray // columns, ray % columns
    links = [np.zeros((0, 2), dtype=int)]
    for target in (ray, station * columns + (column + 1) % columns, np.where(station + 1 < rows, ray + columns, -1)):
        first = np.searchsorted(ray, target, side="left")
        count = np.searchsorted(ray, target, side="right") - first
        a = np.repeat(np.arange(len(ray)), count)
        b = first[a] + _counted(count)
        # stretches of touching solids on one ray meet end to start
        gap = np.where(target[a] == ray[a], slack, 0.0)
        meet = (start[a] <= end[b] + gap) & (start[b] <= end[a] + gap) & survey.touching[solid[a], solid[b]]
        links.append(np.stack([a, b], axis=1)[meet & (a != b)])
    out = np.zeros(len(ray), dtype=int)
    out[order] = groups_of_pairs(len(ray), np.concatenate(links))
    return out


def survey_of(part: Part, axis: Axis, levels: dict[int, dict[int, float]]) -> Survey:
    """Look at a part along rays about its axis; `levels` are the exact radii of coaxial faces, {solid's place: {face: mm}}."""
    from brep_slicer.kernel.facets import corners_of

    corners = [axis.axis_from_file(corners_of(solid.wrapped)) for solid in part.solids]
    found = [_facets(solid) for solid in part.solids]
    meshes = [(axis.axis_from_file(points), triangles, faces) for points, triangles, faces in found]
    heights = np.concatenate([points[:, 2] for points, _, _ in meshes])
    edges = _station_edges(float(heights.min()), float(heights.max()), np.concatenate(corners)[:, 2])
    # off the middle by the golden section, so that no thread or rib falls into step with the stations
    shift = np.mod(np.arange(1, len(edges)) * 0.618034, 1.0) - 0.5
    heights = edges[:-1] + np.diff(edges) * (0.5 + 0.6 * shift)
    pieces = []
    for i, (points, triangles, faces) in enumerate(meshes):
        hits = _hits(points, triangles, heights)
        exact = np.full(int(faces.max(initial=-1)) + 1, np.nan)
        for number, radius in levels.get(i, {}).items():
            exact[number : number + 1] = radius
        met = faces[hits[3]]
        rho = np.where(np.isnan(exact[met]), hits[1], exact[met])
        pieces.append(_stretches(i, hits[0], rho, hits[2], met, ~np.isnan(exact)))
    names = Stretches.__dataclass_fields__
    joined = Stretches(**{name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names})
    touching = _touching(part, joined)
    return Survey(heights=heights, edges=edges, stretches=joined, touching=touching)


def _facets(solid: Solid) -> Facets:
    """A solid's facets, made once."""
    from brep_slicer.kernel.facets import facets_of

    if "facets" not in solid.known:
        solid.known["facets"] = facets_of(solid.wrapped)
    return solid.known["facets"]


def _touching(part: Part, s: Stretches) -> Array:
    """Which solids touch: seen along rays, or else asked of the kernel where their boxes meet."""
    count = len(part.solids)
    out = np.eye(count, dtype=bool)
    if count == 1:
        return out
    from brep_slicer.kernel.facets import DEFLECTION, diagonal_of
    from brep_slicer.kernel.shapes import boxes_apart, distance_of

    order = np.lexsort((s.start, s.ray))
    ray, solid, start, end = s.ray[order], s.solid[order], s.start[order], s.end[order]
    # known exactly where a face is level, else as well as facets follow it
    off = np.array([DEFLECTION * diagonal_of(x.wrapped) for x in part.solids])[solid]
    sag = np.where(s.exact_end[order], 0.0, off)[:-1] + np.where(s.exact_start[order], 0.0, off)[1:]
    slack = np.minimum(sag, SAG * end[:-1]) + CONTACT
    meets = (ray[1:] == ray[:-1]) & (start[1:] <= end[:-1] + slack) & (solid[1:] != solid[:-1])
    pairs, often = np.unique(np.sort(np.stack([solid[1:], solid[:-1]], axis=1)[meets], axis=1), axis=0, return_counts=True)
    seen = pairs[often >= OFTEN]
    out[seen[:, 0], seen[:, 1]] = out[seen[:, 1], seen[:, 0]] = True
    group = groups_of_pairs(count, seen)
    # what no ray shows: side by side, or on a small patch; asked only where it connects what is not connected yet
    for a, b in itertools.combinations(range(count), 2):
        shapes = part.solids[a].wrapped, part.solids[b].wrapped
        if group[a] != group[b] and boxes_apart(*shapes) <= CONTACT and distance_of(*shapes) <= CONTACT:
            out[a, b] = out[b, a] = True
            group[group == group[b]] = group[a]
    return out


def _station_edges(low: float, high: float, corners: Array) -> Array:
    """Heights (mm) between which stations lie: every height where a corner is, and enough in between."""
    length = max(high - low, 1e-9)
    inner = np.sort(corners[(corners > low + SAME_HEIGHT * length) & (corners < high - SAME_HEIGHT * length)])
    same = SAME_HEIGHT * length
    while True:
        knots = [low]
        for z in inner:
            if z - knots[-1] > same:
                knots.append(float(z))
        knots.append(high)
        if BETWEEN * (len(knots) - 1) <= MOST_STATIONS:
            break
        same *= 1.5
    counts = [max(BETWEEN, round(STATIONS * (b - a) / length)) for a, b in itertools.pairwise(knots)]
    parts = [np.linspace(a, b, n + 1)[:-1] for (a, b), n in zip(itertools.pairwise(knots), counts, strict=True)]
    return np.append(np.concatenate(parts), high)


def _hits(points: Array, triangles: Array, heights: Array) -> tuple[Array, Array, Array, Array]:
    """Where rays meet facets: ray, rho (mm), whether the ray leaves the metal there, and the number of the facet."""
    corner = points[triangles]
    low, high = corner[..., 2].min(axis=1), corner[..., 2].max(axis=1)
    first = np.searchsorted(heights, low, side="right")
    count = np.searchsorted(heights, high, side="right") - first
    facet = np.repeat(np.arange(len(triangles)), count)
    station = first[facet] + _counted(count)
    # the two of a facet's three sides that a station's plane crosses
    c, z = corner[facet], heights[station]
    over = c[..., 2] > z[:, None]
    lone = np.where(over.sum(axis=1) == 1, over.argmax(axis=1), (~over).argmax(axis=1))
    k = np.arange(len(c))
    apex = c[k, lone]
    ends = []
    for side in (1, 2):
        other = c[k, (lone + side) % 3]
        # from the lower to the upper corner, so that both facets of a side find the same point
        swap = (other[:, 2] < apex[:, 2])[:, None]
        a, b = np.where(swap, other, apex), np.where(swap, apex, other)
        share = (z - a[:, 2]) / np.where(b[:, 2] > a[:, 2], b[:, 2] - a[:, 2], 1.0)
        ends.append(a[:, :2] + share[:, None] * (b - a)[:, :2])
    p, q = ends
    step = TURN / COLUMNS
    from_angle = np.arctan2(p[:, 1], p[:, 0])
    turned = np.mod(np.arctan2(q[:, 1], q[:, 0]) - from_angle + np.pi, TURN) - np.pi
    begin, end = (np.ceil(x / step - PHASE).astype(int) for x in (from_angle, from_angle + turned))
    count = np.abs(end - begin)
    piece = np.repeat(k, count)
    column = np.minimum(begin, end)[piece] + _counted(count)
    angle = (column + PHASE) * step
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    p, q, facet = p[piece], q[piece], facet[piece]
    d = q - p
    across = way[:, 0] * d[:, 1] - way[:, 1] * d[:, 0]
    rho = (p[:, 0] * d[:, 1] - p[:, 1] * d[:, 0]) / np.where(across != 0.0, across, 1.0)
    normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[facet, :2]
    leaves = (normal * way).sum(axis=1) > 0.0
    return station[piece] * COLUMNS + np.mod(column, COLUMNS), np.maximum(rho, 0.0), leaves, facet


def _counted(count: Array) -> Array:
    """0, 1, ... count - 1 for each count, one after the other."""
    return np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)


def _stretches(solid: int, ray: Array, rho: Array, leaves: Array, face: Array, level: Array) -> Stretches:
    """The stretches of metal of one solid; rays on which its faces do not alternate are left out."""
    order = np.lexsort((leaves, rho, ray))
    ray, rho, leaves, face = ray[order], rho[order], leaves[order], face[order]
    sign = np.where(leaves, -1, 1)
    begins = np.flatnonzero(np.diff(ray, prepend=-1))
    ends = np.append(begins[1:], len(ray))
    total = np.add.reduceat(sign, begins) if len(begins) else np.zeros(0, dtype=int)
    running = np.cumsum(sign)
    # a ray whose last face is left to the outside has as many starts as ends, but for one that starts on the axis
    before = running[begins] - sign[begins] + total if len(begins) else total
    number = np.repeat(np.arange(len(begins)), ends - begins)
    depth = running - before[number]
    good = np.isin(total, (0, -1))
    low, high = np.minimum(depth, depth - sign), np.maximum(depth, depth - sign)
    good[number[(low < 0) | (high > 1)]] = False
    keep = good[number]
    entry, leave = np.flatnonzero(keep & ~leaves), np.flatnonzero(keep & leaves)
    central = begins[good & (total == -1)]
    start = np.concatenate([rho[entry], np.zeros(len(central))])
    rays = np.concatenate([ray[entry], ray[central]])
    faces = np.concatenate([face[entry], np.full(len(central), -1)])
    order = np.lexsort((start, rays))
    faces, level = faces[order], np.append(level, False)
    return Stretches(
        ray=rays[order],
        solid=np.full(len(order), solid),
        start=start[order],
        end=rho[leave],
        first=faces,
        last=face[leave],
        exact_start=level[faces],
        exact_end=level[face[leave]],
    )
