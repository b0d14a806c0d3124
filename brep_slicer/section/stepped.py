"""How far an outline that was cut a step outside of its radius lies from where it belongs.

In: the outlines one step and several steps farther out, drawn on one cylinder. Out: mm.

A face that leaves the cylinder at an angle moves its outline by a multiple of the step, one that is tangent to it by a multiple
of the step's square root, however it is curved. From x(step) ~ step**p with p >= 1/2, and the move x(far) - x(near) that is
measured, x(near) <= move / (sqrt(far / near) - 1).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from brep_slicer.curves import Loop

# Points of one outline, and the polyline of the other from which they are measured, mm.
POINTS, CHORD = 1e-3, 1e-6


def moved_by_step(near: Sequence[Loop], far: Sequence[Loop], steps: tuple[float, float]) -> float:
    """A bound on how far the outline `near`, cut at steps[0] outside of its radius, lies from the one at the radius, mm.

    `far` is the outline at steps[1] > steps[0]. If there is no metal left there, the outline's own extent is all that is known.
    """
    if not near:
        return 0.0
    if not far:  # no more than an upper bound, and mostly one that fails the layer
        return max(math.hypot(k1 - k0, v1 - v0) for k0, v0, k1, v1 in (loop.bounds() for loop in near))
    return outlines_apart(near, far) / (math.sqrt(steps[1] / steps[0]) - 1.0)


def outlines_apart(first: Sequence[Loop], second: Sequence[Loop]) -> float:
    """The farthest that points of either outline lie from the other, mm, across the seam too; neither may be empty."""
    import shapely

    worst = 0.0
    for one, other in ((first, second), (second, first)):
        lines = shapely.MultiLineString([loop.moved(k).sample(CHORD) for loop in other for k in _copies(loop)])
        shapely.prepare(lines)
        points = one[0].closure.canonical(np.concatenate([loop.sample(POINTS) for loop in one]))
        worst = max(worst, float(shapely.distance(lines, shapely.points(points)).max()))
    return worst


def _copies(loop: Loop) -> range:
    """The turns by which a loop may be moved and still lie within a turn from [-half a turn, half a turn]."""
    return loop.closure.copies_between(loop.bounds(), -1.5, 1.5)
