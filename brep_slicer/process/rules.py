"""Rules: other fill parameters for some layers and pieces.

In: which ones, and what is different there. Out: frozen Rule values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from brep_slicer.errors import InputError
from brep_slicer.wording import shortened

from .taken import Taken, default
from .values import as_written, check_names, layer_range, positive, switch, whole

RULED = (
    "pattern",
    "contours",
    "contours_outwards",
    "hatch",
    "hatch_angles_deg",
    "hatch_angle_step_deg",
    "both_ways",
    "stretch",
    "overlap",
    "starts",
    "left_handed",
    "closing_rings",
    "start_angle_deg",
)
# What a rule has beside its changes: where it holds.
WHERE = ("layers", "every", "narrower_than", "winds")
Layers = tuple[int | None, int | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Rule:
    """Other fill parameters for some layers and pieces.

    It holds on layers from the first of `layers` to before the second (None: no end; or a text "a:b"), on every so many of
    them, for pieces nowhere wider than `narrower_than` (mm) and, if `winds` is given, only for those that do, or do not, go
    all the way round.
    `changes` are the parameters that differ there, of those in RULED.

    Raises
    ------
    InputError
        If a value cannot be used, or nothing is changed.
    """

    changes: Mapping[str, Any]
    layers: Taken[Layers, Layers | Sequence[int | None] | str] = default((None, None))
    every: int = 1
    narrower_than: float | None = None
    winds: bool | None = None

    def __new__(cls, *args: Any, **given: Any) -> Rule:
        """Names that a rule does not have are told of with what to write instead."""
        inside = [name for name in given if name in RULED]
        if inside:
            text = shortened(f"changes={{{inside[0]!r}: {given[inside[0]]!r}}}")
            raise InputError(f"a rule has {inside[0]} among its changes; write {text}")
        check_names(given, ("changes", *WHERE), "field of a rule")
        return object.__new__(cls)

    def __post_init__(self) -> None:
        if not isinstance(self.changes, Mapping):
            raise InputError(f"a rule's changes is {self.changes!r}; give names and values, as {{'contours': 2}}")
        check_names(self.changes, RULED, "process parameter that a rule may change")
        if not self.changes:
            raise InputError(f"a rule changes nothing; it may change {', '.join(RULED)}")
        object.__setattr__(self, "layers", layer_range("layers", self.layers))
        if whole("every", self.every) < 1:
            raise InputError(f"a rule's every is {self.every}; it must be 1 or more")
        if self.narrower_than is not None:
            positive("narrower_than", self.narrower_than)
        if self.winds is not None:
            switch("winds", self.winds)

    def __repr__(self) -> str:
        where = [f"{name} {value}" for name, value in self.as_dict().items() if name in WHERE and (name, value) != ("every", 1)]
        changes = ", ".join(f"{name}={as_written(name, value)!r}" for name, value in self.changes.items())
        return f"Rule({', '.join(where)}: {shortened(changes, 120)})"

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
        return out | {name: as_written(name, value) for name, value in self.changes.items()}


def as_rule(value: Any) -> Rule:
    """A Rule from itself, or from a table as it stands in a process file: where it holds and what it changes, side by side.

    Raises
    ------
    InputError
        If it is neither, or holds what no rule has.
    """
    if isinstance(value, Rule):
        return value
    if not isinstance(value, Mapping):
        raise InputError(f"rules is {value!r}; write each rule as a table, under [[rules]] (in Python a Rule or a dict)")
    where = {name: given for name, given in value.items() if name in WHERE}
    changes = {name: given for name, given in value.items() if name not in (*WHERE, "changes")}
    check_names(changes, (*RULED, *WHERE), "process parameter that a rule may change")
    return Rule(changes={**value.get("changes", {}), **changes}, **where)
