"""Beads lifted to 3D, with travels between them that never cut through what stands.

In: the beads of each layer in the plane, the speeds, what stands already. Out: a Toolpath.

Words: *retract*, the radial way out from the end of a bead; *hop*, a short travel just above the layer; *clearance*, the
room above everything that stands in a longer travel's sweep; *sagitta*, how far a chord dips below its arc.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.fill import Bead
from brep_slicer.maps import TURN, Array, cartesian_from_flat, lengths_along, normals_from_flat
from brep_slicer.substrate.axis import Axis

from .obstacles import Obstacles
from .toolpath import Toolpath


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DepositLayer:
    """One layer as it is deposited: its number, `radius` and `thickness` in mm, its beads in order.

    `numbers` are those of its beads in the layer, where these are not all that it has, or not in the fill's order.
    """

    index: int
    radius: float
    thickness: float
    beads: tuple[Bead, ...]
    numbers: tuple[int, ...] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How the nozzle moves: speeds in mm/s; clearance, hop_length, chord and margin in mm.

    `margin` is how far beside its path a travel looks for what stands in its way (half a bead width, say). Before a bead the
    nozzle runs `lead_in` mm straight towards its start, after it `lead_out` mm straight on, at deposition speed, laser off.
    The laser is switched on `laser_on_delay` mm before the start and off `laser_off_delay` mm before the end.
    """

    deposition_speed: float
    travel_speed: float
    clearance: float
    hop_length: float
    chord: float
    margin: float
    lead_in: float = 0.0
    lead_out: float = 0.0
    laser_on_delay: float = 0.0
    laser_off_delay: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rows:
    """Rows before they are put into the file's frame: (kappa, v) on the cylinder `radius`, one each."""

    layer: Array
    bead: Array
    deposits: Array
    flat: Array
    radius: Array
    order: Array
    speed: Array


def lift_layers(layers: Sequence[DepositLayer], motion: Motion, axis: Axis, obstacles: Obstacles) -> Toolpath:
    """The whole toolpath, in the file's frame: approach, every bead with the travel to it, retract at the end."""
    table = _BeadTable(layers, motion)
    if not len(table.starts):
        none = np.zeros(0)
        rows = _Rows(
            layer=none, bead=none, deposits=none.astype(bool), flat=np.zeros((0, 2)), radius=none, order=none, speed=none
        )
        return _toolpath(rows, table.number, axis)
    rows = _merged(_bead_rows(table, motion), _travel_rows(table, motion, obstacles))
    return _toolpath(rows, table.number, axis)


class _BeadTable:
    """All beads of all layers side by side, with their leads: points, where each begins, its layer's figures, its
    `number` there.

    `lead` marks the points that are a bead's lead-in or lead-out: the segments that touch them are not deposited.
    """

    def __init__(self, layers: Sequence[DepositLayer], motion: Motion) -> None:
        beads = [(layer, bead) for layer in layers for bead in layer.beads]
        runs = [_with_leads(bead, motion) for _, bead in beads]
        counts = np.array([len(points) for points, _, _ in runs], dtype=int)
        self.points = np.concatenate([np.zeros((0, 2)), *(points for points, _, _ in runs)])
        self.factor = np.concatenate([np.zeros(0), *(factor for _, factor, _ in runs)])
        self.lead = np.concatenate([np.zeros(0, dtype=bool), *(lead for _, _, lead in runs)])
        self.bead = np.repeat(np.arange(len(beads)), counts)
        numbers = [range(len(layer.beads)) if layer.numbers is None else layer.numbers for layer in layers]
        self.number = np.array([number for some in numbers for number in some], dtype=np.int64)
        self.layer = np.array([layer.index for layer, _ in beads], dtype=int)
        self.radius = np.array([layer.radius for layer, _ in beads])
        self.thickness = np.array([layer.thickness for layer, _ in beads])
        last = np.cumsum(counts)
        self.starts, self.ends = self.points[last - counts], self.points[last - 1]


