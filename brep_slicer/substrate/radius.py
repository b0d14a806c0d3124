"""The substrate: the cylinder that is built on, chosen from the part's coaxial cylinders or given; and what is built on it.

In: a part and its axis. Out: a Substrate with its radius, the role of every solid, why, and what is left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.maps import Array
from brep_slicer.part import Part
from brep_slicer.wording import shortened

from .axis import Axis
from .choice import TOLD, Choice, chosen_ground
from .doubts import doubles_of, doubts_of
from .ground import Ground, flagged
from .lands import SAME_RADIUS, CylinderCandidate, Land, beyond, coaxial_cylinders, lands_of, levels_of, listed
from .roles import Roles, places_named, roles_of, said
from .survey import Survey, survey_of

__all__ = ["CylinderCandidate", "Substrate", "coaxial_cylinders", "find_substrate"]

# Collars that hold more than this share of what is to be built stand only on a radius that was asked for.
MOST_IN_ZONES = 0.5
# So many collars, solids or steps are named in one line.
MOST_NAMED = 3
# A substrate of less than this share of the part's radius has no arc lengths to speak of, and no floating point to hold them.
LEAST_SHARE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Substrate:
    """What is built on: `radius` (mm) and the `reason` in words; warnings.

    `solids` are the indices of those that stand, `built` of those that are built beyond the radius, `alone` of those that are
    left alone. `zones` are heights (low, high) in the axis frame, mm, in which the built solids' own metal stands: collars and
    flanges that go on inwards through the radius where it has no land. `built_faces` are (index of the solid, number of the
    face) that bound what is built. `roles` says all that in one line, `left_out` how much metal is not built.
    """

    radius: float
    solids: tuple[int, ...]
    reason: str
    warnings: tuple[str, ...] = ()
    built: tuple[int, ...] = ()
    alone: tuple[int, ...] = ()
    zones: tuple[tuple[float, float], ...] = ()
    built_faces: frozenset[tuple[int, int]] = frozenset()
    roles: str = ""
    left_out: str = ""

    def __repr__(self) -> str:
        stand = f", solids {shortened(str(list(self.solids)))} stand" if self.solids else ""
        return f"Substrate(R {self.radius:.6g} mm: {shortened(self.reason, 100)}{stand})"


def find_substrate(
    part: Part,
    axis: Axis,
    *,
    reach: dict[int, float],
    radius: float | None = None,
    build: Sequence[str | int] | None = None,
    stands: Sequence[str | int] | None = None,
) -> Substrate:
    """The cylinder to build on: by default the one that explains the part best (see `choice`), and every solid's role.

    Parameters
    ----------
    part, axis
        The part and its axis.
    reach : dict
        Outermost radius (mm) of each solid, by its index.
    radius : float, optional
        The substrate's radius if it is known.
    build, stands : sequence of str or int, optional
        Names or indices of solids that are to be built, or that stand; the others' roles follow from how they touch.

    Raises
    ------
    InputError
        If `radius` is no radius of this part, or there is no such solid.
    PlanningError
        If the part has no cylinder to build on, or two readings of it are about as likely.
    """
    reaches = np.array([reach[s.index] for s in part.solids])
    highest = float(reaches.max())
    if radius is not None:
        _check_given(part, radius, highest)
    lands = lands_of(part, axis)
    survey = survey_of(part, axis, levels_of(lands))
    candidates = [land.candidate for land in lands]
    if radius is not None:
        ground, reason, warnings = _given_ground(survey, lands, radius), "given", []
    else:
        choice = chosen_ground(survey, lands, highest)
        if choice is None:
            raise PlanningError(
                f"{part.source}: there is no coaxial cylinder with metal beyond it to build on"
                f" ({listed(candidates)}; the part ends at {highest:.6g} mm); give one with --substrate RADIUS"
            )
        ground, warnings = choice.ground, _doubts_of_choice(choice)
        reason = f"{choice.rule}{_runner_up(choice)} ({listed(candidates)})"
    named = places_named(part, build, "--build"), places_named(part, stands, "--stands")
    roles = roles_of(part, ground, reaches, build=named[0], stands=named[1])
    if radius is None and roles.zones and _in_zones(part, ground, roles) > MOST_IN_ZONES:
        # a cylinder that was chosen for what it carries is not one most of whose metal stands
        roles = replace(roles, zones=())
    built = _built_stretches(part, ground, roles)
    lost, told = _left_out(part, ground, built, roles)
    faces = _faces(ground, built)
    doubts = [*_stepped_foot(part, ground, lands, roles, asked=named[0]), *doubts_of(part, axis, ground.radius, faces)]
    return Substrate(
        radius=ground.radius,
        solids=roles.stand,
        reason=reason,
        warnings=(*warnings, *told, *doubts, *doubles_of(part, survey)),
        built=roles.built,
        alone=roles.alone,
        zones=roles.zones,
        built_faces=frozenset((part.solids[place].index, face) for place, face in faces),
        roles=said(part, roles, ground.radius),
        left_out=lost,
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


def _given_ground(survey: Survey, lands: Sequence[Land], radius: float) -> Ground:
    """The ground at a radius, with its land if the part has any there: outside, else in a bore."""
    same = [land for land in lands if abs(land.candidate.radius - radius) <= max(SAME_RADIUS, 1e-6 * radius)]
    external = [land for land in same if land.candidate.external]
    faces: frozenset[tuple[int, int]] = frozenset().union(*(land.faces for land in external or same))
    return Ground(survey=survey, radius=radius, faces=faces, external=bool(external) or not same)


def _runner_up(choice: Choice) -> str:
    second = choice.runner_up
    if second is None:
        return ""
    words = f"; the next best is {'' if second.external else 'the bore '}R {second.radius:.6g}"
    share = second.left_out / second.survey.volume
    return words + (f", which leaves {share:.0%} of the part out" if share > TOLD else "")


def _doubts_of_choice(choice: Choice) -> list[str]:
    radius = choice.ground.radius
    if not choice.ground.external:
        return [f"no shaft surface belongs to the part: it is taken to sit on a shaft that fills its bore, R {radius:g}"]
    if not choice.carried:
        return [
            f"no metal is seen to stand on R {radius:.6g} itself, only beyond it; give another with --substrate RADIUS",
        ]
    return []


def _built_stretches(part: Part, ground: Ground, roles: Roles) -> Array:
    """(stretches,) of metal beyond the radius that is to be built."""
    s = ground.survey.stretches
    indices = np.array([solid.index for solid in part.solids])
    built = (s.end > ground.radius + beyond(ground.radius)) & np.isin(indices[s.solid], roles.built)
    built &= ~(ground.on_land & ground.external)
    z = ground.survey.heights[s.ray // ground.survey.shape[1]]
    for low, high in roles.zones:
        built &= ~((z > low) & (z < high))
    return built


def _in_zones(part: Part, ground: Ground, roles: Roles) -> float:
    """The share of the metal to be built that lies in the zones in which it stands."""
    left, whole = (ground.volume(_built_stretches(part, ground, r)) for r in (roles, replace(roles, zones=())))
    return 1.0 - left / whole if whole > 0.0 else 0.0


def _faces(ground: Ground, built: Array) -> frozenset[tuple[int, int]]:
    """(place of the solid, face) of the faces that bound what is built, beyond the radius."""
    s = ground.survey.stretches
    ends = np.stack([s.solid[built], s.last[built]], axis=1)
    begins = built & (s.start > ground.radius + beyond(ground.radius))
    starts = np.stack([s.solid[begins], s.first[begins]], axis=1)
    return frozenset((int(a), int(b)) for a, b in np.unique(np.concatenate([ends, starts]), axis=0).tolist())


def _why(part: Part, roles: Roles) -> str:
    """What it is that is not built, in words."""
    names = {solid.index: solid.name for solid in part.solids}
    words = [f"collars and flanges that stand, at z {a:.6g} to {b:.6g} mm" for a, b in roles.zones[:MOST_NAMED]]
    for group, what in ((roles.stand, "stands"), (roles.alone, "is left alone")):
        words += [f"solid {i} ({shortened(names[i])}) {what}" for i in group[:MOST_NAMED]]
    return ", ".join(words) or "details that rays miss"


def _stepped_foot(part: Part, ground: Ground, lands: Sequence[Land], roles: Roles, *, asked: frozenset[int]) -> list[str]:
    """A doubt about turned metal with several steps that goes on through the radius in one piece, of which all is built.

    A worn journal and the collar beside it, drawn at full size in one solid with no land between them: which of the steps is to
    be built on a smaller radius cannot be told.
    """
    places = [i for i, solid in enumerate(part.solids) if solid.index in roles.built and i not in asked]
    if not ground.external or roles.zones or not places:
        return []
    s, edges = ground.survey.stretches, ground.survey.edges
    station = s.ray // ground.survey.shape[1]
    out = []
    for first, last in ground.shoulders(places):
        here = (station >= first) & (station < last)
        above = [x for x in lands if x.candidate.external and x.candidate.radius > ground.radius + beyond(ground.radius)]
        radii = sorted({x.candidate.radius for x in above if (flagged(s.solid, s.last, x.faces) & here).any()})
        if len(radii) > 1:
            steps = ", ".join(f"R {r:.6g}" for r in radii[:MOST_NAMED])
            out.append(
                f"turned metal with the steps {steps} goes on through R {ground.radius:.6g} mm in one piece, z"
                f" {edges[first]:.6g} to {edges[last]:.6g} mm, and all of it is built: if some of it stands, give what is to be"
                " built as a solid of its own, or a larger --substrate"
            )
    return out


def _left_out(part: Part, ground: Ground, built: Array, roles: Roles) -> tuple[str, list[str]]:
    """What is not built, in one line, and as warnings where it is more than a detail (volumes to a few in a thousand)."""
    survey, s, radius = ground.survey, ground.survey.stretches, ground.radius
    beyond_all = s.volumes(survey.weights, inner=radius)
    whole, lost = float(beyond_all.sum()), float(beyond_all[~built].sum())
    lost = max(lost, 0.0)
    share = lost / whole if whole > 0.0 else 0.0
    inside = survey.loose_below(radius)
    if not ground.external:
        inside = float(s.volumes(survey.weights, outer=radius).sum())
    within = inside / survey.volume
    line = (
        f"{lost:.3g} mm3 outside of R {radius:.6g} ({share:.1%} of the metal there), {inside:.3g} mm3 inside of it that is no"
        f" turned body ({within:.1%} of the part)"
    )
    told = []
    names = {solid.index: solid.name for solid in part.solids}
    if roles.alone:
        alone = ", ".join(f"{i} ({names[i]})" for i in roles.alone[:4]) + (", ..." if len(roles.alone) > 4 else "")
        told.append(f"left alone, since nothing that is built or stands touches it: solid {alone}; --build builds it")
    if share > TOLD:
        told.append(
            f"{lost:.4g} mm3 outside of R {radius:.6g} mm, {share:.1%} of the metal there, are not built: {_why(part, roles)}"
        )
    if within > TOLD:
        what = "metal inside of the bore" if not ground.external else "metal inside of it that is no turned body"
        told.append(
            f"left out below R {radius:.6g} mm: {inside:.4g} mm3, {within:.1%} of the part, {what} (teeth, lobes, spokes)"
        )
    return line, told
