"""What can go wrong, each with the exit code that the command returns for it.

In: nothing. Out: one exception class per exit code (2 bad input, 3 cannot be planned, 4 a layer failed). A message
is one line that says what is wrong and what to do about it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


class BrepSlicerError(Exception):
    """Base of every error that this library raises on purpose."""

    exit_code: int = 2


class InputError(BrepSlicerError, ValueError):
    """A file, a shape or a value that cannot be used (exit code 2)."""

    exit_code = 2


class EmptySolidError(InputError):
    """A solid without volume (exit code 2, if there is no other)."""


class PlanningError(BrepSlicerError):
    """A sound part that cannot be planned: no axis, several axes, no layer (exit code 3)."""

    exit_code = 3


class LayerError(BrepSlicerError):
    """Some layer could not be cut with certainty (exit code 4); the layers of a plan that failed are its `failed`."""

    exit_code = 4

    def __init__(self, *words: object, failed: Sequence[Any] = ()) -> None:
        super().__init__(*words)
        self.failed = tuple(failed)


class KernelError(BrepSlicerError):
    """The CAD kernel is missing, or its shared libraries cannot be loaded (exit code 2)."""

    exit_code = 2
