"""What a parameter is, said once where it stands: its unit, its range, a line of help, what it is at the command.

In: declarations in the fields of dataclasses. Out: values that are checked; what the command's options, process files, their
schema and the reference page are made from.

Words: *declaration*, all that is to be known of a parameter; *assumed*, what a parameter is where nothing is given.
"""

from __future__ import annotations

import enum
from collections.abc import Callable, Iterable, Mapping
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass
from typing import Any

from brep_slicer.errors import InputError
from brep_slicer.wording import nearest_name, shortened

from .values import choice, finite, listed, speed, switch, text, whole

KEY = "brep_slicer"
# What the name of a parameter ends in for its unit; the command's options are named without it.
UNIT_ENDINGS = {"deg": "_deg", "mm/s": "_mm_s", "s": "_s", "W": "_w", "g/s": "_g_s", "g/cm3": "_g_cm3"}
PLAIN_KINDS = {float: "number", int: "whole number", bool: "true or false", str: "text"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Declaration:
    """A parameter: its `help`, `unit`, `kind` (a type, or a name of one that another module checks), and its range.

    `many` values may be given instead of one; None may be given if it is `optional`: what is `assumed` then is said in words,
    and an `example` shows what might be given. `options` are its names at the command, if they are not made of its own; a rule
    may change it if it goes `by_piece`.
    """

    help: str
    unit: str = ""
    kind: type | str = float
    many: bool = False
    optional: bool = False
    least: float | None = None
    above: float | None = None
    most: float | None = None
    below: float | None = None
    assumed: str = ""
    example: Any = None
    options: tuple[str, ...] = ()
    by_piece: bool = False
    check: Callable[[str, Any], Any] | None = None

    def checked(self, name: str, value: Any) -> Any:
        """A value as it is held: numbers as floats, several as a tuple, choices as members of their enum.

        Raises
        ------
        InputError
            If it cannot be used; the message names it.
        """
        if value is None and self.optional:
            return None
        if self.check is not None:
            return self.check(name, value)
        return tuple(self._one(name, v) for v in listed(name, value)) if self.many else self._one(name, value)

    def _one(self, name: str, value: Any) -> Any:
        if isinstance(self.kind, type) and issubclass(self.kind, enum.Enum):
            return choice(name, value, self.kind)
        if self.kind in (bool, str):
            return switch(name, value) if self.kind is bool else text(name, value)
        if self.unit == "mm/s":
            return speed(name, value)
        number = whole(name, value) if self.kind is int else finite(name, value)
        low, high = self.least, self.most
        if (low is not None and number < low) or (self.above is not None and number <= self.above):
            raise InputError(f"{name} is {number:g}; it must be {self.range_in_words()}")
        if (high is not None and number > high) or (self.below is not None and number >= self.below):
            raise InputError(f"{name} is {number:g}; it must be {self.range_in_words()}")
        return number

    def range_in_words(self) -> str:
        """What values it may have: "greater than zero", "0 or more", "one of in, on, out"."""
        if isinstance(self.kind, type) and issubclass(self.kind, enum.Enum):
            return f"one of {', '.join(self.choices())}"
        low = (
            "zero"
            if 0.0 in (self.least, self.above)
            else f"{self.least if self.above is None else self.above:g}"
            if (self.least is not None or self.above is not None)
            else ""
        )
        words = [f"greater than {low}" if self.above is not None else f"{low} or more"] if low else []
        if self.most is not None:
            words.append(f"{self.most:g} at most")
        if self.below is not None:
            words.append(f"less than {self.below:g}")
        return " and ".join(words)

    def choices(self) -> list[str]:
        """The words of a choice; none if it is not one."""
        if isinstance(self.kind, type) and issubclass(self.kind, enum.Enum):
            return [str(member.value) for member in self.kind]
        return []

    def in_words(self, default: Any) -> str:
        """Unit, range and what it is where nothing is given, in brackets behind its help."""
        parts = [self.unit, self.range_in_words()]
        if self.assumed:
            parts.append(f"default {self.assumed}")
        elif default is not MISSING and default is not None:
            parts.append(f"default {in_words(default)}")
        return ", ".join(part for part in parts if part)


def in_words(value: Any) -> str:
    """A parameter's value as a person reads it."""
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, enum.Enum):
        return str(value.value)
    if isinstance(value, tuple):
        return ", ".join(map(in_words, value))
    return f"{value:g}" if isinstance(value, float) else str(value)


def declared(**words: Any) -> dict[str, Any]:
    """A field's metadata, for a parameter that has to be given: `field(metadata=declared(help=..., unit="mm", above=0.0))`."""
    return {KEY: Declaration(**words)}


