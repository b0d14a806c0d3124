"""Where a curve comes near to another region's outline: crossings, and runs along it.

In: a curve, an outline, how near counts as touching. Out: stretches of the curve's parameter.

A span of the curve lies within a *deviation* of the polyline through five of its points. If that polyline is farther from the
outline than a touch and the deviation together, the span does not touch it. Nor does it if all that is nearer to the polyline
runs beside it, on one side and farther away than a touch when measured to the true curve. What neither rules out is halved, and
the deviation is quartered.
"""

from __future__ import annotations

import numpy as np

from brep_slicer.curves import Curve
from brep_slicer.maps import Array

from .outline import Outline, spaced_parameters

# The first spans of a curve: their chord's polyline within so many touches; through five points it is 16 times nearer, of which
# half is believed.
FIRST_CHORD, NEARER = 200.0, 8.0
# Between the five points the curve and the one beside it may come nearer to each other by both their deviations.
BESIDE = 2.0
# Where both ends, and the points between them at these shares, lie on the outline, the whole span does: it has no corner (the
# other outline's ends are among the marks).
SHARES = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
# A span of this share of a touch is judged by its middle.
SHORTEST, MAXIMUM_HALVINGS = 0.25, 60


def contacts(curve: Curve, outline: Outline, marks: Array, touch: float, chord: float) -> list[tuple[float, float]]:
    """The stretches (s0, s1), in order, on which `curve` lies within `touch` mm of `outline`; it is cut at `marks` (n,).

    The outline is drawn to within `chord` mm of its curves.
    """
    s = np.union1d(spaced_parameters(curve, FIRST_CHORD * touch, outline.reach), np.clip(marks, 0.0, 1.0))
    a, b = s[:-1], s[1:]
    near: list[Array] = []
    for level in range(MAXIMUM_HALVINGS):
        if not len(a):
            break
        points = curve.points((a[:, None] + SHARES * (b - a)[:, None]).ravel()).reshape(-1, len(SHARES), 2)
        deviation = FIRST_CHORD * touch / NEARER / 4.0**level
        maybe = outline.distances_from(points) <= touch + deviation + chord
        a, b, points = a[maybe], b[maybe], points[maybe]
        at = outline.nearest(points.reshape(-1, 2))
        gaps = at.distances.reshape(-1, len(SHARES))
        apart = np.flatnonzero(gaps.min(axis=1, initial=np.inf) > touch + BESIDE * deviation)
        clear = np.zeros(len(a), dtype=bool)
        clear[apart] = outline.runs_beside(points[apart], at.rows(apart, len(SHARES)), touch + deviation + chord)
        a, b, points, gaps = a[~clear], b[~clear], points[~clear], gaps[~clear]
        short = np.hypot(*np.moveaxis(np.diff(points, axis=1), -1, 0)).sum(axis=1) < SHORTEST * touch
        within = np.where(short, gaps[:, 2] <= touch, (gaps <= touch).all(axis=1))
        near.append(np.stack([a, b], axis=-1)[within])
        a, b = a[~within & ~short], b[~within & ~short]
        middle = 0.5 * (a + b)
        a, b = np.concatenate([a, middle]), np.concatenate([middle, b])
    return _merged(np.concatenate(near) if near else np.zeros((0, 2)))


def _merged(spans: Array) -> list[tuple[float, float]]:
    """Spans that follow one another, as one."""
    if not len(spans):
        return []
    spans = spans[np.argsort(spans[:, 0])]
    first = np.concatenate([[True], spans[1:, 0] > spans[:-1, 1]])
    last = np.concatenate([first[1:], [True]])
    return list(zip(spans[first, 0].tolist(), spans[last, 1].tolist(), strict=True))
