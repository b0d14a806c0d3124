"""Equal pieces of a layer, as a gear's teeth and a propeller's blades are: what is found out for one holds for all.

In: the pieces of a layer. Out: for each, the first piece that it equals, and how far along kappa it lies from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.maps import Array
from brep_slicer.region import Piece

# Pieces are equal if their outlines are no farther apart than this, mm: rounding of sections by the same engine.
SAME = 1e-9
# Each curve is compared at so many of its points.
PLACES = np.linspace(0.0, 1.0, 9)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Copies:
    """For each piece the number of the `first` one that equals it (its own if none before does) and the `shift` from it, mm."""

    first: tuple[int, ...]
    shift: tuple[float, ...]

    @property
    def leaders(self) -> list[int]:
        """The pieces that equal none before them."""
        return [i for i, first in enumerate(self.first) if i == first]


def copies_of(pieces: Sequence[Piece]) -> Copies:
    """Which pieces are others turned about the axis; pieces that go all the way round are themselves only."""
    found: dict[tuple[object, ...], list[tuple[int, Array]]] = {}
    first, shift = list(range(len(pieces))), [0.0] * len(pieces)
    if len(pieces) < 2:
        return Copies(first=tuple(first), shift=tuple(shift))
    for i, piece in enumerate(pieces):
        if piece.winds:
            continue
        points = np.concatenate([curve.points(PLACES) for loop in piece.loops for curve in loop.curves])
        key = tuple(tuple(curve.kind for curve in loop.curves) for loop in piece.loops)
        for number, others in found.setdefault(key, []):
            way = points - others
            moved = float(way[0, 0])
            if np.abs(way - np.array([moved, 0.0])).max() <= SAME:
                first[i], shift[i] = number, moved
                break
        else:
            found[key].append((i, points))
    return Copies(first=tuple(first), shift=tuple(shift))
