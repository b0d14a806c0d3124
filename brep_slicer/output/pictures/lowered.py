"""The part as it stands after the last planned layer: what lies farther out is laid down on that layer's outer radius.

In: a triangulated solid, a radius. Out: the same with nothing beyond the radius, closed over the section there.

Words: *top*, the radius that the last planned layer reaches; *crossing*, where an edge of a triangle goes through it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array
from brep_slicer.substrate.axis import Axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Soup:
    """Triangles by their corners: `points` and unit `normals` (m, 3, 3), `lines` (k, 2, 3) along the section."""

    points: Array
    normals: Array
    lines: Array


def lowered(points: Array, normals: Array, triangles: Array, *, axis: Axis, top: float) -> Soup:
    """Triangles cut at the radius `top` (mm), what is farther out moved in radially until it lies on it.

    Moved in, flanks and tips cover just the section there: flat metal on which the layer's beads lie.
    """
    corners, facing = axis.axis_from_file(points)[triangles], _in_axis(normals, axis)[triangles]
    beyond = np.hypot(corners[..., 0], corners[..., 1]) > top
    count = beyond.sum(axis=1)
    kept = [(corners[count == 0], facing[count == 0])]
    moved = [_moved(corners[count == 3], top)]
    lines = [np.zeros((0, 2, 3))]
    for alone, rest in ((1, kept), (2, moved)):
        # the corner that is by itself on its side comes first
        chosen = np.flatnonzero(count == alone)
        first = np.argmax(beyond[chosen] == (alone == 1), axis=1)
        order = (first[:, None] + np.arange(3)) % 3
        p = np.take_along_axis(corners[chosen], order[..., None], axis=1)
        n = np.take_along_axis(facing[chosen], order[..., None], axis=1)
        ab, ab_n = _crossing(p[:, 0], p[:, 1], n[:, 0], n[:, 1], top)
        ac, ac_n = _crossing(p[:, 0], p[:, 2], n[:, 0], n[:, 2], top)
        lines.append(np.stack([ab, ac], axis=1))
        tip, tip_n = np.stack([p[:, 0], ab, ac], axis=1), np.stack([n[:, 0], ab_n, ac_n], axis=1)
        base = [np.stack([ab, p[:, 1], p[:, 2]], axis=1), np.stack([ab, p[:, 2], ac], axis=1)]
        base_n = [np.stack([ab_n, n[:, 1], n[:, 2]], axis=1), np.stack([ab_n, n[:, 2], ac_n], axis=1)]
        if rest is kept:
            moved.append(_moved(tip, top))
            kept += list(zip(base, base_n, strict=True))
        else:
            kept.append((tip, tip_n))
            moved += [_moved(part, top) for part in base]
    parts = [*kept, *moved]
    return Soup(
        points=_in_file(np.concatenate([p for p, _ in parts]), axis),
        normals=axis.file_from_axis_vectors(np.concatenate([n for _, n in parts]).reshape(-1, 3)).reshape(-1, 3, 3),
        lines=_in_file(np.concatenate(lines), axis),
    )


def cut_lines_at(points: Array, pairs: Array, *, axis: Axis, top: float) -> Array:
    """What of the lines between `pairs` (k, 2) of points lies inside of the radius `top`, (n, 2, 3)."""
    ends = axis.axis_from_file(points)[pairs]
    beyond = np.hypot(ends[..., 0], ends[..., 1]) > top
    whole = ends[~beyond.any(axis=1)]
    split, out = ends[beyond[:, 0] != beyond[:, 1]], beyond[beyond[:, 0] != beyond[:, 1], 0]
    inner, outer = np.where(out[:, None], split[:, 1], split[:, 0]), np.where(out[:, None], split[:, 0], split[:, 1])
    at, _ = _crossing(inner, outer, inner, outer, top)
    return _in_file(np.concatenate([whole, np.stack([inner, at], axis=1)]), axis)


def in_zones(points: Array, triangles: Array, *, axis: Axis, zones: tuple[tuple[float, float], ...]) -> NDArray[np.bool_]:
    """Which triangles lie in one of the heights (low, high) in which the part's own metal stands, (m,)."""
    height = axis.axis_from_file(points)[:, 2][triangles].mean(axis=1)
    return np.any([np.zeros(len(height), dtype=bool), *((height > low) & (height < high) for low, high in zones)], axis=0)


def _crossing(p: Array, q: Array, n: Array, m: Array, top: float) -> tuple[Array, Array]:
    """Where the way from `p` to `q` goes through the radius, and the normal there; one end lies inside, the other outside."""
    d = (q - p)[:, :2]
    a, b = np.einsum("ij,ij->i", d, d), np.einsum("ij,ij->i", p[:, :2], d)
    c = np.einsum("ij,ij->i", p[:, :2], p[:, :2]) - top**2
    root = np.sqrt(np.maximum(b**2 - a * c, 0.0))
    # outwards it is the later root, inwards the earlier one
    share = np.clip((np.where(c > 0.0, -root, root) - b) / np.maximum(a, 1e-300), 0.0, 1.0)[:, None]
    normal = n + share * (m - n)
    return p + share * (q - p), normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)


def _moved(points: Array, top: float) -> tuple[Array, Array]:
    """Corners (m, 3, 3) on the radius, their normals away from the axis."""
    rho = np.maximum(np.hypot(points[..., 0], points[..., 1]), 1e-300)[..., None]
    out = np.concatenate([points[..., :2] / rho, np.zeros_like(rho)], axis=-1)
    return np.concatenate([out[..., :2] * top, points[..., 2:]], axis=-1), out


def _in_axis(vectors: Array, axis: Axis) -> Array:
    return axis.axis_from_file(vectors) - axis.axis_from_file(np.zeros((1, 3)))


def _in_file(points: Array, axis: Axis) -> Array:
    return axis.file_from_axis(points.reshape(-1, 3)).reshape(points.shape)


__all__ = ["Soup", "cut_lines_at", "in_zones", "lowered"]
