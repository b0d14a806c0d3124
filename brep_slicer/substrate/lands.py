"""The coaxial cylinders of a part: what could be built on.

In: a part and its axis. Out: CylinderCandidates for whoever lists them, Lands with their faces for whoever chooses.

Words: *land*, the faces of one cylinder about the axis, outside or in a bore.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from brep_slicer.part import Part, as_part
from brep_slicer.wording import shortened

from .axis import SAME_DIRECTION, SAME_PLACE, Axis, as_axis, votes_of

if TYPE_CHECKING:
    from brep_slicer.kernel.revolutes import AxisVote

# Cylinders whose radii differ by less (mm) are one: several faces of one shaft in a file with rounded coordinates.
SAME_RADIUS = 1e-5
# There is metal beyond a cylinder when the part reaches farther out than this (mm), or this share of its radius if that is
# less: more than lands in files deviate from their cylinder.
BEYOND, BEYOND_SHARE = 1e-2, 1e-3
# A cylinder parallel to the axis within this (rad) and off it by less than this share of its radius is one that was meant to
# be coaxial: what its eccentricity leaves outside of another cylinder is no feature.
NEARLY_PARALLEL, ECCENTRIC_SHARE = 1e-3, 0.01


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
class Land:
    """A candidate with its faces, as (place of the solid in the part, number of the face)."""

    candidate: CylinderCandidate
    faces: frozenset[tuple[int, int]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Eccentric:
    """An external cylinder that is off the axis by `offset` (mm): its `radius`, its `solid`'s index, its `area` (mm**2)."""

    radius: float
    offset: float
    solid: int
    area: float


def beyond(radius: float) -> float:
    """How far past `radius` (mm) there has to be metal before it counts, mm."""
    return min(BEYOND, BEYOND_SHARE * radius)


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
    return [land.candidate for land in lands_of(part, as_axis(axis, part))]


def lands_of(part: Part, axis: Axis) -> list[Land]:
    """The same with the faces that each consists of."""
    groups: list[list[tuple[int, AxisVote]]] = []
    for place, solid in enumerate(part.solids):
        for vote in votes_of(solid):
            if vote.radius is None or not _is_coaxial(vote, axis):
                continue
            home = next((g for g in groups if _same_cylinder(g[0][1], vote)), None)
            groups.append([(place, vote)]) if home is None else home.append((place, vote))
    return sorted((_land(part, votes) for votes in groups), key=lambda land: -land.candidate.radius)


def eccentric_cylinders(part: Part, axis: Axis) -> list[Eccentric]:
    """External cylinders that miss the axis by little."""
    out = []
    for solid in part.solids:
        for vote in votes_of(solid):
            if vote.radius is None or vote.outward <= 0 or _is_coaxial(vote, axis):
                continue
            offset = _offset(vote, axis)
            if _tilt(vote, axis) <= NEARLY_PARALLEL and offset <= ECCENTRIC_SHARE * vote.radius:
                out.append(Eccentric(radius=vote.radius, offset=offset, solid=solid.index, area=vote.area))
    return out


def levels_of(lands: Sequence[Land]) -> dict[int, dict[int, float]]:
    """The exact radius of every coaxial face, {place of the solid: {face: mm}}."""
    out: dict[int, dict[int, float]] = {}
    for land in lands:
        for place, face in land.faces:
            out.setdefault(place, {})[face] = land.candidate.radius
    return out


def listed(candidates: Sequence[CylinderCandidate]) -> str:
    """The candidates in words, eight at most."""
    if not candidates:
        return "coaxial cylinders: none"
    words = [f"R {c.radius:.6g} {'outside' if c.external else 'bore'}" for c in candidates[:8]]
    return "coaxial cylinders: " + ", ".join(words) + (", ..." if len(candidates) > 8 else "")


def _land(part: Part, votes: list[tuple[int, AxisVote]]) -> Land:
    first = votes[0][1]
    assert first.radius is not None
    candidate = CylinderCandidate(
        radius=first.radius,
        area=sum(vote.area for _, vote in votes),
        external=first.outward > 0,
        solids=tuple(sorted({part.solids[place].index for place, _ in votes})),
    )
    return Land(candidate=candidate, faces=frozenset((place, vote.face) for place, vote in votes))


def _same_cylinder(a: AxisVote, b: AxisVote) -> bool:
    assert a.radius is not None
    assert b.radius is not None
    return abs(a.radius - b.radius) <= SAME_RADIUS and (a.outward > 0) == (b.outward > 0)


def _tilt(vote: AxisVote, axis: Axis) -> float:
    assert vote.direction is not None
    return float(np.linalg.norm(np.cross(vote.direction, axis.direction)))


def _offset(vote: AxisVote, axis: Axis) -> float:
    return float(np.linalg.norm(np.cross(axis.direction, vote.point - axis.origin)))


def _is_coaxial(vote: AxisVote, axis: Axis) -> bool:
    assert vote.radius is not None
    return _tilt(vote, axis) <= SAME_DIRECTION and _offset(vote, axis) <= max(SAME_PLACE * vote.radius, 1e-6)
