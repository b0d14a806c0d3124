"""Deposited tracks in the unrolled plane, and what filling one layer gives.

In: points that a pattern planned in (kappa, v). Out: Bead and LayerFill values that the toolpath lifts.

Words: *bead*, one deposited track, laser on from its first point to its last; *pattern*, a rule that lays beads.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.curves.base import frozen_array
from brep_slicer.maps import Array
from brep_slicer.notices import Notice
from brep_slicer.wording import counted

if TYPE_CHECKING:
    from .tools.lobes import Shape


class BeadKind(enum.Enum):
    """What laid a bead."""

    HATCH = "hatch"
    ZIGZAG = "zigzag"
    CONTOUR = "contour"
    SPIRAL = "spiral"
    SKELETON = "skeleton"
    RING = "ring"
    HELIX = "helix"
    FLANK = "flank"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Bead:
    """One bead: `points` (n, 2) in (kappa, v), mm, n >= 2, kappa continuous (universal cover), in the order of deposition.

    A `closed` bead ends where it starts, or, round the shaft, a whole number of turns further on; its last point says so.
    `piece` is the index of the region's piece that it lies in. `speed` (n,), if given, are factors on the deposition speed at
    the points: where neighbouring beads come nearer, less metal is wanted.
    """

    points: Array
    kind: BeadKind
    piece: int = 0
    closed: bool = False
    speed: Array | None = None

    def __post_init__(self) -> None:
        points = frozen_array(self.points, name="points")
        if points.ndim != 2 or points.shape[1] != 2 or len(points) < 2:
            raise ValueError(f"points must have shape (n >= 2, 2), got {points.shape}")
        object.__setattr__(self, "points", points)
        if self.speed is not None:
            speed = frozen_array(self.speed, name="speed", shape=(len(points),))
            if not (speed > 0.0).all():
                raise ValueError("speed must hold factors above zero")
            object.__setattr__(self, "speed", speed)

    def __repr__(self) -> str:
        closed = ", closed" if self.closed else ""
        return f"Bead({self.kind.value}, {len(self.points)} points, {self.length():.5g} mm{closed}, piece {self.piece})"

    def length(self) -> float:
        """Length in mm; the same in the plane and on the cylinder (Eq. 16 of the paper)."""
        return float(np.hypot(*np.diff(self.points, axis=0).T).sum())

    def reversed(self) -> Bead:
        """The same bead, deposited the other way."""
        speed = None if self.speed is None else self.speed[::-1]
        return replace(self, points=self.points[::-1], speed=speed)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LayerFill:
    """The beads of one layer in the order of deposition, and what the pattern had to say about them.

    `angle` and `step_over` are those used (rad, mm), by piece: on a full turn they differ from those asked by the closing
    rule. `notes` are what is to be warned of (a piece too narrow for a bead, say), never silent. By piece, too: which
    `patterns` were chosen and why ("" where none had to be), the `metal` of the beads within the outline over what the piece
    holds, what they lay `beyond` it (over the same), how far inside of the outline what the inner pattern has to fill begins
    (`border`, mm), the `shapes` that areas are measured on, and the first piece whose beads are the same but for a turn about
    the axis (`copies`; its own number if there is none). Beads that are not `turnable` keep their directions.
    """

    beads: tuple[Bead, ...]
    angle: tuple[float, ...] = ()
    step_over: tuple[float, ...] = ()
    notes: tuple[Notice, ...] = ()
    patterns: tuple[str, ...] = ()
    metal: tuple[float, ...] = ()
    beyond: tuple[float, ...] = ()
    border: tuple[float, ...] = ()
    shapes: tuple[Shape, ...] = ()
    copies: tuple[int, ...] = ()
    turnable: bool = True

    def __repr__(self) -> str:
        length = sum(bead.length() for bead in self.beads)
        kinds = ", ".join(sorted({bead.kind.value for bead in self.beads})) or "empty"
        return f"LayerFill({counted(len(self.beads), 'bead')} ({kinds}), {length:.5g} mm, {counted(len(self.notes), 'note')})"
