"""The toolpath: every point of every bead and travel, with its normal, as columns.

In: lifted beads and travels. Out: a frozen Toolpath; its lengths and times by layer.

Words: *row*, one point; a row's kind and speed hold for the segment that ends there; *travel*, laser off.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array
from brep_slicer.wording import counted, in_words_of_length

COLUMNS = ("layer", "bead", "kind", "x", "y", "z", "nx", "ny", "nz", "kappa", "v", "radius", "speed")
KINDS = ("deposit", "travel")


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Toolpath:
    """Columns of equal length n.

    Attributes
    ----------
    layer, bead : ndarray of int, shape (n,)
        Layer from 0, and the bead's number in its layer, from 0 in the order of its fill: both are the same whichever layers
        are planned with it, and together they name a bead. A travel belongs to the layer and the bead that it goes to.
    deposits : ndarray of bool, shape (n,)
        Whether the segment that ends here is deposited (else it is travel).
    points, normals : ndarray, shape (n, 3)
        In the file's frame, mm; normals point outwards (the nozzle's axis is -n).
    kappa, v, radius : ndarray, shape (n,)
        In the axis frame, mm: kappa = radius * theta on the cylinder that the point itself lies on.
    speed : ndarray, shape (n,)
        mm/s along the segment that ends here.
    """

    layer: NDArray[np.int64]
    bead: NDArray[np.int64]
    deposits: NDArray[np.bool_]
    points: Array
    normals: Array
    kappa: Array
    v: Array
    radius: Array
    speed: Array

    def __post_init__(self) -> None:
        n = len(self.layer)
        for name in ("layer", "bead", "deposits", "points", "normals", "kappa", "v", "radius", "speed"):
            array = np.ascontiguousarray(getattr(self, name))
            if len(array) != n:
                raise ValueError(f"{name} has {len(array)} rows, layer has {n}")
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def __repr__(self) -> str:
        length, layers = self.segment_lengths(), len(np.unique(self.layer))
        laid, moved = (in_words_of_length(float(length[mine].sum())) for mine in (self.deposits, ~self.deposits))
        beads = counted(int(self.runs().max(initial=-1)) + 1, "bead")
        return f"Toolpath({counted(layers, 'layer')}, {beads}, {counted(len(self), 'point')}, {laid} deposited, {moved} travel)"

    def __len__(self) -> int:
        return len(self.layer)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Toolpath):
            return NotImplemented
        return all(np.array_equal(getattr(self, name), getattr(other, name)) for name in self.__slots__)

    __hash__ = None  # type: ignore[assignment]

    def runs(self) -> NDArray[np.int64]:
        """Which bead of the whole toolpath each row belongs to, counted from 0 in the order of deposition, shape (n,)."""
        if not len(self):
            return np.zeros(0, dtype=np.int64)
        other = (np.diff(self.bead) != 0) | (np.diff(self.layer) != 0)
        return np.concatenate([[0], np.cumsum(other)])

    def segment_lengths(self) -> Array:
        """Length of the segment that ends at each row, mm, shape (n,); 0 for the first.

        Deposited segments lie on a cylinder: their length is the geodesic one, from kappa and v (Eq. 16 of the paper).
        Travels are chords of the points as they stand.
        """
        chord = np.linalg.norm(np.diff(self.points, axis=0), axis=1)
        flat = np.hypot(np.diff(self.kappa), np.diff(self.v))
        return np.concatenate([[0.0], np.where(self.deposits[1:], flat, chord)])

    def summary_by_layer(self) -> list[dict[str, Any]]:
        """For each layer: its beads, deposited and travel length (mm), deposition and travel time (s)."""
        length = self.segment_lengths()
        time = length / self.speed
        out = []
        for number in np.unique(self.layer):
            mine = self.layer == number
            laid, moved = mine & self.deposits, mine & ~self.deposits
            out.append(
                {
                    "layer": int(number),
                    "beads": len(np.unique(self.bead[laid])),
                    "deposition_length_mm": float(length[laid].sum()),
                    "travel_length_mm": float(length[moved].sum()),
                    "deposition_time_s": float(time[laid].sum()),
                    "travel_time_s": float(time[moved].sum()),
                }
            )
        return out
