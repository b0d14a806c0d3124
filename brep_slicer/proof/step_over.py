"""Step-over between neighbouring beads, measured as geodesics on the points that a toolpath emits.

In: a toolpath, its axis. Out: for each layer the distances from points of beads to the nearest other bead.

A cylinder is developable: the geodesic distance of two of its points is the distance of (R theta, z) in the plane. theta and z
are taken from the emitted x, y, z; nothing of the plan is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import TURN, Array, lengths_along
from brep_slicer.substrate.axis import Axis
from brep_slicer.toolpath import Toolpath

# Along a bead, distances are measured this often (shares of it).
SAMPLES = np.linspace(0.1, 0.9, 9)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class StepOver:
    """Distances (n,) in mm from places along beads to the nearest neighbouring bead, where a perpendicular meets one.

    `between` (n, 2) are the numbers of the two beads, as the toolpath has them.
    """

    spacings: Array
    between: NDArray[np.int64]

    @property
    def lowest(self) -> float:
        """The smallest, mm (nan if there is none)."""
        return float(self.spacings.min()) if len(self.spacings) else float("nan")

    @property
    def highest(self) -> float:
        """The largest, mm (nan if there is none)."""
        return float(self.spacings.max()) if len(self.spacings) else float("nan")


def step_over_of(toolpath: Toolpath, axis: Axis, layer: int) -> StepOver:
    """Measure one layer: from each bead to the nearest other one, or to its own neighbouring turn."""
    mine = (toolpath.layer == layer) & (toolpath.deposits | np.roll(toolpath.deposits & (toolpath.layer == layer), -1))
    points, of = axis.axis_from_file(toolpath.points[mine]), toolpath.bead[mine]
    # a single point is no bead
    numbers = [number for number in np.unique(of) if np.count_nonzero(of == number) > 1]
    beads = [_unrolled(points[of == number]) for number in numbers]
    if not beads:
        return StepOver(spacings=np.zeros(0), between=np.zeros((0, 2), dtype=np.int64))
    period = TURN * beads[0][1]
    starts, ends, owner = [], [], []
    for number, (points, _) in zip(numbers, beads, strict=True):
        for turn in range(-_turns(points, period), _turns(points, period) + 1):
            copy = points + np.array([turn * period, 0.0])
            starts.append(copy[:-1])
            ends.append(copy[1:])
            owner.append(np.full(len(copy) - 1, number))
    a, b, of = np.concatenate(starts), np.concatenate(ends), np.concatenate(owner)
    found = [_nearest(points, number, a, b, of) for number, (points, _) in zip(numbers, beads, strict=True)]
    between = [np.stack([np.full(len(near), n), near], axis=1) for n, (_, near) in zip(numbers, found, strict=True)]
    return StepOver(spacings=np.concatenate([gaps for gaps, _ in found]), between=np.concatenate(between).astype(np.int64))


def _turns(points: Array, period: float) -> int:
    return 1 + int(np.ceil(np.abs(points[:, 0]).max() / period))


def _unrolled(points: Array) -> tuple[Array, float]:
    radius = float(np.hypot(points[:, 0], points[:, 1]).mean()) if len(points) else 1.0
    theta = np.unwrap(np.arctan2(points[:, 1], points[:, 0]))
    return np.stack([radius * theta, points[:, 2]], axis=1), radius


def _nearest(points: Array, number: int, a: Array, b: Array, of: Array) -> tuple[Array, Array]:
    """Distances from places along one bead to the nearest segment of another that a perpendicular meets, and whose it is."""
    along = lengths_along(points)
    at = SAMPLES * along[-1]
    places = np.stack([np.interp(at, along, points[:, k]) for k in (0, 1)], axis=1)
    d = b - a
    size = np.maximum(np.einsum("ij,ij->i", d, d), 1e-300)
    share = np.einsum("nkj,kj->nk", places[:, None] - a[None], d) / size
    foot = a[None] + np.clip(share, 0.0, 1.0)[..., None] * d[None]
    gap = np.hypot(*np.moveaxis(places[:, None] - foot, -1, 0))
    # a foot at a bead's end is no perpendicular; joints between a bead's own segments are none either
    square = (share >= -1e-9) & (share <= 1.0 + 1e-9)
    gap = np.where(square & ((of != number)[None] | (gap > 1e-3)), gap, np.inf)
    at_best = gap.argmin(axis=1)
    best = gap[np.arange(len(gap)), at_best]
    met = np.isfinite(best)
    return best[met], of[at_best[met]]
