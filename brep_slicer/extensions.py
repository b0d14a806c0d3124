"""What is found by being there: modules of one folder of this package, and entry points of packages that are installed.

In: a folder and the name of an entry-point group. Out: the names that there are, and the class of one.

A module in the folder holds one class, and both have the same name; an entry point's name is that of its class. Names are read
without loading anything; entry points are looked for only where a name is none of our own, or where all are to be listed.
"""

from __future__ import annotations

import functools
import importlib
import pkgutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .errors import InputError
from .wording import mend_of_name

HERE = Path(__file__).resolve().parent


@dataclass(frozen=True, slots=True, kw_only=True)
class Extensions:
    """All of one `kind` (in words, "pattern"): the modules of a `folder` of this package, and the entry points of a `group`.

    `base` is what each is a subclass of, as "module:class".
    """

    kind: str
    folder: str
    group: str
    base: str

    def own(self) -> tuple[str, ...]:
        """The names of the modules in the folder."""
        return _modules_in(self.folder)

    def names(self) -> tuple[str, ...]:
        """All names: our own, then those of other packages."""
        others = sorted({point.name for point in _entry_points(self.group)} - {*self.own()})
        return (*self.own(), *others)

    def load(self, name: str) -> Any:
        """The class of a name; a name of our own is always ours.

        Raises
        ------
        InputError
            If there is none, or its package cannot be used.
        """
        if name in self.own():
            return self._own_class(name)
        points = [point for point in _entry_points(self.group) if point.name == name]
        packages = sorted({point.dist.name if point.dist else "?" for point in points})
        if len(packages) > 1:
            raise InputError(f"{self.kind} {name!r} is in several packages, {', '.join(packages)}; remove all but one")
        if not points:
            raise InputError(f"{name!r} is no {self.kind}; {mend_of_name(name, self.names())}")
        try:
            found = points[0].load()
        except Exception as error:
            why = " ".join(f"{type(error).__name__}: {error}".split())
            raise InputError(f"{self.kind} {name!r} of package {packages[0]} cannot be loaded ({why}); mend it") from None
        module, base = self.base.split(":")
        if not (isinstance(found, type) and issubclass(found, getattr(importlib.import_module(module), base))):
            raise InputError(f"{self.kind} {name!r} of package {packages[0]} is no subclass of brep_slicer.{base}; mend it")
        called = vars(found).get("name")
        if called != name:
            raise InputError(f"{self.kind} {name!r} of package {packages[0]} calls itself {called!r}; give both the same name")
        return found

    def all(self) -> dict[str, Any]:
        """Every class by its name."""
        return {name: self.load(name) for name in self.names()}

    def _own_class(self, name: str) -> Any:
        module = importlib.import_module(f"{__package__}.{self.folder.replace('/', '.')}.{name}")
        return next(x for x in vars(module).values() if isinstance(x, type) and vars(x).get("name") == name)


@functools.cache
def _modules_in(folder: str) -> tuple[str, ...]:
    return tuple(sorted(found.name for found in pkgutil.iter_modules([str(HERE / folder)])))


def _entry_points(group: str) -> list[Any]:
    # some hundredths of a second, with all that it reads
    from importlib.metadata import entry_points

    return list(entry_points(group=group))
