"""The substrate: the cylinder that is built on, chosen from the part's coaxial cylinders or given.

In: a part and its axis. Out: a Substrate with its radius, the solids that it consists of, and why it was chosen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.part import Part

from .axis import SAME_DIRECTION, SAME_PLACE, Axis

# Cylinders whose radii differ by less (mm) are one: several faces of one shaft in a file with rounded coordinates.
SAME_RADIUS = 1e-5
# There is metal beyond a cylinder when the part reaches farther out than this (mm), or this share of its radius if that is
# less: more than lands in files deviate from their cylinder.
BEYOND, BEYOND_SHARE = 1e-2, 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class CylinderCandidate:
    """A coaxial cylinder of the part: its `radius` (mm), total `area` (mm**2), whether it is `external`, whose it is."""

    radius: float
    area: float
    external: bool
    solids: tuple[int, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Substrate:
    """What is built on: `radius` (mm), the indices of the solids that stand already, the `reason` in words, warnings."""

    radius: float
    solids: tuple[int, ...]
    reason: str
    warnings: tuple[str, ...] = ()


def beyond(radius: float) -> float:
    """How far past `radius` (mm) there has to be metal before it counts, mm."""
    return min(BEYOND, BEYOND_SHARE * radius)


def coaxial_cylinders(part: Part, axis: Axis) -> list[CylinderCandidate]:
    """The part's cylinders about `axis`, the largest radius first; faces of one cylinder are counted together."""
    from brep_slicer.kernel.revolutes import axis_votes

    found: list[list] = []
    for solid in part.solids:
        for vote in axis_votes(solid.wrapped):
            if vote.radius is None or not _is_coaxial(vote, axis):
                continue
            home = next((f for f in found if abs(f[0] - vote.radius) <= SAME_RADIUS and f[2] == (vote.outward > 0)), None)
            if home is None:
                found.append([vote.radius, vote.area, vote.outward > 0, {solid.index}])
            else:
                home[1] += vote.area
                home[3].add(solid.index)
    made = [CylinderCandidate(radius=f[0], area=f[1], external=f[2], solids=tuple(sorted(f[3]))) for f in found]
    return sorted(made, key=lambda c: -c.radius)


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
    """The cylinder to build on.

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
    candidates = coaxial_cylinders(part, axis)
    if radius is not None:
        if not (np.isfinite(radius) and radius > 0.0):
            raise InputError(f"the substrate radius is {radius:g} mm; it must be greater than zero")
        if radius >= highest - beyond(radius):
            raise InputError(
                f"{part.source}: the substrate radius {radius:g} mm leaves nothing to build: the part ends at"
                f" {highest:.6g} mm; give a smaller one (building inwards is not planned)"
            )
        return Substrate(radius=radius, solids=_standing(part, candidates, radius, reach, solids), reason="given")
    external = [c for c in candidates if c.external and highest > c.radius + beyond(c.radius)]
    if external:
        chosen = external[0]
        reason = f"largest external coaxial cylinder with metal beyond it ({_listed(candidates)})"
        return Substrate(radius=chosen.radius, solids=_standing(part, candidates, chosen.radius, reach, solids), reason=reason)
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
