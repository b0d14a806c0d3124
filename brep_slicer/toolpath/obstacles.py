"""What stands in the way of a travel: flanges and other parts of the substrate beyond the layer.

In: the solids that stand already. Out: boxes in (theta, z) with the radius that they reach; heights along a sweep.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from brep_slicer.field import radii_of
from brep_slicer.geometry import Brep, Face
from brep_slicer.maps import TURN, Array

# Every face is covered by this many cells a side; a cell counts with its highest corner and its own size as margin.
CELLS = 16
# Sweeps at a time that are held against the boxes near all of them.
SWEEPS_AT_ONCE = 256


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Obstacles:
    """Boxes (n,): middle angle and half angle (rad), lowest and highest z (mm), outermost radius (mm)."""

    theta: Array
    half: Array
    z_low: Array
    z_high: Array
    radius: Array

    def within(self, zones: Sequence[tuple[float, float]]) -> Obstacles:
        """Those whose middle lies between the heights (low, high) of one of the zones, mm."""
        middle = 0.5 * (self.z_low + self.z_high)
        inside = np.zeros(len(middle), dtype=bool)
        for low, high in zones:
            inside |= (middle >= low) & (middle <= high)
        return Obstacles(**{f.name: getattr(self, f.name)[inside] for f in fields(self)})

    def joined(self, other: Obstacles) -> Obstacles:
        """These and the other ones."""
        return Obstacles(**{f.name: np.concatenate([getattr(self, f.name), getattr(other, f.name)]) for f in fields(self)})

    def highest(self, start: Array, end: Array, margin: float, at_radius: float) -> Array:
        """Outermost radius (mm) in the sweeps from `start` to `end`, (m, 2) in (theta, z); 0 where nothing stands.

        `margin` (mm) widens the sweep on all sides, at `at_radius`.
        """
        if not len(self.theta):
            return np.zeros(len(start))
        middle, reach = 0.5 * (start[:, 0] + end[:, 0]), 0.5 * np.abs(end[:, 0] - start[:, 0]) + margin / at_radius
        low, high = np.minimum(start[:, 1], end[:, 1]) - margin, np.maximum(start[:, 1], end[:, 1]) + margin
        out = np.zeros(len(start))
        # sweeps that follow one another lie near each other: few boxes meet any of them
        for first in range(0, len(start), SWEEPS_AT_ONCE):
            rows = slice(first, first + SWEEPS_AT_ONCE)
            out[rows] = self._highest(middle[rows], reach[rows], low[rows], high[rows])
        return out

    def _highest(self, middle: Array, reach: Array, low: Array, high: Array) -> Array:
        """Outermost radius (mm) in the sweeps `reach` (rad) to either side of `middle`, from height `low` to `high`."""
        around = float((_apart(middle, middle[0]) + reach).max())
        near = np.flatnonzero(
            (self.z_high >= low.min()) & (self.z_low <= high.max()) & (_apart(self.theta, middle[0]) <= self.half + around)
        )
        meets = _apart(middle[:, None], self.theta[near]) <= reach[:, None] + self.half[near]
        meets &= (self.z_high[near] >= low[:, None]) & (self.z_low[near] <= high[:, None])
        return np.where(meets, self.radius[near], 0.0).max(axis=1, initial=0.0)


def _apart(a: Array, b: Array | float) -> Array:
    """The angle (rad, not above pi) between directions."""
    return np.abs(np.mod(a - b + np.pi, TURN) - np.pi)


def obstacles_of(solids: Sequence[Brep], beyond: float) -> Obstacles:
    """The boxes of every face cell that reaches farther out than `beyond` (mm)."""
    rows = [_cells(face) + np.array([0.0, 0.0, solid.lift, solid.lift, 0.0]) for solid in solids for face in solid.faces]
    table = np.concatenate([np.zeros((0, 5)), *rows])
    table = table[table[:, 4] > beyond]
    return Obstacles(theta=table[:, 0], half=table[:, 1], z_low=table[:, 2], z_high=table[:, 3], radius=table[:, 4])


def _cells(face: Face) -> Array:
    lines = [np.linspace(face.box[0, k], face.box[1, k], CELLS + 1) for k in (0, 1)]
    uv = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    p = face.surface.points(uv).reshape(CELLS + 1, CELLS + 1, 3)
    corners = np.stack([p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]], axis=-2).reshape(-1, 4, 3)
    size = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1)
    rho = radii_of(corners)
    theta = np.arctan2(corners[..., 1], corners[..., 0])
    offset = np.mod(theta - theta[:, :1] + np.pi, TURN) - np.pi
    low, high = offset.min(axis=1), offset.max(axis=1)
    outermost = rho.max(axis=1) + 0.05 * size
    half = 0.5 * (high - low) + 0.05 * size / np.maximum(outermost, 1e-9)
    z = corners[..., 2]
    return np.stack(
        [theta[:, 0] + 0.5 * (low + high), half, z.min(axis=1) - 0.05 * size, z.max(axis=1) + 0.05 * size, outermost], axis=1
    )
