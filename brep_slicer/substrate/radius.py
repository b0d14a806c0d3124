"""The substrate: the cylinder that is built on, chosen from the part's coaxial cylinders or given.

In: a part and its axis. Out: a Substrate with its radius, the solids that it consists of, and why it was chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.part import Part, as_part
from brep_slicer.wording import shortened

from .axis import SAME_DIRECTION, SAME_PLACE, Axis, as_axis

# Cylinders whose radii differ by less (mm) are one: several faces of one shaft in a file with rounded coordinates.
SAME_RADIUS = 1e-5
# There is metal beyond a cylinder when the part reaches farther out than this (mm), or this share of its radius if that is
# less: more than lands in files deviate from their cylinder.
BEYOND, BEYOND_SHARE = 1e-2, 1e-3

# A substrate of less than this share of the part's radius has no arc lengths to speak of, and no floating point to hold them.
LEAST_SHARE = 1e-6
# A land covers the whole turn when its faces do to this (rad).
WHOLE_TURN = 2.0 * np.pi - 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderCandidate:
    """A coaxial cylinder of the part: its `radius` (mm), total `area` (mm**2), whether it is `external`, whose it is."""

    radius: float
    area: float
    external: bool
    solids: tuple[int, ...]

    def __repr__(self) -> str:
        side = "outside" if self.external else "bore"
        return (
            f"CylinderCandidate(R {self.radius:.6g} mm {side}, {self.area:.6g} mm2, solids {shortened(str(list(self.solids)))})"
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Substrate:
    """What is built on: `radius` (mm), the indices of the solids that stand already, the `reason` in words, warnings."""

    radius: float
    solids: tuple[int, ...]
    reason: str
    warnings: tuple[str, ...] = ()

    def __repr__(self) -> str:
        stand = f", solids {list(self.solids)} stand" if self.solids else ""
        return f"Substrate(R {self.radius:.6g} mm: {shortened(self.reason, 100)}{stand})"


def beyond(radius: float) -> float:
    """How far past `radius` (mm) there has to be metal before it counts, mm."""
    return min(BEYOND, BEYOND_SHARE * radius)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Land:
    """A candidate with its faces, {solid: numbers of faces}, and the angle (rad) that they cover together."""

    candidate: CylinderCandidate
    faces: dict[int, list[int]]
    turn: float


def coaxial_cylinders(part: Any, axis: Any = None) -> list[CylinderCandidate]:
    """The part's cylinders about `axis`, the largest radius first; faces of one cylinder are counted together.

    Parameters
    ----------
    part
        A Part, or anything that `as_part` takes.
    axis
        As `as_axis` takes it; found by a vote of the faces if not given.
    """
    part = as_part(part)
    return [land.candidate for land in _lands(part, as_axis(axis, part))]


def _lands(part: Part, axis: Axis) -> list[_Land]:
    from brep_slicer.kernel.revolutes import axis_votes

    found: list[list[tuple]] = []
    for solid in part.solids:
        for vote in axis_votes(solid.wrapped):
            if vote.radius is None or not _is_coaxial(vote, axis):
                continue
            home = next((f for f in found if _same_cylinder(f[0][1], vote)), None)
            found.append([(solid.index, vote)]) if home is None else home.append((solid.index, vote))
    return sorted((_land(votes) for votes in found), key=lambda land: -land.candidate.radius)


def _same_cylinder(a, b) -> bool:
    return abs(a.radius - b.radius) <= SAME_RADIUS and (a.outward > 0) == (b.outward > 0)


def _land(votes: list[tuple]) -> _Land:
    first = votes[0][1]
    faces: dict[int, list[int]] = {}
    for index, vote in votes:
        faces.setdefault(index, []).append(vote.face)
    candidate = CylinderCandidate(
        radius=first.radius,
        area=sum(vote.area for _, vote in votes),
        external=first.outward > 0,
        solids=tuple(sorted(faces)),
    )
    return _Land(candidate=candidate, faces=faces, turn=sum(vote.turn for _, vote in votes))


def _is_coaxial(vote, axis: Axis) -> bool:
    if float(np.linalg.norm(np.cross(vote.direction, axis.direction))) > SAME_DIRECTION:
        return False
    distance = float(np.linalg.norm(np.cross(axis.direction, vote.point - axis.origin)))
    return distance <= max(SAME_PLACE * vote.radius, 1e-6)


def find_substrate(
    part: Part,
    axis: Axis,
    *,
    reach: dict[int, float],
    radius: float | None = None,
    solids: Sequence[int] | None = None,
) -> Substrate:
    """The cylinder to build on: by default the largest external coaxial one that metal stands on.

    Metal stands on a cylinder where another face rises from an edge of its faces (or of a relief groove in them), or where
    another solid that reaches farther out touches them; metal beyond its radius elsewhere on the part does not count.

    Parameters
    ----------
    part, axis
        The part and its axis.
    reach : dict
        Outermost radius (mm) of each solid, by its index.
    radius : float, optional
        The substrate's radius if it is known.
    solids : sequence of int, optional
        Indices of the solids that stand already; by default those that own the substrate's cylinder while others reach
        beyond it.

    Raises
    ------
    InputError
        If `radius` is no radius of this part.
    PlanningError
        If the part has no cylinder to build on.
    """
    highest = max(reach.values())
    lands = _lands(part, axis)
    candidates = [land.candidate for land in lands]
    if radius is not None:
        _check_given(part, radius, highest)
        return Substrate(radius=radius, solids=_standing(part, candidates, radius, reach, solids), reason="given")
    external = [
        land for land in lands if land.candidate.external and highest > land.candidate.radius + beyond(land.candidate.radius)
    ]
    if external:
        land, rule, warnings = _chosen_land(part, axis, external, reach)
        return Substrate(
            radius=land.candidate.radius,
            solids=_standing(part, candidates, land.candidate.radius, reach, solids),
            reason=f"{rule} ({_listed(candidates)})",
            warnings=warnings,
        )
    bores = [c for c in candidates if not c.external and highest > c.radius + beyond(c.radius)]
    if bores:
        warning = (
            f"no shaft surface belongs to the part: it is taken to sit on a shaft that fills its bore, R {bores[0].radius:g}"
        )
        return Substrate(
            radius=bores[0].radius,
            solids=_standing(part, candidates, bores[0].radius, reach, solids),
            reason=f"largest coaxial bore ({_listed(candidates)})",
            warnings=(warning,),
        )
    raise PlanningError(
        f"{part.source}: there is no coaxial cylinder with metal beyond it to build on"
        f" ({_listed(candidates)}; the part ends at {highest:.6g} mm); give one with --substrate RADIUS"
    )


def _check_given(part: Part, radius: float, highest: float) -> None:
    if not (np.isfinite(radius) and radius > 0.0):
        raise InputError(f"the substrate radius is {radius:g} mm; it must be greater than zero")
    if radius < LEAST_SHARE * highest:
        raise InputError(
            f"{part.source}: the substrate radius {radius:g} mm is too small to build on: the part ends at {highest:.6g} mm;"
            " give a larger one"
        )
    if radius >= highest - beyond(radius):
        raise InputError(
            f"{part.source}: the substrate radius {radius:g} mm leaves nothing to build: the part ends at"
            f" {highest:.6g} mm; give a smaller one (building inwards is not planned)"
        )


def _chosen_land(part: Part, axis: Axis, lands: list[_Land], reach: dict[int, float]) -> tuple[_Land, str, tuple[str, ...]]:
    """The largest land that metal stands on, the rule in words, and what is doubtful about it."""
    from brep_slicer.kernel.standing import Lands

    solids = {s.index: Lands(s.wrapped, axis.origin, axis.direction) for s in part.solids}
    stood_on = (land for land in lands if _stood_on(land, solids, reach))
    land = next(stood_on, None)
    if land is None:
        first = lands[0].candidate.radius
        doubt = f"no metal is seen to stand on R {first:.6g} itself, only beyond it; give another with --substrate RADIUS"
        return lands[0], "largest external coaxial cylinder with metal beyond it", (doubt,)
    rule = "largest external coaxial cylinder that metal stands on"
    radius, area = land.candidate.radius, land.candidate.area
    if land.turn > WHOLE_TURN:
        return land, rule, ()
    # the flat top of a lug, say, that a pin stands on, above the shaft that all the rest stands on
    other = next((o.candidate for o in stood_on if o.candidate.area > area), None)
    if other is None:
        return land, rule, ()
    doubt = (
        f"the substrate R {radius:.6g} ({area:.4g} mm2) does not go all the way round; metal stands on R {other.radius:.6g}"
        f" ({other.area:.4g} mm2) as well: is it --substrate {other.radius:.6g}?"
    )
    return land, rule, (doubt,)


def _stood_on(land: _Land, solids: dict, reach: dict[int, float]) -> bool:
    """Whether metal rises from the land's own edges, or another solid that reaches farther out touches it."""
    radius = land.candidate.radius
    margin = beyond(radius)
    if any(solids[i].stood_on(faces, radius, margin) for i, faces in land.faces.items()):
        return True
    return any(
        solids[i].touched_by(faces, other.solid, margin)
        for i, faces in land.faces.items()
        for j, other in solids.items()
        if j != i and reach[j] > radius + margin
    )


def _standing(part: Part, candidates, radius: float, reach: dict[int, float], solids) -> tuple[int, ...]:
    if solids is not None:
        known = {s.index for s in part.solids}
        unknown = [i for i in solids if i not in known]
        if unknown:
            raise InputError(f"{part.source}: there is no solid {unknown[0]} to be the substrate; there are {sorted(known)}")
        return tuple(solids)
    if len(part.solids) == 1:
        return ()
    inside = {i for i, r in reach.items() if r <= radius + beyond(radius)}
    owners = {i for c in candidates if c.external and abs(c.radius - radius) <= SAME_RADIUS for i in c.solids}
    others = {i for i, r in reach.items() if r > radius + beyond(radius)} - owners
    return tuple(sorted(inside | owners if others else inside))


def _listed(candidates: list[CylinderCandidate]) -> str:
    if not candidates:
        return "coaxial cylinders: none"
    words = [f"R {c.radius:.6g} {'outside' if c.external else 'bore'}" for c in candidates[:8]]
    return "coaxial cylinders: " + ", ".join(words) + (", ..." if len(candidates) > 8 else "")
