"""Parallel lines on a full turn: they go on across the seam, and close on themselves by a whole number of spacings.

In: the length of a turn, an angle and a spacing. Out: the angle and spacing that close, stretches joined across the seam.

Words: *k*, how many spacings a turn is long across the lines: L sin(phi) = k d; *rings* have k = 0.
"""

from __future__ import annotations

import math

import numpy as np

from brep_slicer.curves.loop import Loop
from brep_slicer.layers import Closure
from brep_slicer.maps import TURN, Array
from brep_slicer.region import Piece

from .inset import Inset
from .scanlines import Stretches

# Within this of 90 degrees the angle is kept and the spacing moves: there a hair's breadth of d would turn lines by degrees.
UPRIGHT = math.radians(10.0)
# What lies no farther from a side of the window lies on it, turns: rounding.
ON_SIDE = 1e-9


def closing_lines(length: float, angle: float, step_over: float) -> tuple[float, float, int]:
    """The nearest angle in (-pi/2, pi/2] and spacing with length * sin(angle) = k * spacing, k whole; `length` mm once round.

    Returns the angle, the spacing and k (0 for rings, signed like the angle).
    """
    angle = _folded(angle)
    if angle == 0.0:
        return 0.0, step_over, 0
    sin = math.sin(abs(angle))
    k = round(length * sin / step_over)
    if k == 0:
        return 0.0, step_over, 0
    if 0.5 * math.pi - abs(angle) <= UPRIGHT or k * step_over >= length:
        return angle, length * sin / k, k if angle > 0.0 else -k
    moved = math.asin(k * step_over / length)
    return math.copysign(moved, angle), step_over, k if angle > 0.0 else -k


def _folded(angle: float) -> float:
    """The same lines' angle in (-pi/2, pi/2]; multiples of a quarter turn exactly."""
    quarter = round(angle / (0.5 * math.pi))
    if abs(angle - quarter * 0.5 * math.pi) < 1e-12:
        return 0.0 if quarter % 2 == 0 else 0.5 * math.pi
    folded = math.remainder(angle, math.pi)
    return 0.5 * math.pi if folded == -0.5 * math.pi else folded


def anchor_of(piece: Piece) -> float:
    """The place (turns) that turns with a winding piece: where the lowest harmonic of its outline that is not nil points.

    For an outline of rings alone there is none, and 0 (the axis' x_direction) it is.
    """
    for harmonic in range(1, 49):
        moment = sum(_harmonic(loop, harmonic) for loop in piece.loops)
        if abs(moment) > 1e-7 * TURN * max(1.0, max(abs(x) for x in piece.bounds()[1::2])):
            return float(np.angle(moment)) / harmonic / TURN
    return 0.0


def _harmonic(loop: Loop, harmonic: int) -> complex:
    closure = loop.closure
    points = loop.sample(1e-3 * closure.length / TURN)
    heights = closure.heights_of(points)
    v = 0.5 * (heights[:-1] + heights[1:])
    turn = np.exp(1j * harmonic * TURN * closure.turns_along(points))
    return complex(np.sum(v * np.diff(turn)) / (1j * harmonic))


def join_across_seam(stretches: Stretches, inset: Inset, k: int) -> list[tuple[Array, bool]]:
    """Stretches of one window joined where they leave it on one side and come in on the other.

    Returns (points, closed) pairs in the universal cover; a closed one went all the way round and met itself.
    """
    starts, ends = stretches.points[:, 0], stretches.points[:, 1]
    comes_in = np.abs(inset.closure.turns_of(starts) - inset.cut) < ON_SIDE
    goes_out = np.abs(inset.closure.turns_of(ends) - inset.cut - 1.0) < ON_SIDE
    # leaving a turn on on line m is coming in at the cut on the line that lies k spacings higher there
    entry = {
        (int(m), round(float(v), 6)): i
        for i, (m, v) in enumerate(zip(stretches.line, starts[:, 1], strict=True))
        if comes_in[i]
    }
    following = np.full(len(starts), -1)
    for i in np.flatnonzero(goes_out):
        m, v = int(stretches.line[i]) + k, float(ends[i, 1])
        found = next((entry[m, r] for r in (round(v, 6), round(v + 1e-6, 6), round(v - 1e-6, 6)) if (m, r) in entry), None)
        if found is not None:
            following[i] = found
    return _chained(stretches, following, inset.closure)


def _chained(stretches: Stretches, following: Array, closure: Closure) -> list[tuple[Array, bool]]:
    preceded = np.zeros(len(following), dtype=bool)
    preceded[following[following >= 0]] = True
    done = np.zeros(len(following), dtype=bool)
    out = []
    for first in [*np.flatnonzero(~preceded), *np.flatnonzero(preceded)]:
        if done[first]:
            continue
        chain, turns, i = [stretches.points[first, 0]], 0, int(first)
        while True:
            done[i] = True
            last = closure.moved(stretches.points[i, 1], turns)
            if following[i] < 0 or done[following[i]]:
                break
            i, turns = int(following[i]), turns + 1
        closed = bool(following[i] == first and preceded[first])
        out.append((np.array([chain[0], last]), closed))
    return out
