"""Coarse level curves on a face, from a grid of rho: which nodes lie on one curve, and which curves meet no edge.

In: a face and a level. Out: polylines in (u, v) that guide the exact tracing. Nothing of their accuracy goes into a result.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from brep_slicer.geometry import Face
from brep_slicer.layers import LayerFamily
from brep_slicer.maps import Array

# Grid lines a smooth patch of the surface, and the most along one side of a face.
LINES_PER_PATCH, MOST_LINES, FEWEST_LINES = 8, 241, 49
# Around each stationary point (of so many, the others get a line each way) the grid closes in by this many steps of four: to a
# 4096th of a cell.
MOST_PEAKS, CLOSING = 12, 6
# Places on a level line nearer to each other than this share of its longest step are one.
ALIKE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class FaceGrid:
    """The level on a grid of a face's box: `u` (n,), `v` (m,), `rho` (n, m); `scale` (2,) is mm a unit of u and v."""

    u: Array
    v: Array
    rho: Array
    scale: Array
    family: LayerFamily

    def level_lines(self, radius: float) -> list[Array]:
        """Polylines (k, 2) in (u, v) where rho = radius, no two neighbours alike; closed ones repeat their first point."""
        import contourpy

        generator = contourpy.contour_generator(self.v, self.u, self.rho, line_type=contourpy.LineType.Separate)
        return [self._distinct(np.asarray(line)[:, ::-1]) for line in generator.lines(radius)]

    def _distinct(self, line: Array) -> Array:
        """Without the places that a line has twice where it goes through a corner of the grid; both ends stay."""
        steps = np.hypot(*(np.diff(line, axis=0) * self.scale).T)
        apart = steps > ALIKE * steps.max(initial=0.0)
        # of two alike the later one goes, at the line's end the earlier
        keep = np.append(True, apart)
        last = int(np.flatnonzero(keep)[-1])
        keep[last], keep[-1] = last == 0 or last == len(line) - 1, True
        return line[keep]


def grid_of_face(face: Face, stationary: Array, family: LayerFamily) -> FaceGrid:
    """Evaluate the level (rho, on cylinders) on a grid that respects the surface's patches.

    `stationary` (n, 2) are points where rho has, or may have, an extreme or a saddle: grid lines go through them, and close in
    on them, so that an island is found however little of it rises above the layer.
    """
    u, v = (_lines(breaks) for breaks in face.surface.breaks(face.box))
    u, v = (_closing_in(lines, stationary[:, k], face.box[:, k]) for k, lines in enumerate((u, v)))
    uv = np.stack(np.meshgrid(u, v, indexing="ij"), axis=-1).reshape(-1, 2)
    points = face.surface.points(uv)
    rho = family.value(points).reshape(len(u), len(v))
    xyz = points.reshape(len(u), len(v), 3)
    along_u = np.linalg.norm(np.diff(xyz, axis=0), axis=2).sum(axis=0).mean() / max(u[-1] - u[0], 1e-300)
    along_v = np.linalg.norm(np.diff(xyz, axis=1), axis=2).sum(axis=1).mean() / max(v[-1] - v[0], 1e-300)
    return FaceGrid(u=u, v=v, rho=rho, scale=np.maximum([along_u, along_v], 1e-12), family=family)


def _closing_in(lines: Array, peaks: Array, ends: Array) -> Array:
    """More lines at the peaks, and around the first ones, each pair four times nearer than the one before."""
    if not len(peaks):
        return lines
    cell = float(np.diff(lines).max())
    steps = cell * 0.25 ** np.arange(1, CLOSING + 1)
    offsets = np.concatenate([-steps, steps])
    extra = np.concatenate([peaks, (peaks[:MOST_PEAKS, None] + offsets).ravel()])
    return np.unique(np.concatenate([lines, extra[(extra > ends[0]) & (extra < ends[1])]]))


def _lines(breaks: Array) -> Array:
    each = int(np.clip(MOST_LINES // max(len(breaks) - 1, 1), 1, max(LINES_PER_PATCH, FEWEST_LINES // max(len(breaks) - 1, 1))))
    share = np.arange(each) / each
    return np.unique(np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), breaks[-1]))


# Places on a level line nearer to each other than this share of its longest step are one.
ALIKE = 1e-9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Placed:
    """Where points lie on the nearest of several polylines: its number, the arc length there (mm), the distance (mm)."""

    line: np.ndarray
    position: Array
    distance: Array


def place_on_lines(points: Array, lines: list[Array], scale: Array) -> Placed:
    """Project points (n, 2) in (u, v) on the nearest polyline."""
    n = len(points)
    line, position, distance = np.zeros(n, dtype=int), np.zeros(n), np.full(n, np.inf)
    for number, polyline in enumerate(lines):
        q = polyline * scale
        d = np.diff(q, axis=0)
        size = np.maximum((d * d).sum(axis=1), 1e-300)
        length = np.concatenate([[0.0], np.cumsum(np.sqrt((d * d).sum(axis=1)))])
        gap = points[:, None] * scale - q[None, :-1]
        share = np.clip((gap * d[None]).sum(axis=2) / size[None], 0.0, 1.0)
        off = np.linalg.norm(gap - share[..., None] * d[None], axis=2)
        nearest = off.argmin(axis=1)
        rows = np.arange(n)
        closer = off[rows, nearest] < distance
        line[closer] = number
        distance[closer] = off[rows, nearest][closer]
        place = length[nearest] + share[rows, nearest] * np.diff(length)[nearest]
        position[closer] = place[closer]
    return Placed(line=line, position=position, distance=distance)


def between(polyline: Array, scale: Array, start: float, end: float) -> Array:
    """Vertices of a polyline strictly between two arc lengths, in the direction from start to end; round a closed one if
    end <= start."""
    q = polyline * scale
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(q, axis=0), axis=1))])
    if end > start:
        return polyline[(length > start) & (length < end)]
    tail, head = polyline[(length > start)], polyline[:-1][length[:-1] < end]
    return np.concatenate([tail[:-1] if len(tail) else tail, head])
