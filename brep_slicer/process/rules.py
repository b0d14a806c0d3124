"""Rules: other fill parameters for some layers and pieces.

In: which ones, and what is different there. Out: frozen Rule values.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from brep_slicer.errors import InputError

from .values import as_written, positive

RULED = (
    "pattern",
    "contours",
    "contours_outwards",
    "hatch",
    "hatch_angles",
    "hatch_angle_step",
    "both_ways",
    "stretch",
    "overlap",
    "starts",
    "left_handed",
    "closing_rings",
    "start_angle",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """Other fill parameters for some layers and pieces.

    It holds on layers from the first of `layers` to before the second (None: no end), on every so many of them, for pieces
    nowhere wider than `narrower_than` (mm) and, if `winds` is given, only for those that do, or do not, go all the way round.
    `changes` are the parameters that differ there, of those in RULED.

    Raises
    ------
    InputError
        If a value cannot be used, or nothing is changed.
    """

    changes: Mapping[str, Any]
    layers: tuple[int | None, int | None] = (None, None)
    every: int = 1
    narrower_than: float | None = None
    winds: bool | None = None

    def __post_init__(self) -> None:
        wrong = sorted(set(self.changes) - set(RULED))
        if wrong or not self.changes:
            what = f"{', '.join(wrong)} cannot be changed by a rule" if wrong else "a rule changes nothing"
            raise InputError(f"{what}; it may change {', '.join(RULED)}")
        if self.every < 1:
            raise InputError(f"a rule's every is {self.every}; it must be 1 or more")
        if self.narrower_than is not None:
            positive("narrower_than", self.narrower_than)

    def on_layer(self, layer: int) -> bool:
        """Whether the rule holds for some pieces of a layer."""
        first, last = self.layers[0] or 0, self.layers[1]
        return layer >= first and (last is None or layer < last) and (layer - first) % self.every == 0

    def as_dict(self) -> dict[str, Any]:
        """Plain values, as in a process file."""
        out: dict[str, Any] = {"layers": ":".join("" if n is None else str(n) for n in self.layers), "every": self.every}
        if self.narrower_than is not None:
            out["narrower_than"] = self.narrower_than
        if self.winds is not None:
            out["winds"] = self.winds
        return out | dict(as_written(name, value) for name, value in self.changes.items())
