"""What each solid is: to be built, standing, or left alone.

In: the Ground that is built on, what a user has said. Out: Roles.

By how the solids touch: one that lies inside of the radius stands; so does one that owns the land if another solid lies on it
and what it has beyond the radius itself is turned (a worn shaft with its collars, and the ring that is laid on its journal).
An owner that nothing lies on stands up to the radius only: what it has beyond is built (a gear on its axle, in one solid).
What touches a solid that is built or stands, outside of the radius, is built as well; what touches none is left alone.

Of a solid that is built from the radius on, metal that goes all the way round through the radius stands where land is on one
side of it at most, if it is turned (a collar, a flange), as long as something else is built: it is there for turning, not for
building. Its limits: a gear at a shaft's end is not turned and is built; a collar between two lands is built; a collar whose
neighbour on the radius is itself to be built, with no land between them, cannot be told from it and is built.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.maps import Array
from brep_slicer.part import Part, Solid

from .ground import LOOSE_SHARE, Ground
from .lands import beyond

# Of two readings, one counts for nothing if its metal is less than this share of the other's.
NOTHING = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Roles:
    """Indices of the solids that are `built`, that `stand`, that are left `alone`; `zones`, heights (low, high) in the axis
    frame, mm, in which the built solids' own metal stands beyond the radius."""

    built: tuple[int, ...]
    stand: tuple[int, ...]
    alone: tuple[int, ...]
    zones: tuple[tuple[float, float], ...] = ()


def places_named(part: Part, keys: Sequence[str | int] | None, option: str) -> frozenset[int]:
    """The places of solids named or numbered by a user.

    Raises
    ------
    InputError
        If there is no such solid.
    """
    out = set()
    for key in [keys] if isinstance(keys, str | int) else keys or ():
        found = [i for i, s in enumerate(part.solids) if s.name == key or str(s.index) == str(key)]
        if not found:
            known = ", ".join(f"{s.index}: {s.name}" for s in part.solids[:8]) + (", ..." if len(part.solids) > 8 else "")
            raise InputError(f"{part.source}: {option} names {key!r}, but there is no such solid; there are {known}")
        out.add(found[0])
    return frozenset(out)


def roles_of(part: Part, ground: Ground, reach: Array, *, build: frozenset[int], stands: frozenset[int]) -> Roles:
    """The role of every solid; `reach` (solids,) is how far out each goes, mm, `build` and `stands` are what a user says.

    Raises
    ------
    InputError
        If a solid is to be built and to stand.
    PlanningError
        If two readings are about as likely.
    """
    both = build & stands
    if both:
        raise InputError(f"{part.source}: {_name(part.solids[min(both)])} is named by --build and by --stands; choose one")
    count = len(part.solids)
    radius = ground.radius
    outside = {i for i in range(count) if reach[i] > radius + beyond(radius)}
    owners = {place for place, _ in ground.faces} if ground.external else set()
    standing = (set(range(count)) - outside) | set(stands)
    for owner in sorted((owners & outside) - build - stands):
        if _stands_wholly(part, ground, owner, stands, build):
            standing.add(owner)
    built = (outside & (owners | build)) - standing
    reached = _touched(ground.survey.touching, built | standing | owners)
    built |= (outside & reached) - standing
    if not built - owners and not any(_own_volume(ground, i) > 0.0 for i in built):
        built = outside - standing
    alone = outside - built - standing
    zones = () if build else _zones(ground, built)
    indices = [tuple(part.solids[i].index for i in sorted(group)) for group in (built, standing, alone)]
    return Roles(built=indices[0], stand=indices[1], alone=indices[2], zones=zones)


def _name(solid: Solid) -> str:
    return f"solid {solid.index} ({solid.name})"


def _own_volume(ground: Ground, place: int) -> float:
    return ground.volume(ground.above & (ground.survey.stretches.solid == place))


def _touched(touching: Array, start: set[int]) -> set[int]:
    """The places of all solids that are connected to the first ones by touching."""
    known, open_ = set(start), list(start)
    while open_:
        for other in np.flatnonzero(touching[open_.pop()]).tolist():
            if other not in known:
                known.add(other)
                open_.append(other)
    return known


