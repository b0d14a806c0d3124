"""Beads lifted to 3D, with travels between them that never cut through what stands.

In: the beads of each layer in the plane, the speeds, what stands already. Out: a Toolpath.

Words: *retract*, the radial way out from the end of a bead; *hop*, a short travel just above the layer; *clearance*, the
room above everything that stands in a longer travel's sweep; *sagitta*, how far a chord dips below its arc.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.fill import Bead
from brep_slicer.maps import TURN, Array, cartesian_from_flat, normals_from_flat
from brep_slicer.substrate.axis import Axis

from .obstacles import Obstacles
from .toolpath import Toolpath


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DepositLayer:
    """One layer as it is deposited: its number, `radius` and `thickness` in mm, its beads in order."""

    index: int
    radius: float
    thickness: float
    beads: tuple[Bead, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """How the nozzle moves: speeds in mm/s; clearance, hop_length, chord and margin in mm.

    `margin` is how far beside its path a travel looks for what stands in its way (half a bead width, say).
    """

    deposition_speed: float
    travel_speed: float
    clearance: float
    hop_length: float
    chord: float
    margin: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Rows:
    """Rows before they are put into the file's frame: (kappa, v) on the cylinder `radius`, one each."""

    layer: Array
    bead: Array
    deposits: Array
    flat: Array
    radius: Array
    order: Array
    factor: Array


def lift_layers(layers: Sequence[DepositLayer], motion: Motion, axis: Axis, obstacles: Obstacles) -> Toolpath:
    """The whole toolpath, in the file's frame: approach, every bead with the travel to it, retract at the end."""
    table = _BeadTable(layers)
    if not len(table.starts):
        none = np.zeros(0)
        rows = _Rows(
            layer=none, bead=none, deposits=none.astype(bool), flat=np.zeros((0, 2)), radius=none, order=none, factor=none
        )
        return _toolpath(rows, motion, axis)
    return _toolpath(_merged(_bead_rows(table, motion), _travel_rows(table, motion, obstacles)), motion, axis)


class _BeadTable:
    """All beads of all layers side by side: points, where each begins, its layer's figures."""

    def __init__(self, layers: Sequence[DepositLayer]) -> None:
        beads = [(layer, bead) for layer in layers for bead in layer.beads]
        counts = np.array([len(bead.points) for _, bead in beads], dtype=int)
        self.points = np.concatenate([np.zeros((0, 2)), *(bead.points for _, bead in beads)])
        factors = [np.ones(len(bead.points)) if bead.speed is None else bead.speed for _, bead in beads]
        self.factor = np.concatenate([np.zeros(0), *factors])
        self.bead = np.repeat(np.arange(len(beads)), counts)
        self.layer = np.array([layer.index for layer, _ in beads], dtype=int)
        self.radius = np.array([layer.radius for layer, _ in beads])
        self.thickness = np.array([layer.thickness for layer, _ in beads])
        last = np.cumsum(counts)
        self.starts, self.ends = self.points[last - counts], self.points[last - 1]


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
    deposits = np.concatenate([np.zeros(count, dtype=bool), np.ones(len(between), dtype=bool)])
    # a segment is laid at the mean of what is asked for at its two ends
    factor = np.concatenate([np.ones(count), 0.5 * (table.factor[inside] + table.factor[inside + 1])[segment]])
    order = np.concatenate([np.zeros(count), 1.0 + np.arange(len(between))])
    return _Rows(
        layer=table.layer[bead],
        bead=bead,
        deposits=deposits,
        flat=flat,
        radius=table.radius[bead],
        order=order,
        factor=factor,
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
        factor=np.ones(len(bead)),
    )


def _end_height(table: _BeadTable, motion: Motion) -> float:
    return float((table.radius + table.thickness).max() + motion.clearance)


def _heights(table: _BeadTable, theta0: Array, turn: Array, motion: Motion, obstacles: Obstacles) -> Array:
    """Radius (mm) of the cylinder that each travel moves on; the sagitta of its chords is on top."""
    built = np.maximum((table.radius + table.thickness)[:-1], (table.radius + table.thickness)[1:])
    # what was built before stands too, on a layer list that does not rise
    built = np.maximum(built, np.maximum.accumulate(table.radius)[:-1])
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
        for name in ("layer", "bead", "deposits", "flat", "radius", "order", "factor")
    ]
    index = np.lexsort((both[5], both[1]))
    layer, bead, deposits, flat, radius, order, factor = (column[index] for column in both)
    return _Rows(layer=layer, bead=bead, deposits=deposits, flat=flat, radius=radius, order=order, factor=factor)


def _toolpath(rows: _Rows, motion: Motion, axis: Axis) -> Toolpath:
    return Toolpath(
        layer=rows.layer.astype(np.int64),
        bead=rows.bead.astype(np.int64),
        deposits=rows.deposits,
        points=axis.file_from_axis(cartesian_from_flat(rows.flat, rows.radius)),
        normals=axis.file_from_axis_vectors(normals_from_flat(rows.flat, rows.radius)),
        kappa=rows.flat[:, 0].copy(),
        v=rows.flat[:, 1].copy(),
        radius=rows.radius.astype(float),
        speed=np.where(rows.deposits, motion.deposition_speed * rows.factor, motion.travel_speed),
    )
