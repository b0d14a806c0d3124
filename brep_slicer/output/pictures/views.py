"""From where a toolpath is looked at: so that every place where metal is laid is seen, from two sides if need be.

In: the part's mesh, the places on top of the deposit. Out: one view or two, with what of the scene fills the page.

Words: *place*, a cell of angle and height on the shaft that holds deposit; it is in view if some of its metal can be seen.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import TURN, Array

from .raster import along, seen
from .scene import AT_ONCE, Mesh

if TYPE_CHECKING:
    from brep_slicer.planning import Plan
    from brep_slicer.toolpath import Toolpath

# Cells of a turn, and of the length that holds deposit; so many points of the deposit are looked for.
ANGLES, HEIGHTS, LOOKED_FOR = 36, 8, 6000
# A view by itself, or two, have to show this share of the places, or as much as any others.
ENOUGH = {1: 0.9, 2: 0.97}
# Views are compared on a page of so many pixels a side.
SMALL = 100
# A deposit that goes so far round (rad) is looked at from all sides; another one from where it faces.
ALL_ROUND = math.radians(170.0)
# Angles (rad) of the deposit are told apart to so many decimals.
ANGLE_DIGITS = 4
# Elevations over the plane across the axis, and how far beside the middle of the deposit the eye is.
LOW, HIGH, ASIDE = math.radians(28.0), math.radians(55.0), math.radians(25.0)
# What of the part is shown around the deposit, a share of the deposit's extent.
AROUND = 0.12
# A deposit so many times as long as it is wide lies down on the page.
LYING = 1.25
# Nothing is so oblique that the way through it counts more times than this.
MOST_SLANT = 4.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class View:
    """Unit vectors on the page to the `right` and `up`, and `towards` the eye, (3,); `box` in mm: left, low, right, top."""

    right: Array
    up: Array
    towards: Array
    box: tuple[float, float, float, float]

    def flat(self, points: Array) -> Array:
        """To the right and up on the page, mm, (n, 2)."""
        return np.stack([along(points, self.right), along(points, self.up)], axis=1)

    def places(self, points: Array, scale: float) -> Array:
        """Pixels (n, 2), x right, y down, at `scale` pixels a mm."""
        left, _, _, top = self.box
        flat = self.flat(points)
        return np.stack([(flat[:, 0] - left) * scale, (top - flat[:, 1]) * scale], axis=1)


def views_of(plan: Plan, mesh: Mesh) -> list[View]:
    """One view that has every place in sight, else two that have between them, the plainest first."""
    if not plan.toolpath.deposits.any():
        return [_view(plan, mesh, plan.axis.file_from_axis_vectors(np.array([1.0, 0.0, 0.5]) / math.sqrt(1.25)))]
    samples, place = _places(plan)

    @functools.cache
    def judged(elevation: float, azimuth: float) -> tuple[View, Array]:
        flat = math.cos(elevation)
        local = np.array([flat * math.cos(azimuth), flat * math.sin(azimuth), math.sin(elevation)])
        view = _view(plan, mesh, plan.axis.file_from_axis_vectors(local))
        return view, _in_view(view, mesh, samples, place, plan.process.width)

    best: tuple[float, list[View]] = (-1.0, [])
    for directions in _choices(plan):
        found = [judged(*direction) for direction in directions]
        share = float(np.any([shown for _, shown in found], axis=0).mean())
        if share > best[0] + 0.01:
            best = share, [view for view, _ in found]
        if share >= ENOUGH[len(found)]:
            break
    return best[1]


def _places(plan: Plan) -> tuple[Array, Array]:
    """Points of the deposit (n, 3), and the number of the place that each lies in."""
    path = plan.toolpath
    laid = np.flatnonzero(path.deposits)
    laid = laid[:: 1 + len(laid) // LOOKED_FOR]
    theta, v = np.mod(path.kappa[laid] / path.radius[laid], TURN), path.v[laid]
    row = np.clip((v - v.min()) / max(np.ptp(v), 1e-9) * HEIGHTS, 0, HEIGHTS - 1).astype(int)
    cell = np.minimum((theta / TURN * ANGLES).astype(int), ANGLES - 1) * HEIGHTS + row
    return path.points[laid], np.unique(cell, return_inverse=True)[1].ravel()


def _covered(plan: Plan) -> tuple[float, float]:
    """First and last angle (rad) of the arc that holds every deposited point: a turn less the widest gap."""
    path = plan.toolpath
    theta = np.zeros(0)
    for rows, laid in _blocks(path):
        angles = np.mod(path.kappa[rows][laid] / path.radius[rows][laid], TURN)
        theta = np.unique(np.append(theta, np.round(angles, ANGLE_DIGITS)))
    gaps = np.diff(np.append(theta, theta[0] + TURN))
    widest = int(gaps.argmax())
    start = theta[(widest + 1) % len(theta)]
    return float(start), float(start + TURN - gaps[widest])


def _choices(plan: Plan) -> Iterator[tuple[tuple[float, float], ...]]:
    """(elevation, azimuth) of the views of a page, the plainest pages first."""
    start, end = _covered(plan)
    middle = 0.5 * (start + end) + ASIDE
    if end - start < ALL_ROUND:
        yield ((LOW, middle),)
        yield ((HIGH, middle),)
        yield ((LOW, middle), (-LOW, middle - 2.0 * ASIDE))
        return
    half = 0.5 * TURN
    yield ((LOW, middle),)
    yield ((HIGH, middle),)
    yield ((LOW, middle), (-LOW, middle + half))
    for k in range(1, 4):
        yield ((LOW, middle + k * TURN / 8.0), (-LOW, middle + half + k * TURN / 8.0))
    yield ((HIGH, middle), (-HIGH, middle + half))


def _blocks(path: Toolpath) -> Iterator[tuple[slice, NDArray[np.bool_]]]:
    """The rows of a toolpath, some at a time, and which of them are deposited."""
    for first in range(0, len(path), AT_ONCE):
        rows = slice(first, first + AT_ONCE)
        yield rows, path.deposits[rows]


def ranges_of_deposit(path: Toolpath, ways: Array) -> Array:
    """The least and the most (2, k) of what is deposited along the vectors `ways` (3, k), mm; infinite where nothing is."""
    out = np.stack([np.full(ways.shape[1], np.inf), np.full(ways.shape[1], -np.inf)])
    for rows, laid in _blocks(path):
        found = path.points[rows][laid] @ ways
        out[0] = np.minimum(out[0], found.min(axis=0, initial=np.inf))
        out[1] = np.maximum(out[1], found.max(axis=0, initial=-np.inf))
    return out


def _ranges(plan: Plan, mesh: Mesh, ways: Array) -> Array:
    """The same of a plan; of its part where it deposits nothing."""
    if plan.toolpath.deposits.any():
        return ranges_of_deposit(plan.toolpath, ways)
    along_ways = mesh.points @ ways
    return np.stack([along_ways.min(axis=0), along_ways.max(axis=0)])


def _view(plan: Plan, mesh: Mesh, towards: Array) -> View:
    axis = plan.axis.direction
    level = np.cross(axis, towards)
    level /= np.linalg.norm(level)
    along = np.cross(towards, level)
    wide, deep, high = np.ptp(_ranges(plan, mesh, plan.axis.rotation.T), axis=0)
    lying = high > LYING * max(wide, deep, 1e-9)
    right, up = (along, -level) if lying else (level, along)
    view = View(right=right, up=up, towards=towards, box=(0.0, 0.0, 1.0, 1.0))
    first, last = _ranges(plan, mesh, np.stack([right, up], axis=1))
    part, low, high = view.flat(mesh.points), first, last
    room = AROUND * (high - low).max() + plan.process.width
    low, high = np.maximum(low - room, part.min(axis=0) - 0.1 * room), np.minimum(high + room, part.max(axis=0) + 0.1 * room)
    # a last layer may rise beyond the part
    low, high = np.minimum(low, first - 1.0), np.maximum(high, last + 1.0)
    return View(right=right, up=up, towards=towards, box=(*low.tolist(), *high.tolist()))


def slant_of(mesh: Mesh, view: View) -> Array:
    """How many times farther a way through each triangle is towards the eye than straight down, (m + 1,); the last is 1."""
    a, b, c = (mesh.points[mesh.triangles[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    size = np.maximum(np.linalg.norm(across, axis=1), 1e-300)
    return np.append(np.minimum(size / np.maximum(np.abs(along(across, view.towards)), size / MOST_SLANT), MOST_SLANT), 1.0)


def _in_view(view: View, mesh: Mesh, samples: Array, place: Array, width: float) -> Array:
    """Which places are in sight, (n,) of bool: some of their deposit lies no deeper than a bead below what is seen."""
    left, low, right, top = view.box
    scale = SMALL / max(right - left, top - low)
    size = (max(1, math.ceil((top - low) * scale)), max(1, math.ceil((right - left) * scale)))
    page = seen(view.places(mesh.points, scale), along(mesh.points, view.towards), mesh.triangles, size)
    at = view.places(samples, scale).astype(int)
    at = np.clip(at[:, 1], 0, size[0] - 1) * size[1] + np.clip(at[:, 0], 0, size[1] - 1)
    below = page.depth[at] - along(samples, view.towards)
    # a pixel of so small a page is some millimetres of metal deep
    return np.bincount(place, below < (width + 1.0 / scale) * slant_of(mesh, view)[page.triangle[at]]) > 0
