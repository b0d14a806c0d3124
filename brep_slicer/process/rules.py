"""Rules: other fill parameters for some layers and pieces.

In: which ones, and what is different there. Out: frozen Rule values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

from brep_slicer.errors import InputError
from brep_slicer.wording import shortened

from .former import RENAMED
from .groups import Fill
from .parameter import Declared, as_written, check_names, declarations_of, parameter
from .taken import Taken
from .values import layer_range

# What a rule may change: the parameters of `fill` that go by piece.
RULED = tuple(name for name, one in declarations_of(Fill).items() if one.by_piece)
WHAT_RULED = "process parameter that a rule may change"
Layers = tuple[int | None, int | None]


def _layers(name: str, value: Any) -> Layers:
    return layer_range(name, value)


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Rule(Declared):
    """Other fill parameters for some layers and pieces.

    It holds on layers from the first of `layers` to before the second (None: no end; or a text "a:b"), on every so many of
    them, for pieces nowhere wider than `narrower_than` (mm) and, if `full_turn` is given, only for those that do, or do not, go
    all the way round.
    `changes` are the parameters that differ there, of those in RULED.

    Raises
    ------
    InputError
        If a value cannot be used, or nothing is changed.
    """

    changes: Mapping[str, Any]
    layers: Taken[Layers, Layers | Sequence[int | None] | str] = parameter(
        (None, None), kind="layers", check=_layers, help="The layers it holds on, as 'a:b', from a to before b"
    )
    every: int = parameter(1, least=1, help="It holds on every so many of them")
    narrower_than: float | None = parameter(
        None, unit="mm", above=0.0, example=8.0, assumed="however wide", help="It holds for pieces nowhere wider than this"
    )
    full_turn: bool | None = parameter(
        None, kind=bool, example=True, assumed="for both", help="It holds for pieces that do, or do not, go all the way round"
    )

    def __new__(cls, *args: Any, **given: Any) -> Rule:
        """Names that a rule does not have are told of with what to write instead."""
        inside = [name for name in given if name in RULED]
        if inside:
            text = shortened(f"changes={{{inside[0]!r}: {given[inside[0]]!r}}}")
            raise InputError(f"a rule has {inside[0]} among its changes; write {text}")
        check_names(given, ("changes", *WHERE), "field of a rule", {"winds": "it is full_turn now"})
        return object.__new__(cls)

    def __post_init__(self) -> None:
        if not isinstance(self.changes, Mapping):
            raise InputError(f"a rule's changes is {self.changes!r}; give names and values, as {{'contours': 2}}")
        check_names(self.changes, RULED, WHAT_RULED, RENAMED)
        if not self.changes:
            raise InputError(f"a rule changes nothing; it may change {', '.join(RULED)}")
        try:
            Declared.__post_init__(self)
            checks = declarations_of(Fill)
            checked = {name: checks[name].checked(name, value) for name, value in self.changes.items()}
        except InputError as error:
            raise InputError(f"in a rule: {error}") from None
        object.__setattr__(self, "changes", checked)

    def __repr__(self) -> str:
        where = [f"{name} {value}" for name, value in self.as_dict().items() if name in WHERE and (name, value) != ("every", 1)]
        changes = ", ".join(f"{name}={as_written(value)!r}" for name, value in self.changes.items())
        return f"Rule({', '.join(where)}: {shortened(changes, 120)})"

    def on_layer(self, layer: int) -> bool:
        """Whether the rule holds for some pieces of a layer."""
        first, last = self.layers[0] or 0, self.layers[1]
        return layer >= first and (last is None or layer < last) and (layer - first) % self.every == 0

    def as_dict(self) -> dict[str, Any]:
        """Plain values, as in a process file."""
        out: dict[str, Any] = {"layers": ":".join("" if n is None else str(n) for n in self.layers), "every": self.every}
        out |= {name: getattr(self, name) for name in ("narrower_than", "full_turn") if getattr(self, name) is not None}
        return out | {name: as_written(value) for name, value in self.changes.items()}


# What a rule has beside its changes: where it holds.
WHERE = tuple(one.name for one in fields(Rule) if one.name != "changes")


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
    check_names(changes, (*RULED, *WHERE), WHAT_RULED, {"winds": "it is full_turn now"} | RENAMED)
    return Rule(changes={**value.get("changes", {}), **changes}, **where)
