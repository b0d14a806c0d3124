"""The axis that layers are coaxial with: found by a vote of the faces, or given.

In: a Part, or a text from the command line. Out: a frozen Axis in the file's own frame, with its maps.

Words: *axis frame*, origin on the axis, z along it, theta = 0 along x_direction; *share*, the part of the voting area
that stands for a line.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from brep_slicer.curves.base import frozen_array
from brep_slicer.errors import InputError, PlanningError
from brep_slicer.maps import Array
from brep_slicer.part import Part, Solid, as_part
from brep_slicer.wording import shortened

if TYPE_CHECKING:
    from brep_slicer.kernel.revolutes import AxisVote

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

    def __repr__(self) -> str:
        return f"Axis({text_of_axis(self)})"

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

    def __repr__(self) -> str:
        return f"AxisCandidate({text_of_axis(self.axis)}, {self.area:.6g} mm2, {self.share:.0%} of the turned area)"


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


def find_axis(part: Any) -> Axis:
    """The line that most of the turned faces of a part (anything that `as_part` takes) share.

    Raises
    ------
    PlanningError
        If no face has an axis, or if another line has nearly as many votes; the message lists the candidates.
    """
    part = as_part(part)
    candidates = axis_candidates(part)
    if not candidates:
        raise PlanningError(f"{part.source}: no face is turned about an axis; give one with --axis (axis=)")
    if len(candidates) > 1 and candidates[1].area >= RIVAL_SHARE * candidates[0].area:
        listed = "; ".join(describe_candidate(c) for c in candidates[:5])
        raise PlanningError(f"{part.source}: several axes are possible ({listed}); choose one with --axis (axis=)")
    return candidates[0].axis


def as_axis(axis: Any, part: Part) -> Axis:
    """The axis given, as such, as text, or as a CAD host's own line; without one, the part's own.

    Parameters
    ----------
    axis
        An Axis, a text as `axis_from_text` reads it, a build123d Axis, a plane of build123d or CadQuery (its normal through
        its origin), a vector of either (through the file's origin), OCCT's gp_Ax1, three numbers (a direction), or a point
        and a direction; None to find it.

    Raises
    ------
    InputError
        If it is none of these.
    PlanningError
        If none is given and the part has no axis, or several.
    """
    if axis is None:
        return find_axis(part)
    if isinstance(axis, str):
        return axis_from_text(axis)
    if isinstance(axis, Axis):
        return axis
    line = _host_line(axis)
    if line is None:
        raise InputError(
            f"axis is {shortened(repr(axis))}; give a text as 'Z' or '0,0,5:0,0,1', (point, direction), an Axis, or a line,"
            " plane or vector of build123d or CadQuery"
        )
    return axis_from_line(*line)


# Where the hosts keep a line's point and direction: build123d's Axis and Plane, CadQuery's Plane, OCCT's gp_Ax1.
_LINES = (("position", "direction"), ("origin", "z_dir"), ("origin", "zDir"), ("Location", "Direction"))


def _host_line(thing: Any) -> tuple[Array, Array] | None:
    """The (point, direction) of a host's line, plane or vector, or of plain numbers; None if it is nothing of the kind."""
    for point, direction in _LINES:
        if hasattr(thing, point) and hasattr(thing, direction):
            ends = [_three(getattr(thing, name)) for name in (point, direction)]
            return None if ends[0] is None or ends[1] is None else (ends[0], ends[1])
    alone = _three(thing)
    if alone is not None:
        return np.zeros(3), alone
    if isinstance(thing, list | tuple | np.ndarray) and len(thing) == 2:
        ends = [_three(end) for end in thing]
        return None if ends[0] is None or ends[1] is None else (ends[0], ends[1])
    return None


def _three(thing: Any) -> Array | None:
    """Three numbers from a vector of a host or from plain numbers; None if it is none."""
    if callable(thing):  # OCCT's objects keep their parts behind calls
        thing = thing()
    if hasattr(thing, "toTuple"):  # CadQuery
        thing = thing.toTuple()
    elif all(hasattr(thing, name) for name in "XYZ"):  # build123d has numbers there, OCCT calls
        thing = [part() if callable(part) else part for part in (thing.X, thing.Y, thing.Z)]
    try:
        numbers = np.asarray(thing, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    return numbers if numbers.shape == (3,) else None


def text_of_axis(axis: Axis) -> str:
    """As --axis takes it: origin:direction."""
    return ":".join(",".join(f"{x:.6g}" for x in v) for v in (axis.origin, axis.direction))


def describe_candidate(candidate: AxisCandidate) -> str:
    """A candidate as text that --axis takes, with its share."""
    return f"{text_of_axis(candidate.axis)} with {candidate.share:.0%} of the turned area"


def axis_candidates(part: Any) -> list[AxisCandidate]:
    """Every line that faces of a part (anything that `as_part` takes) vote for, the most area first."""
    return candidates_from_votes([vote for solid in as_part(part).solids for vote in votes_of(solid)])


def votes_of(solid: Solid) -> list[AxisVote]:
    """What each face of a solid says about an axis; asked once."""
    from brep_slicer.kernel.revolutes import axis_votes

    if "axis_votes" not in solid.known:
        solid.known["axis_votes"] = axis_votes(solid.wrapped)
    return solid.known["axis_votes"]


def candidates_from_votes(votes: Sequence[AxisVote]) -> list[AxisCandidate]:
    """Every line that these votes are for, the most area first."""
    lines = sorted((v for v in votes if v.direction is not None), key=lambda v: -v.area)
    total = sum(vote.area for vote in votes)
    # about their middle: a part is as large as it is, wherever its file has put it
    points = np.array([v.point for v in votes]).reshape(-1, 3)
    away = np.linalg.norm(points - points.mean(axis=0), axis=1) if len(votes) else np.zeros(1)
    reach = float(away.max()) + math.sqrt(total)
    groups = _grouped(lines, SAME_PLACE * reach)
    centres = [v for v in votes if v.direction is None]
    middles, areas = np.array([v.point for v in centres]).reshape(-1, 3), np.array([v.area for v in centres])
    out = []
    for group in groups:
        first = _representative(group, SAME_PLACE * reach)
        area = sum(v.area for v in group)
        area += float(
            areas[np.linalg.norm(np.cross(first.direction, middles - first.point), axis=1) <= SAME_PLACE * reach].sum()
        )
        out.append(AxisCandidate(axis=axis_from_line(first.point, first.direction), area=area, share=area / total))
    return sorted(out, key=lambda c: -c.area)


def _grouped(votes: Sequence[AxisVote], reach: float) -> list[list[AxisVote]]:
    """Votes by line, each with the first group whose first vote is for the same line within `reach` (mm)."""
    groups: list[list[AxisVote]] = []
    points, directions = np.zeros((len(votes), 3)), np.zeros((len(votes), 3))
    for vote in votes:
        n = len(groups)
        assert vote.direction is not None
        tilt = np.linalg.norm(np.cross(directions[:n], vote.direction), axis=1)
        apart = np.linalg.norm(np.cross(directions[:n], vote.point - points[:n]), axis=1)
        same = np.flatnonzero((tilt <= SAME_DIRECTION) & (apart <= reach))
        if len(same):
            groups[same[0]].append(vote)
        else:
            points[n], directions[n] = vote.point, vote.direction
            groups.append([vote])
    return groups


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


def _same_line(a: Any, b: Any, reach: float) -> bool:
    return float(np.linalg.norm(np.cross(a.direction, b.direction))) <= SAME_DIRECTION and _distance(a, b.point) <= reach


def _distance(line: Any, point: Array) -> float:
    return float(np.linalg.norm(np.cross(line.direction, point - line.point)))
