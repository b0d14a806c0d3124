"""Notes and warnings as values: what kind, of which layers and pieces, with which figures; worded once, where they are shown.

In: what a stage has to say. Out: Notice values, which can be grouped, and their sentences.
"""

from __future__ import annotations

import enum
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

Span = tuple[float, float]
# The figure that says how large the pieces are, shown behind their numbers.
AREA = "area_mm2"


class NoticeKind(enum.Enum):
    """What a notice is about."""

    PART = "part"
    SUBSTRATE = "substrate"
    STACK = "stack"
    FAILED = "failed layer"
    OUTLINE = "outline's error"
    EMPTY = "empty layer"
    OVER_ITSELF = "section over itself"
    ON_AIR = "metal on air"
    WEAK_BELOW = "built on too little"
    PATTERN = "pattern"
    NARROW = "narrow piece"
    SHORT_BEADS = "short beads"
    SPEED = "speed"
    BARE = "bare piece"
    METAL = "metal of a layer"
    PIECE_METAL = "metal of a piece"
    PEAK = "peak of the deposit"


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """One thing to say, of `layers` and `pieces` (their numbers; none: of the whole plan or layer).

    `figures` are lowest and highest values by name, units in the names; `{name}` in `text` stands for one of them.
    """

    kind: NoticeKind
    text: str
    layers: tuple[int, ...] = ()
    pieces: tuple[int, ...] = ()
    figures: Mapping[str, Span] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "figures", MappingProxyType(dict(self.figures)))

    def on_layer(self, layer: int) -> Notice:
        """The same, of that layer."""
        return replace(self, layers=(layer,))

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for a report."""
        return {
            "kind": self.kind.value,
            "layers": list(self.layers),
            "pieces": list(self.pieces),
            "figures": {name: list(span) for name, span in self.figures.items()},
            "text": str(self),
        }

    def __str__(self) -> str:
        """The sentence: 'layers 3 to 8, pieces 0, 2 (1.2 to 3.4 mm2): text'."""
        text = self.text
        for name, span in self.figures.items():
            text = text.replace("{" + name + "}", _span(span))
        numbers = [_numbers(word, each) for word, each in (("layer", self.layers), ("piece", self.pieces)) if each]
        size = f" ({_span(self.figures[AREA])} mm2)" if numbers and AREA in self.figures else ""
        return f"{', '.join(numbers)}{size}: {text}" if numbers else text


def grouped(notices: Iterable[Notice]) -> tuple[Notice, ...]:
    """One notice for each thing that is said, in the order of the first of each, with all layers, pieces and figures."""
    said: dict[tuple[NoticeKind, str], Notice] = {}
    for notice in notices:
        key = notice.kind, notice.text
        said[key] = _joined(said[key], notice) if key in said else notice
    return tuple(said.values())


def _joined(a: Notice, b: Notice) -> Notice:
    figures = dict(a.figures)
    for name, (low, high) in b.figures.items():
        before = figures.get(name, (low, high))
        figures[name] = min(before[0], low), max(before[1], high)
    layers, pieces = (tuple(sorted({*one, *other})) for one, other in ((a.layers, b.layers), (a.pieces, b.pieces)))
    return replace(a, layers=layers, pieces=pieces, figures=figures)


def _span(span: Span) -> str:
    """'1.2', or '1.2 to 3.4'."""
    low, high = (f"{value:.4g}" for value in span)
    return low if low == high else f"{low} to {high}"


def _numbers(word: str, numbers: Iterable[int]) -> str:
    """'layer 3', 'layers 3 to 8, 12'."""
    runs: list[list[int]] = []
    for n in sorted(numbers):
        if runs and n == runs[-1][1] + 1:
            runs[-1][1] = n
        else:
            runs.append([n, n])
    text = ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in runs)
    return f"{word}{'s' if len(runs) > 1 or runs[0][0] != runs[0][1] else ''} {text}"
