"""Flank-following beads: parallel to the long edges of a piece, as the paper's experiment laid them.

In: a cell. Out: hatch beads in the direction of the piece's flanks: kappa = const on a spur tooth, the helix on a helical one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from brep_slicer.region import Piece

from .bead import Bead, BeadKind
from .hatch import Hatch
from .pattern import Cell, CellFill, Pattern

# Two flanks are parallel when their directions differ by less than this (rad).
PARALLEL = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class FlankFollowing(Pattern):
    """Beads along the flanks, found from the section's own two longest edges; `both_ways` as in a hatch.

    Where the flanks are not parallel, the beads follow the direction between them, and the notes say by how much they differ.
    """

    both_ways: bool = True

    def fill(self, cell: Cell) -> CellFill:
        angle, spread = flank_direction(cell.piece)
        made = Hatch(angle=angle, both_ways=self.both_ways).fill(cell)
        beads = tuple(Bead(points=b.points, kind=BeadKind.FLANK, piece=b.piece, closed=b.closed) for b in made.beads)
        notes = made.notes
        if spread > PARALLEL:
            notes = (*notes, f"its flanks are {math.degrees(spread):.3g} degrees apart: beads follow the middle")
        return replace(made, beads=beads, notes=notes)


def flank_direction(piece: Piece) -> tuple[float, float]:
    """Direction (rad, in (-pi/2, pi/2]) of a piece's two longest edges, and the angle between the two (rad)."""
    curves = [curve for loop in piece.outer for curve in loop.curves]
    lengths = [curve.length() for curve in curves]
    longest = np.argsort(lengths)[::-1][:2]
    angles = []
    for i in longest:
        along = curves[int(i)].end - curves[int(i)].start
        angles.append(math.atan2(along[1], along[0]))
    # directions of lines, not of arrows: the mean is taken on the doubled angles
    doubled = [complex(math.cos(2.0 * a), math.sin(2.0 * a)) for a in angles]
    mean = 0.5 * math.atan2(sum(doubled).imag, sum(doubled).real)
    spread = abs(math.remainder(angles[0] - angles[-1], math.pi))
    return (mean if mean > -0.5 * math.pi + 1e-15 else 0.5 * math.pi), spread
