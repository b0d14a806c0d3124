"""The axis that layers are coaxial with: found by a vote of the faces, or given.

In: a Part, or a text from the command line. Out: a frozen Axis in the file's own frame, with its maps.

Words: *axis frame*, origin on the axis, z along it, theta = 0 along x_direction; *share*, the part of the voting area
that stands for a line.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from brep_slicer.curves.base import frozen_array
from brep_slicer.errors import InputError, PlanningError
from brep_slicer.maps import Array
from brep_slicer.part import Part

# Two votes are one line when their directions agree to this (rad) ...
SAME_DIRECTION = 1e-4
# ... and they pass each other within this share of the part's size; CAD files round coordinates to about 1e-6 of it.
SAME_PLACE = 1e-5
# A second line with this share of the first one's area makes the part ambiguous.
RIVAL_SHARE = 0.8


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Axis:
    """`origin`, `direction` and `x_direction`, each (3,), in the file's frame (mm; unit vectors).

    Built by `axis_from_line`, the origin is the foot of the file's origin, the direction's largest component is positive,
    and x_direction is the file's X projected (Y if X is parallel to the axis).
    """

    origin: Array
    direction: Array
    x_direction: Array

    def __post_init__(self) -> None:
        for name in ("origin", "direction", "x_direction"):
            object.__setattr__(self, name, frozen_array(getattr(self, name), name=name, shape=(3,)))

    @property
    def rotation(self) -> Array:
        """(3, 3); its rows are the axis frame's x, y and z in the file's frame."""
        return np.stack([self.x_direction, np.cross(self.direction, self.x_direction), self.direction])

    @property
    def matrix(self) -> Array:
        """(4, 4) rigid motion that takes the file's frame to the axis frame."""
        out = np.eye(4)
        out[:3, :3] = self.rotation
        out[:3, 3] = -self.rotation @ self.origin
        return out

    def axis_from_file(self, points: ArrayLike) -> Array:
        """Points (..., 3) in the file's frame, mm, to the axis frame."""
        return (np.asarray(points, dtype=np.float64) - self.origin) @ self.rotation.T

    def file_from_axis(self, points: ArrayLike) -> Array:
        """Points (..., 3) in the axis frame, mm, to the file's frame."""
        return np.asarray(points, dtype=np.float64) @ self.rotation + self.origin

    def file_from_axis_vectors(self, vectors: ArrayLike) -> Array:
        """Directions (..., 3) in the axis frame to the file's frame."""
        return np.asarray(vectors, dtype=np.float64) @ self.rotation

    def as_dict(self) -> dict[str, list[float]]:
        """Plain values, for reports."""
        return {name: getattr(self, name).tolist() for name in ("origin", "direction", "x_direction")}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class AxisCandidate:
    """A line that faces vote for, its area (mm**2) and its share of all votes."""

    axis: Axis
    area: float
    share: float


def axis_from_line(point: ArrayLike, direction: ArrayLike) -> Axis:
    """The Axis along a line, by the project's convention.

    Raises
    ------
    InputError
        If the direction is zero or a value is not finite.
    """
    p, d = np.asarray(point, dtype=np.float64), np.asarray(direction, dtype=np.float64)
    size = float(np.linalg.norm(d))
    if not (np.isfinite(p).all() and np.isfinite(d).all() and size > 0.0):
        raise InputError("an axis needs a finite origin and a direction that is not zero")
    d = d / size
    d = d * np.sign(d[np.abs(np.round(d, 9)).argmax()])
    x = np.array([1.0, 0.0, 0.0]) if abs(d[0]) < 1.0 - 1e-9 else np.array([0.0, 1.0, 0.0])
    x = x - (x @ d) * d
    # the foot of the file's origin; + 0.0 turns -0.0 into 0.0
    return Axis(origin=p - (p @ d) * d + 0.0, direction=d + 0.0, x_direction=x / np.linalg.norm(x) + 0.0)


