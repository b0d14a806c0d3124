"""Figures in a few words, the same in every line that a person reads.

In: counts, lengths, texts. Out: short texts.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def counted(number: int, noun: str) -> str:
    """A number with its noun: 1 layer, 2 layers."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def shortened(text: str, most: int = 60) -> str:
    """A text in one line of `most` characters, its middle left out where it has more."""
    line = " ".join(text.split())
    half = (most - 3) // 2
    return line if len(line) <= most else f"{line[:half]}...{line[-half:]}"


def in_words_of_length(mm: float) -> str:
    """A length in the unit of its size."""
    return f"{mm:.4g} mm" if mm < 1000.0 else f"{mm / 1000.0:.4g} m" if mm < 1e6 else f"{mm / 1e6:.4g} km"


def in_words_of_time(seconds: float) -> str:
    """In seconds up to two minutes, in minutes up to two hours, in hours beyond."""
    unit, size = ("s", 1.0) if seconds < 120.0 else ("min", 60.0) if seconds < 7200.0 else ("h", 3600.0)
    return f"{seconds / size:.4g} {unit}"


def nearest_name(name: str, known: Iterable[str]) -> str | None:
    """The one of the known names that a name is most likely meant to be, if any is near to it."""
    near = difflib.get_close_matches(name, list(known), n=1, cutoff=0.6)
    return near[0] if near else None


def mend_of_name(name: str, known: Iterable[str]) -> str:
    """What to write instead of a name that is not known."""
    known = list(known)
    near = nearest_name(name, known)
    return f"did you mean {near}?" if near is not None else f"known are {', '.join(known)}"
