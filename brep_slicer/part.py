"""What is to be planned: one solid or several, in millimetres, in the file's own frame.

In: a STEP file or a host object. Out: a frozen Part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from brep_slicer.errors import EmptySolidError, InputError
from brep_slicer.wording import counted, shortened

# So many solids are named in one line.
MOST_NAMED = 3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solid:
    """One solid: its index in the file, its name, the OCP solid (mm, location baked into the geometry).

    `known` keeps what has been found out about the solid and does not depend on an axis.
    """

    index: int
    name: str
    wrapped: Any
    known: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def __repr__(self) -> str:
        return f"Solid({self.index}: {shortened(self.name)!r})"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Part:
    """The solids to plan, where they came from, the unit they were in, and what was done to them on the way."""

    solids: tuple[Solid, ...]
    source: str
    unit: str
    notes: tuple[str, ...] = ()
    others: tuple[Solid, ...] = ()

    @property
    def wrapped(self) -> Any:
        """The OCP shape: the solid itself, or a compound of several."""
        if len(self.solids) == 1:
            return self.solids[0].wrapped
        from brep_slicer.kernel.shapes import compound

        return compound(solid.wrapped for solid in self.solids)

    def __repr__(self) -> str:
        names = ", ".join(solid.name for solid in self.solids)
        others = f"; {len(self.others)} not chosen" if self.others else ""
        return (
            f"Part({shortened(self.source)!r}: {counted(len(self.solids), 'solid')} ({shortened(names)}), {self.unit}{others})"
        )

    def select(self, solids: Sequence[str | int]) -> Part:
        """The part with only some of its solids, by name or by index.

        Raises
        ------
        InputError
            If there is no such solid; the message lists those there are.
        """
        if not len(solids):
            raise InputError(f"{self.source}: no solid was chosen; give names or indices, or none at all for every solid")
        chosen = []
        for key in solids:
            found = [s for s in self.solids if s.name == key or str(s.index) == str(key)]
            if not found:
                known = ", ".join(f"{s.index}: {s.name}" for s in self.solids)
                raise InputError(f"{self.source}: there is no solid {key!r}; choose by name or index from {known}")
            # named twice, it is still one solid
            if found[0] not in chosen:
                chosen.append(found[0])
        others = tuple(s for s in (*self.solids, *self.others) if s not in chosen)
        return replace(self, solids=tuple(chosen), others=others)


def read_step(path: str | Path, *, unit: str | None = None, solids: Sequence[str | int] | None = None) -> Part:
    """Read a STEP file: units to mm, assemblies with their locations baked, every solid checked.

    Parameters
    ----------
    path : path
        A STEP file.
    unit : str, optional
        Length unit to take instead of the header's: mm, cm, m, inch, ...
    solids : sequence of str or int, optional
        Names or indices of the solids to keep; all by default.

    Raises
    ------
    InputError
        If the file cannot be used: one line that names it, what is wrong and what to do.
    """
    from brep_slicer.kernel.read import solids_from_step

    if not isinstance(path, str | Path):
        raise InputError(f"a STEP file is named by a path, not by {type(path).__name__}; as_part takes shapes of a CAD host")
    pairs, used = solids_from_step(path, unit=unit)
    return _checked_part(pairs, source=str(path), unit=used, solids=solids)


def as_part(shape: Any, *, solids: Sequence[str | int] | None = None) -> Part:
    """Take a host object as a part, in millimetres; a Part is returned as it is.

    Parameters
    ----------
    shape
        build123d object or builder, CadQuery Workplane, Shape or Assembly, OCP TopoDS shape, BREP bytes, or the path of a
        STEP file.

    Raises
    ------
    InputError
        If it is none of these, or holds no solid, or an invalid one.
    """
    if isinstance(shape, Part):
        return shape if solids is None else shape.select(solids)
    if isinstance(shape, str | Path):
        return read_step(shape, solids=solids)
    from brep_slicer.kernel.coerce import solids_from_object

    return _checked_part(solids_from_object(shape), source=type(shape).__name__, unit="mm", solids=solids)


def _checked_part(pairs: list[tuple[str, Any]], *, source: str, unit: str, solids) -> Part:
    from brep_slicer.kernel.shapes import checked_solid

    part = Part(
        solids=tuple(Solid(index=i, name=name, wrapped=solid) for i, (name, solid) in enumerate(pairs)),
        source=source,
        unit=unit,
    )
    if solids is not None:
        part = part.select(solids)
    good: list[Solid] = []
    notes: list[str] = []
    empty: list[str] = []
    for solid in part.solids:
        try:
            wrapped, facets, said = checked_solid(solid.wrapped, solid.name)
        except EmptySolidError:
            empty.append(repr(solid.name))
            continue
        except InputError as error:
            raise InputError(f"{source}: {error}") from None
        good.append(replace(solid, wrapped=wrapped))
        good[-1].known["facets"] = facets
        notes.extend(said)
    if empty:
        named = f"solid {empty[0]} has" if len(empty) == 1 else f"{len(empty)} solids ({', '.join(empty[:MOST_NAMED])}"
        if len(empty) > 1:
            named += f"{', ...' if len(empty) > MOST_NAMED else ''}) have"
        reason = f"{named} no volume: the faces lie within their tolerance of each other"
        if not good:
            raise InputError(f"{source}: {reason}; repair the part in the CAD system, a union may have failed there")
        notes.append(f"{reason}; left out")
    return replace(part, solids=tuple(good), notes=tuple(notes))
