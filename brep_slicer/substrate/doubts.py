"""What is odd about building a part about an axis: features that are turned about another, cylinders just off it.

In: a part, its axis, the faces of what is to be built. Out: sentences.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from brep_slicer.maps import TURN
from brep_slicer.part import Part

from .axis import Axis, AxisCandidate, axis_from_line, candidates_from_votes, text_of_axis, votes_of
from .lands import ECCENTRIC_SHARE, NEARLY_PARALLEL, beyond, eccentric_cylinders

if TYPE_CHECKING:
    from brep_slicer.kernel.revolutes import AxisVote

    from .survey import Survey

# Another axis is told of when faces with at least this share of the turned area of what is built say so, and more than those
# that say the one that is used.
RIVAL = 0.25
# A cylinder closes round when its faces cover this share of a turn; a line is square to the axis when the sine of their angle
# is above this.
WHOLE, SQUARE = 0.95, 0.9


def doubts_of(part: Part, axis: Axis, radius: float, faces: Iterable[tuple[int, int]]) -> list[str]:
    """Doubts about what is built beyond `radius` (mm), whose faces are (place of the solid, number of the face)."""
    chosen = set(faces)
    return [*_other_axis(part, axis, radius, chosen), *_eccentric(part, axis, radius)]


def doubles_of(part: Part, survey: Survey) -> list[str]:
    """Solids that lie one in the other, line by line along all rays: the same one twice in a file."""
    from .survey import CONTACT

    s = survey.stretches
    lines = [np.stack([s.ray, s.start, s.end], axis=1)[s.solid == place] for place in range(len(part.solids))]
    out = []
    for a, b in itertools.combinations(range(len(lines)), 2):
        same = len(lines[a]) > 0 and lines[a].shape == lines[b].shape
        if same and np.abs(lines[a] - lines[b]).max() <= CONTACT:
            first, second = part.solids[a], part.solids[b]
            out.append(f"solids {first.index} ({first.name}) and {second.index} ({second.name}) are the same twice: --solid")
    return [f"{text} chooses which are planned" for text in out]


def _other_axis(part: Part, axis: Axis, radius: float, faces: set[tuple[int, int]]) -> list[str]:
    votes = [v for place, solid in enumerate(part.solids) for v in votes_of(solid) if (place, v.face) in faces]
    # a hole or a rounding is turned, too, but nobody builds about its axis
    candidates = candidates_from_votes([v for v in votes if v.outward >= 0])
    own = sum(c.area for c in candidates if _nearly(c.axis, axis, radius))
    rivals = (c for c in candidates if c.share >= RIVAL and c.area > own)
    others = (c for c in rivals if not _nearly(c.axis, axis, radius) and not _is_spoke(c.axis, axis, radius))
    other: AxisCandidate | None = next((c for c in others if _goes_round(votes, c.axis, radius)), None)
    if other is None:
        return []
    share = own / other.area * other.share
    return [
        f"what is to be built is turned about another axis: {text_of_axis(other.axis)}, by {other.share:.0%} of its turned area"
        f" against {share:.0%} for {text_of_axis(axis)}, which is used; is it --axis {text_of_axis(other.axis)}?"
    ]


def _goes_round(votes: Sequence[AxisVote], axis: Axis, radius: float) -> bool:
    """Whether outside faces of one cylinder close round an axis: a band, a pin; the nose of a cam does not."""
    turns: dict[float, float] = {}
    for v in votes:
        if v.radius is not None and v.direction is not None and _nearly(axis_from_line(v.point, v.direction), axis, radius):
            turns[round(v.radius, 5)] = turns.get(round(v.radius, 5), 0.0) + v.turn
    return max(turns.values(), default=0.0) >= WHOLE * TURN


def _is_spoke(a: Axis, b: Axis, radius: float) -> bool:
    """Whether a line meets the axis square to it: a stud on the shaft is a feature like others."""
    across = np.cross(a.direction, b.direction)
    size = float(np.linalg.norm(across))
    return size > SQUARE and abs(float((a.origin - b.origin) @ across)) <= ECCENTRIC_SHARE * radius * size


def _nearly(a: Axis, b: Axis, radius: float) -> bool:
    """Whether two axes are one, but for an eccentricity that is small against the radius."""
    apart = float(np.linalg.norm(np.cross(b.direction, a.origin - b.origin)))
    tilt = float(np.linalg.norm(np.cross(a.direction, b.direction)))
    return tilt <= NEARLY_PARALLEL and apart <= ECCENTRIC_SHARE * radius


def _eccentric(part: Part, axis: Axis, radius: float) -> list[str]:
    """Cylinders that were meant to be coaxial and stand out of the substrate on one side."""
    found: dict[tuple[int, float, float], float] = {}
    for c in eccentric_cylinders(part, axis):
        if c.radius + c.offset > radius + beyond(radius):
            key = (c.solid, round(c.radius, 5), round(c.offset, 5))
            found[key] = found.get(key, 0.0) + c.area
    out = []
    for (solid, size, offset), area in found.items():
        out.append(
            f"the cylinder R {size:.6g} mm of solid {solid} ({area:.4g} mm2) lies {offset:.3g} mm off the axis: it reaches from"
            f" R {size - offset:.6g} to R {size + offset:.6g}, and what that adds to a layer is its eccentricity, no feature"
        )
    return out
