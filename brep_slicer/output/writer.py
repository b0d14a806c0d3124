"""The one interface of all that writes a plan into files.

In: a Plan and a folder. Out: the paths that were written.
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class Writer(abc.ABC):
    """What writes a plan in one form.

    It has a `name`, by which `--write` knows it, the `suffix` of what it writes, and a line of `help`; one that is `usual` is
    asked unless others are named. Writers in output/writers/ are found by their module's name, those of other packages by an
    entry point in `brep_slicer.writers`.
    """

    name: ClassVar[str]
    suffix: ClassVar[str]
    help: ClassVar[str]
    usual: ClassVar[bool] = False

    @abc.abstractmethod
    def write(self, plan: Plan, folder: Path) -> Path | Sequence[Path]:
        """Write into a folder that is there; the path of what was written, or paths.

        Raises
        ------
        InputError
            If it cannot be written, with what to do.
        """
