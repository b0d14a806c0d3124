"""Fields that take more than they hold.

In: nothing. Out: how type checkers see a field that is given as a text, say, and read as a member of an enum.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Generic, TypeVar

Held = TypeVar("Held", covariant=True)
Given = TypeVar("Given", contravariant=True)


class Taken(Generic[Held, Given]):
    """A field that is read as `Held` and may be given as `Given`; to type checkers alone a descriptor."""

    if TYPE_CHECKING:

        def __get__(self, instance: object, owner: Any = None) -> Held: ...

        def __set__(self, instance: object, value: Given) -> None: ...


def default(value: object) -> Any:
    """The default of a `Taken` field."""
    return value
