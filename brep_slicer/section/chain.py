"""Curves with named ends, chained into closed loops by identity.

In: unrolled curves on a sheet, each from one numbered node to another, material on the left. Out: Loop values.

Words: *node*, a numbered point where one curve ends and the next begins; *jog*, the gap in mm between the two there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from brep_slicer.curves import Curve, Loop
from brep_slicer.errors import LayerError
from brep_slicer.layers import Closure, Sheet
from brep_slicer.maps import Array

# A curve is followed round the axis by its points at these parameters: one that goes round sixty times as well.
FOLLOWED = np.linspace(0.0, 1.0, 129)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Arc:
    """A curve from node `start` to node `end`; a closed curve without nodes has both at -1."""

    curve: Curve
    start: int
    end: int


def loops_from_arcs(sheet: Sheet, arcs: Sequence[Arc]) -> list[Loop]:
    """Follow the arcs from node to node until each loop closes.

    Where several arcs leave one node (the outline touches itself there) the sharpest left turn is taken, which keeps
    the loops from crossing.

    Raises
    ------
    LayerError
        If a node has not as many arcs going out as coming in, or a loop does not come back to its start.
    """
    loops = [_closed_loop([arc.curve], sheet) for arc in arcs if arc.start < 0]
    open_arcs = [arc for arc in arcs if arc.start >= 0]
    leaving: dict[int, list[int]] = {}
    for i, arc in enumerate(open_arcs):
        leaving.setdefault(arc.start, []).append(i)
    arriving: dict[int, int] = {}
    for arc in open_arcs:
        arriving[arc.end] = arriving.get(arc.end, 0) + 1
    unpaired = [n for n in leaving.keys() | arriving.keys() if len(leaving.get(n, ())) != arriving.get(n, 0)]
    if unpaired:
        raise LayerError(f"the section at {sheet.label} is open at {len(unpaired)} points")
    used = [False] * len(open_arcs)
    for first in range(len(open_arcs)):
        if used[first]:
            continue
        chain: list[Curve] = []
        turns = 0.0
        i = first
        while True:
            used[i] = True
            arc = open_arcs[i]
            curve, turns = _continued(arc.curve, turns if chain else None, sheet.closure)
            chain.append(curve)
            choices = [j for j in leaving[arc.end] if not used[j] or j == first]
            i = choices[0] if len(choices) == 1 else _leftmost(arc, choices, open_arcs)
            if i == first:
                break
        loops.append(_closed_loop(chain, sheet))
    return loops


def _continued(curve: Curve, end: float | None, closure: Closure) -> tuple[Curve, float]:
    """The copy of a curve that starts where the previous one ended, `end` turns round, and where it ends itself."""
    start, last = _turns_of_ends(curve, closure)
    copy = 0.0 if end is None else round(end - start)
    return curve.moved(closure.motion(copy)) if copy else curve, last + copy


def _turns_of_ends(curve: Curve, closure: Closure) -> tuple[float, float]:
    """Where a curve begins and ends, in turns, followed along it where the plane alone does not tell."""
    ends = np.stack([curve.start, curve.end]) if closure.is_translation else curve.points(FOLLOWED)
    turns = closure.turns_along(ends)
    return float(turns[0]), float(turns[-1])


def _leftmost(arc: Arc, choices: list[int], arcs: Sequence[Arc]) -> int:
    along = _direction(arc.curve, 1.0)

    def turn(j: int) -> float:
        d = _direction(arcs[j].curve, 0.0)
        return float(np.arctan2(along[0] * d[1] - along[1] * d[0], along @ d))

    return max(choices, key=turn)


def _direction(curve: Curve, s: float) -> Array:
    d = curve.derivatives(np.array([s]))[0]
    size = np.hypot(*d)
    if size > 1e-12:
        return d / size
    inner = curve.points(np.array([abs(s - 1e-4)]))[0] - curve.points(np.array([s]))[0]
    inner = inner if s < 0.5 else -inner
    return inner / max(np.hypot(*inner), 1e-300)


def _closed_loop(curves: list[Curve], sheet: Sheet) -> Loop:
    turns = 0.0
    for curve in curves:
        start, end = _turns_of_ends(curve, sheet.closure)
        turns += end - start
    return Loop(curves=tuple(curves), sheet=sheet, winding=round(turns))