def parameter(
    default: Any,
    *,
    help: str,
    unit: str = "",
    kind: type | str | None = None,
    many: bool = False,
    least: float | None = None,
    above: float | None = None,
    most: float | None = None,
    below: float | None = None,
    assumed: str = "",
    example: Any = None,
    options: tuple[str, ...] = (),
    by_piece: bool = False,
    check: Callable[[str, Any], Any] | None = None,
) -> Any:
    """A field of a frozen dataclass that is a parameter, with all that is to be known of it.

    Parameters
    ----------
    default
        Its value where none is given; None: something is `assumed`.
    help : str
        A line that says what it does.
    unit : str
        "mm", "deg", "mm/s", ...; empty for a count or a share.
    kind : type, optional
        float, int, bool, str or an Enum; by the default if not given.
    many : bool
        Whether several values may be given; it is read as a tuple then.
    least, above, most, below : float, optional
        Its range: ends that it may have, and ends that it may not have.
    assumed : str
        What a default of None stands for, in words.
    example : optional
        A value to show where there is no default.
    options : tuple of str
        Its names at the command; by its own name if empty.
    by_piece : bool
        Whether a rule may change it for some layers and pieces.
    check : callable, optional
        Given its name and a value, the value as it is held, or an InputError.
    """
    first = default[0] if isinstance(default, tuple) and default else default
    kind = kind if kind is not None else float if first is None else type(first)
    limits = {"least": least, "above": above, "most": most, "below": below}
    words = declared(
        help=help,
        unit=unit,
        kind=kind,
        many=many,
        optional=default is None,
        assumed=assumed,
        example=example,
        options=options,
        by_piece=by_piece,
        check=check,
        **limits,
    )
    return field(default=default, metadata=words)


def declaration_of(one: Field[Any]) -> Declaration | None:
    """What a field declares; None for one that is no parameter."""
    return one.metadata.get(KEY)


def declarations_of(owner: type | Declared) -> dict[str, Declaration]:
    """The parameters of a dataclass, or of a value of one, by their names."""
    found = {one.name: declaration_of(one) for one in fields(owner)} if is_dataclass(owner) else {}
    return {name: one for name, one in found.items() if one is not None}


def option_names(name: str, one: Declaration) -> tuple[str, ...]:
    """What a parameter is called at the command: by its own name without the unit's, unless it says otherwise."""
    if one.options:
        return one.options
    plain = name.removesuffix(UNIT_ENDINGS.get(one.unit, "")).replace("_", "-")
    return (f"--{plain}/--no-{plain}",) if one.kind is bool else (f"--{plain}",)


def defaults_of(owner: type | Declared) -> dict[str, Any]:
    """The parameters' own defaults, by their names."""
    return {one.name: one.default for one in fields(owner) if declaration_of(one) is not None} if is_dataclass(owner) else {}


def check_names(given: Iterable[str], known: Iterable[str], what: str, elsewhere: Mapping[str, str] | None = None) -> None:
    """Refuse the first name that is none of `known`: with where it stands, or with the one that is nearest to it."""
    known = list(known)
    wrong = next((name for name in given if name not in known), None)
    if wrong is None:
        return
    if elsewhere and wrong in elsewhere:
        raise InputError(f"{wrong} is no {what}; {elsewhere[wrong]}")
    # an angle without its unit is not a slip of the pen: the number is likely meant in radians
    in_degrees = [name for name in (f"{wrong}_deg", f"{wrong.removesuffix('s')}_deg") if name in known]
    if in_degrees:
        raise InputError(f"{wrong} is no {what}; did you mean {in_degrees[0]} (in degrees)?")
    near = nearest_name(wrong, known)
    if near is None and elsewhere:
        other = nearest_name(wrong, elsewhere)
        if other is not None:
            raise InputError(f"{wrong} is no {what}; did you mean {other}? {elsewhere[other]}")
    mend = f"did you mean {near}?" if near is not None else f"known are {', '.join(sorted(known))}"
    raise InputError(f"{wrong} is no {what}; {mend}")


class Declared:
    """Base of frozen dataclasses whose fields are parameters: they are checked when a value is made.

    A subclass that checks more in `__post_init__` of its own calls `Declared.__post_init__(self)` first.
    """

    __slots__ = ()

    def __new__(cls, *args: Any, **given: Any) -> Any:
        """Names that no parameter has are told of with the nearest that one has."""
        if "__dataclass_fields__" in vars(cls):
            check_names(given, [one.name for one in fields(cls)], f"parameter of {cls._in_words()}", cls._elsewhere(given))  # type: ignore[arg-type]
        return object.__new__(cls)

    @classmethod
    def _in_words(cls) -> str:
        return cls.__name__

    @classmethod
    def _elsewhere(cls, given: Iterable[str]) -> Mapping[str, str] | None:
        """Where names stand that are none of this one's."""
        return None

    def __post_init__(self) -> None:
        for name, one in declarations_of(self).items():
            object.__setattr__(self, name, one.checked(name, getattr(self, name)))

    def __repr__(self) -> str:
        usual = {one.name: one.default for one in fields(self)}  # type: ignore[arg-type]
        given = [f"{name}={_plain(getattr(self, name))}" for name in usual if _differs(getattr(self, name), usual[name])]
        return f"{type(self).__name__}({shortened(', '.join(given), 180)})"

    def as_dict(self) -> dict[str, Any]:
        """Plain values, as they stand in a process file."""
        return {name: as_written(getattr(self, name)) for name in declarations_of(self)}


def as_written(value: Any) -> Any:
    """A value as it stands in a process file: words for choices, lists for tuples, tables for what has parameters itself."""
    if isinstance(value, Declared):
        return value.as_dict()
    if isinstance(value, enum.Enum):
        return value.value
    return [as_written(v) for v in value] if isinstance(value, tuple) else value


def _plain(value: Any) -> str:
    if isinstance(value, Declared):
        return repr(value)
    if isinstance(value, bool):
        return repr(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(_plain, value))}{',' if len(value) == 1 else ''})"
    return repr(as_written(value)) if not isinstance(value, float) else repr(value)


def _differs(value: Any, usual: Any) -> bool:
    return type(value) is not type(usual) or value != usual