def _with_leads(bead: Bead, motion: Motion) -> tuple[Array, Array, NDArray[np.bool_]]:
    """A bead's points, speed factors and which points are leads, straight on at both ends.

    The laser is on from `laser_on_delay` before the start to `laser_off_delay` before the end.
    """
    points = bead.points
    factor = np.ones(len(points)) if bead.speed is None else bead.speed
    lead = np.zeros(len(points), dtype=bool)
    if motion.laser_off_delay > 0.0:
        points, factor, lead = _off_before_the_end(points, factor, motion.laser_off_delay)
    for length, end, off in ((motion.laser_on_delay, 0, False), (motion.lead_in, 0, True), (motion.lead_out, -1, True)):
        if length > 0.0:
            way = points[0] - points[1] if end == 0 else points[-1] - points[-2]
            added = (points[end] + length / max(float(np.hypot(*way)), 1e-300) * way)[None]
            points = np.concatenate((added, points) if end == 0 else (points, added))
            factor = np.concatenate((factor[:1], factor) if end == 0 else (factor, factor[-1:]))
            lead = np.concatenate(([off], lead) if end == 0 else (lead, [off]))
    return points, factor, lead


def _off_before_the_end(points: Array, factor: Array, length: float) -> tuple[Array, Array, NDArray[np.bool_]]:
    """A point more, `length` before a bead's end; what comes after it is run with the laser off."""
    along = lengths_along(points)
    at = max(float(along[-1]) - length, 0.5 * float(along[-1]))
    k = min(int(np.searchsorted(along, at, side="right")), len(points) - 1)
    cut = np.array([[np.interp(at, along, points[:, i]) for i in (0, 1)]])
    points = np.concatenate([points[:k], cut, points[k:]])
    factor = np.concatenate([factor[:k], [np.interp(at, along, factor)], factor[k:]])
    return points, factor, np.arange(len(points)) > k


def _most_turn(radius: Array, chord: float) -> Array:
    """The largest angle (rad) whose sagitta on `radius` is `chord`."""
    return 2.0 * np.arccos(np.clip(1.0 - chord / radius, 0.0, 1.0))


def _bead_rows(table: _BeadTable, motion: Motion) -> _Rows:
    """Points of all beads, straight segments divided so that their chords stay within the tolerance in space."""
    inside = np.flatnonzero(np.diff(table.bead) == 0)
    a, b = table.points[inside], table.points[inside + 1]
    of = table.bead[inside]
    turn = np.abs(b[:, 0] - a[:, 0]) / table.radius[of]
    cuts = np.maximum(1, np.ceil(turn / _most_turn(table.radius[of], motion.chord) - 1e-9)).astype(int)
    segment = np.repeat(np.arange(len(a)), cuts)
    step = np.arange(len(segment)) - np.repeat(np.cumsum(cuts) - cuts, cuts) + 1
    share = (step / cuts[segment])[:, None]
    between = np.where(share == 1.0, b[segment], (1.0 - share) * a[segment] + share * b[segment])
    count = len(table.starts)
    bead = np.concatenate([np.arange(count), of[segment]])
    flat = np.concatenate([table.starts, between])
    # a bead's first point ends the travel to it
    laid = ~(table.lead[inside] | table.lead[inside + 1])
    deposits = np.concatenate([np.zeros(count, dtype=bool), laid[segment]])
    # a segment is laid at the mean of what is asked for at its two ends
    factor = np.where(laid, 0.5 * (table.factor[inside] + table.factor[inside + 1]), 1.0)
    speed = np.concatenate([np.full(count, motion.travel_speed), motion.deposition_speed * factor[segment]])
    order = np.concatenate([np.zeros(count), 1.0 + np.arange(len(between))])
    return _Rows(
        layer=table.layer[bead],
        bead=bead,
        deposits=deposits,
        flat=flat,
        radius=table.radius[bead],
        order=order,
        speed=speed,
    )