def axis_from_text(text: str) -> Axis:
    """The Axis of a command-line option: X, Y, Z, or origin:direction as `0,0,5:0,0,1`.

    Raises
    ------
    InputError
        If the text is neither.
    """
    named = {"X": (1, 0, 0), "Y": (0, 1, 0), "Z": (0, 0, 1)}
    if text.strip().upper() in named:
        return axis_from_line((0.0, 0.0, 0.0), named[text.strip().upper()])
    try:
        origin, direction = (tuple(float(x) for x in half.split(",")) for half in text.split(":"))
        if len(origin) != 3 or len(direction) != 3 or not all(map(math.isfinite, origin + direction)):
            raise ValueError
    except ValueError:
        raise InputError(f"axis {text!r} is not understood; give X, Y, Z, or origin:direction like 0,0,5:0,0,1") from None
    return axis_from_line(origin, direction)


def find_axis(part: Part) -> Axis:
    """The line that most of the part's turned faces share.

    Raises
    ------
    PlanningError
        If no face has an axis, or if another line has nearly as many votes; the message lists the candidates.
    """
    candidates = axis_candidates(part)
    if not candidates:
        raise PlanningError(f"{part.source}: no face is turned about an axis; give one with --axis (axis=)")
    if len(candidates) > 1 and candidates[1].area >= RIVAL_SHARE * candidates[0].area:
        listed = "; ".join(describe_candidate(c) for c in candidates[:5])
        raise PlanningError(f"{part.source}: several axes are possible ({listed}); choose one with --axis (axis=)")
    return candidates[0].axis


def as_axis(axis: Axis | str | None, part: Part) -> Axis:
    """The axis given, as such or as text; without one, the part's own.

    Raises
    ------
    InputError
        If it is neither.
    PlanningError
        If none is given and the part has no axis, or several.
    """
    if axis is None:
        return find_axis(part)
    if isinstance(axis, str):
        return axis_from_text(axis)
    if not isinstance(axis, Axis):
        raise InputError(f"axis is {axis!r}; give an Axis (find_axis, axis_from_line) or a text as --axis takes it")
    return axis


def describe_candidate(candidate: AxisCandidate) -> str:
    """A candidate as text that --axis takes, with its share."""
    origin, direction = (",".join(f"{x:.6g}" for x in v) for v in (candidate.axis.origin, candidate.axis.direction))
    return f"{origin}:{direction} with {candidate.share:.0%} of the turned area"


def axis_candidates(part: Part) -> list[AxisCandidate]:
    """Every line that faces vote for, the most area first."""
    from brep_slicer.kernel.revolutes import axis_votes

    votes = [vote for solid in part.solids for vote in axis_votes(solid.wrapped)]
    lines = sorted((v for v in votes if v.direction is not None), key=lambda v: -v.area)
    total = sum(vote.area for vote in votes)
    reach = max((float(np.linalg.norm(v.point)) for v in votes), default=0.0) + math.sqrt(total)
    groups: list[list] = []
    for vote in lines:
        home = next((g for g in groups if _same_line(g[0], vote, SAME_PLACE * reach)), None)
        groups.append([vote]) if home is None else home.append(vote)
    centres = [v for v in votes if v.direction is None]
    out = []
    for group in groups:
        first = _representative(group, SAME_PLACE * reach)
        area = sum(v.area for v in group)
        area += sum(v.area for v in centres if _distance(first, v.point) <= SAME_PLACE * reach)
        out.append(AxisCandidate(axis=axis_from_line(first.point, first.direction), area=area, share=area / total))
    return sorted(out, key=lambda c: -c.area)


def _representative(group: list, reach: float):
    """The vote that stands for a line: the largest stored as a turned surface; else the largest fitted one.

    A fitted line that is one of the file's main axes within the fit's own error is taken for that axis.
    """
    exact = [v for v in group if v.exact]
    if exact:
        return exact[0]
    for direction in np.eye(3):
        main = replace(group[0], point=np.zeros(3), direction=direction)
        if _same_line(main, group[0], reach):
            return main
    return group[0]


def _same_line(a, b, reach: float) -> bool:
    return float(np.linalg.norm(np.cross(a.direction, b.direction))) <= SAME_DIRECTION and _distance(a, b.point) <= reach


def _distance(line, point: Array) -> float:
    return float(np.linalg.norm(np.cross(line.direction, point - line.point)))