def _stands_wholly(part: Part, ground: Ground, owner: int, stands: frozenset[int], build: frozenset[int]) -> bool:
    """Whether an owner of the land with metal of its own beyond it stands, since another solid is laid on the land.

    Raises
    ------
    PlanningError
        If what it has beyond is no turned body, and neither reading has next to no metal.
    """
    s = ground.survey.stretches
    under = np.full(len(ground.survey.weights), -1)
    under[s.ray[ground.on_land]] = s.solid[ground.on_land]
    layers = ground.covers & (under[s.ray] == owner) & ~np.isin(s.solid, list(stands))
    laid, own = ground.volume(layers), ground.above & (s.solid == owner)
    if laid <= 0.0:
        return False
    # webs of a crankshaft on either side of its pin: no turned metal, but none that stands on the land as a feature does
    station = s.ray // ground.survey.shape[1]
    for first, last in ground.shoulders([owner], turned=False):
        own &= ~ground.reached(own & ground.through & (station >= first) & (station < last))
    whole = ground.volume(own)
    loose = float(ground.survey.loose_volumes(s.chosen(own), inner=ground.radius).sum())
    if loose <= max(LOOSE_SHARE * whole, NOTHING * laid):
        return True
    if laid <= NOTHING * whole or build & set(np.unique(s.solid[layers]).tolist()):
        return bool(laid > NOTHING * whole)
    others = ", ".join(_name(part.solids[i]) for i in np.unique(s.solid[layers]).tolist())
    this = part.solids[owner]
    raise PlanningError(
        f"{part.source}: on R {ground.radius:.6g} mm either {others} alone, {laid:.4g} mm3, is to be built on {_name(this)}, or"
        f" what that has itself beyond the radius, {whole:.4g} mm3, as well; say which with --stands {this.index} or"
        f" --build {this.index} (stands=, build=)"
    )


def _zones(ground: Ground, built: set[int]) -> tuple[tuple[float, float], ...]:
    """Heights (mm) of shoulders, if anything else is built; up to the next foot that is none, since collars may overhang."""
    shoulders = ground.shoulders(built)
    if not ground.external or not shoulders:
        return ()
    s, edges = ground.survey.stretches, ground.survey.edges
    number, beside = ground.feet
    station = s.ray // ground.survey.shape[1]
    in_shoulder = np.zeros(len(edges) - 1, dtype=bool)
    for first, last in shoulders:
        in_shoulder[first:last] = True
    rest = ((number > 0) & beside[number]).any(axis=1) & ~in_shoulder
    others = ground.covers.any() or rest.any()
    if not others:
        return ()
    taken = rest.copy()
    taken[station[ground.covers]] = True
    out = []
    for first, last in shoulders:
        pieces = np.unique(ground.pieces[ground.through & (station >= first) & (station < last)])
        rows = station[np.isin(ground.pieces, pieces[pieces >= 0])]
        low, high = int(rows.min()), int(rows.max()) + 1
        while low < first and taken[low:first].any():
            low += 1
        while high > last and taken[last:high].any():
            high -= 1
        out.append((float(edges[low]), float(edges[high])))
    return tuple(out)


def said(part: Part, roles: Roles, radius: float) -> str:
    """The roles in one line."""
    names: dict[int, Any] = {s.index: s for s in part.solids}

    def listed(indices: Sequence[int]) -> str:
        shown = ", ".join(f"{i} ({names[i].name})" for i in indices[:4])
        return shown + (f" and {len(indices) - 4} more" if len(indices) > 4 else "")

    words = [f"built beyond R {radius:.6g}: {listed(roles.built) or 'nothing'}"]
    if roles.stand:
        words.append(f"stands: {listed(roles.stand)}")
    if roles.zones:
        heights = ", ".join(f"{a:.6g} to {b:.6g}" for a, b in roles.zones)
        words.append(f"collars that stand, at z {heights} mm")
    words.append(f"left alone: {listed(roles.alone)}" if roles.alone else "nothing left alone")
    return "; ".join(words)