def _travel_rows(table: _BeadTable, motion: Motion, obstacles: Obstacles) -> _Rows:
    """For each bead the way to it: out from the end of the one before, along a larger cylinder, above its start."""
    theta0, theta1 = table.ends[:-1, 0] / table.radius[:-1], table.starts[1:, 0] / table.radius[1:]
    turn = np.mod(theta1 - theta0 + np.pi, TURN) - np.pi
    height = _heights(table, theta0, turn, motion, obstacles)
    cuts = np.maximum(1, np.ceil(np.abs(turn) / _most_turn(height, motion.chord) - 1e-9)).astype(int)
    move = np.repeat(np.arange(len(turn)), cuts + 1)
    step = np.arange(len(move)) - np.repeat(np.cumsum(cuts + 1) - (cuts + 1), cuts + 1)
    share = step / cuts[move]
    theta = theta0[move] + share * turn[move]
    v = (1.0 - share) * table.ends[:-1, 1][move] + share * table.starts[1:, 1][move]
    above = np.array([table.radius[0] + table.thickness[0] + motion.clearance])
    top = _end_height(table, motion)
    flat = np.concatenate(
        [
            [[table.starts[0, 0] / table.radius[0] * above[0], table.starts[0, 1]]],
            np.stack([theta * height[move], v], axis=1),
            [[table.ends[-1, 0] / table.radius[-1] * top, table.ends[-1, 1]]],
        ]
    )
    bead = np.concatenate([[0], move + 1, [len(table.starts) - 1]])
    radius = np.concatenate([above, height[move], [top]])
    # travels come before the bead that they lead to, the last retract after everything
    order = np.concatenate([[-1.0], step - 1e9, [np.inf]])
    return _Rows(
        layer=table.layer[bead],
        bead=bead,
        deposits=np.zeros(len(bead), dtype=bool),
        flat=flat,
        radius=radius,
        order=order,
        speed=np.full(len(bead), motion.travel_speed),
    )


def _end_height(table: _BeadTable, motion: Motion) -> float:
    return float((table.radius + table.thickness).max() + motion.clearance)


def _heights(table: _BeadTable, theta0: Array, turn: Array, motion: Motion, obstacles: Obstacles) -> Array:
    """Radius (mm) of the cylinder that each travel moves on; the sagitta of its chords is on top."""
    built = np.maximum((table.radius + table.thickness)[:-1], (table.radius + table.thickness)[1:])
    # what was built before stands too, where layers do not rise from bead to bead (one feature built after another)
    built = np.maximum(built, np.maximum.accumulate(table.radius + table.thickness)[:-1])
    start = np.stack([theta0, table.ends[:-1, 1]], axis=1)
    end = np.stack([theta0 + turn, table.starts[1:, 1]], axis=1)
    standing = obstacles.highest(start, end, motion.margin, float(table.radius.min()))
    length = np.hypot(built * turn, end[:, 1] - start[:, 1])
    low = built + np.maximum(table.thickness[:-1], table.thickness[1:])
    hops = (length <= motion.hop_length) & (standing <= built)
    return np.where(hops, low, np.maximum(built, standing) + motion.clearance) + motion.chord


def _merged(beads: _Rows, travels: _Rows) -> _Rows:
    both = [
        np.concatenate([getattr(beads, name), getattr(travels, name)])
        for name in ("layer", "bead", "deposits", "flat", "radius", "order", "speed")
    ]
    index = np.lexsort((both[5], both[1]))
    layer, bead, deposits, flat, radius, order, speed = (column[index] for column in both)
    return _Rows(layer=layer, bead=bead, deposits=deposits, flat=flat, radius=radius, order=order, speed=speed)


def _toolpath(rows: _Rows, number: NDArray[np.int64], axis: Axis) -> Toolpath:
    return Toolpath(
        layer=rows.layer.astype(np.int64),
        bead=number[rows.bead.astype(np.int64)],
        deposits=rows.deposits,
        points=axis.file_from_axis(cartesian_from_flat(rows.flat, rows.radius)),
        normals=axis.file_from_axis_vectors(normals_from_flat(rows.flat, rows.radius)),
        kappa=rows.flat[:, 0].copy(),
        v=rows.flat[:, 1].copy(),
        radius=rows.radius.astype(float),
        speed=rows.speed,
    )
