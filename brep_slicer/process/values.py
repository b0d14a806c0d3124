"""Plain values and what they may be: the choices, numbers that are checked, names and units as a file has them.

In: values from anywhere. Out: the same, checked, or an InputError that names them.
"""

from __future__ import annotations

import enum
import itertools
import math
import operator
from collections.abc import Iterable, Sequence
from typing import Any

from brep_slicer.errors import InputError
from brep_slicer.wording import nearest_name


class LastLayer(enum.Enum):
    """What becomes of a last layer that the height does not fill: kept, unless next to nothing of it is part; or as told."""

    KEEP = "keep"
    DROP = "drop"
    STRETCH = "stretch"
    AUTO = "auto"


class OutlinePosition(enum.Enum):
    """Where the centre of the outermost bead runs: half a bead inside of the outline, on it, or half a bead outside."""

    IN = "in"
    ON = "on"
    OUT = "out"


class Order(enum.Enum):
    """In which order the beads of a layer are laid: as the pattern has them, or so that travels are short."""

    PATTERN = "pattern"
    SHORTEST = "shortest"


class CutAt(enum.Enum):
    """Where in its thickness a layer is cut."""

    BOTTOM = "bottom"
    MIDDLE = "middle"


# No machine moves slower or faster than these (mm/s), and times worked out of them stay finite.
SLOWEST_SPEED, FASTEST_SPEED = 1e-6, 1e6


def listed(name: str, value: Any) -> tuple[Any, ...]:
    """One value, or several, as a tuple that is not empty."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        return (value,)
    out = tuple(value)
    if not out:
        raise InputError(f"{name} is an empty list; give one at least")
    return out


def check_radii(radii: Sequence[float]) -> tuple[float, ...]:
    """Increasing positive radii, or an InputError that says which one is not."""
    if isinstance(radii, str) or not isinstance(radii, Iterable):
        raise InputError(f"radii is {radii!r}; give a list of increasing radii, mm")
    values = tuple(positive("radius", r) for r in radii)
    if not values:
        raise InputError("the list of radii is empty; give one radius at least")
    for before, after in itertools.pairwise(values):
        if after <= before:
            raise InputError(f"radius {after:g} mm follows {before:g} mm; the radii must increase")
    return values


def check_levels(levels: Sequence[float]) -> tuple[float, ...]:
    """Increasing levels of a family of layers, or an InputError that says which one is not."""
    if isinstance(levels, str) or not isinstance(levels, Iterable):
        raise InputError(f"the levels are {levels!r}; give a list of increasing numbers, mm")
    values = tuple(finite("level", c) for c in levels)
    if not values:
        raise InputError("the list of levels is empty; give one at least")
    for before, after in itertools.pairwise(values):
        if after <= before:
            raise InputError(f"level {after:g} mm follows {before:g} mm; the levels must increase")
    return values


def finite(name: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; it must be a number") from None
    if isinstance(value, str):
        raise InputError(f"{name} is {value!r}, a text; write the number without quotes")
    if isinstance(value, bool) or not math.isfinite(number):
        raise InputError(f"{name} is {value}; it must be a finite number")
    return number


def positive(name: str, value: Any) -> float:
    number = finite(name, value)
    if not number > 0.0:
        raise InputError(f"{name} is {number:g}; it must be greater than zero")
    return number


def speed(name: str, value: Any) -> float:
    number = positive(name, value)
    if not SLOWEST_SPEED <= number <= FASTEST_SPEED:
        raise InputError(
            f"{name} is {number:g} mm/s; no machine moves like that, give one between {SLOWEST_SPEED:g} and {FASTEST_SPEED:g}"
        )
    return number


def choice(name: str, value: Any, kind: type[enum.Enum]) -> Any:
    """A member of an enum from itself or from its value."""
    try:
        return kind(value)
    except ValueError:
        words = [str(e.value) for e in kind]
        near = nearest_name(value, words) if isinstance(value, str) else None
        mend = f" (did you mean {near}?)" if near is not None else ""
        raise InputError(f"{name} is {value!r}; it must be one of {', '.join(words)}{mend}") from None


def layer_range(name: str, value: Any) -> tuple[int | None, int | None]:
    """The first layer and the one past the last, from a text "a:b" or from two numbers; either may be left out (None)."""
    try:
        first, last = (int(x) if x.strip() else None for x in value.split(":")) if isinstance(value, str) else value
    except (TypeError, ValueError):
        raise InputError(f"{name} is {value!r}; give 'a:b', as '0:3' for the first three") from None
    for number in (first, last):
        if number is not None and (whole(name, number) < 0):
            raise InputError(f"{name} is {value!r}; layers are counted from 0")
    if first is not None and last is not None and last <= first:
        raise InputError(f"{name} is {value!r}, which holds no layer; give a:b with a less than b, as 0:3 for the first three")
    return first, last


def whole(name: str, value: Any) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        raise InputError(f"{name} is {value!r}; it must be a whole number") from None
    if isinstance(value, bool):
        raise InputError(f"{name} is {value!r}; it must be a whole number")
    return number


def switch(name: str, value: Any) -> bool:
    if not isinstance(value, bool):
        raise InputError(f"{name} is {value!r}; it must be true or false (True or False in Python)")
    return value


def text(name: str, value: Any) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} is {value!r}; it must be a text")
    return value
