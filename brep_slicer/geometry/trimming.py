"""Which parameters lie inside of a face's boundary.

In: a face with its pcurves. Out: a Trimming, polygons in (u, v) that answer by the even-odd rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.maps import Array

from .brep import Face
from .edge_curves import LineEdge

# Samples of each curved smooth piece of a pcurve; the answer is for points well inside or well outside.
SAMPLES = 32


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trimming:
    """Edges of the boundary polygons in (u, v), from `start` to `end`, (n, 2) each."""

    start: Array
    end: Array

    def contains(self, uv: Array) -> NDArray[np.bool_]:
        """Whether points (m, 2) lie inside: a ray of rising v crosses the boundary an odd number of times."""
        a, b = self.start, self.end
        out = np.zeros(len(uv), dtype=bool)
        for first in range(0, len(uv), 512):
            p = uv[first : first + 512]
            spans = (a[None, :, 0] > p[:, None, 0]) != (b[None, :, 0] > p[:, None, 0])
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (p[:, None, 0] - a[None, :, 0]) / (b[None, :, 0] - a[None, :, 0])
                above = a[None, :, 1] + share * (b[None, :, 1] - a[None, :, 1]) > p[:, None, 1]
            out[first : first + 512] = (spans & above).sum(axis=1) % 2 == 1
        return out

    def surely_contains(self, uv: Array, scale: Array) -> bool:
        """Whether a curve that does not cross the boundary, given by points (m, 2) near it, lies inside.

        The point farthest from the boundary decides: where the curve runs along it, samples of both may lie on either side.
        """
        gap = uv[:, None] * scale - self.start[None] * scale
        d = (self.end - self.start) * scale
        share = np.clip((gap * d[None]).sum(axis=2) / np.maximum((d * d).sum(axis=1), 1e-300)[None], 0.0, 1.0)
        distance = np.linalg.norm(gap - share[..., None] * d[None], axis=2).min(axis=1)
        return bool(self.contains(uv[[int(distance.argmax())]])[0])


def trimming_of(face: Face) -> Trimming:
    """Sample a face's pcurves; a loop's gaps (jogs between its pcurves) are closed by straight lines."""
    starts, ends = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for loop in face.loops:
        chain = []
        for use in loop:
            if use.pcurve is None:
                continue
            first, last = use.range
            if isinstance(use.pcurve, LineEdge):
                t = np.array([first, last])
            else:
                breaks = use.pcurve.breaks(first, last)
                share = np.arange(SAMPLES) / SAMPLES
                t = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * share).ravel(), last)
            p = use.pcurve.points(t)
            chain.append(p if use.forward else p[::-1])
        if chain:
            ring = np.concatenate(chain)
            starts.append(ring)
            ends.append(np.roll(ring, -1, axis=0))
    return Trimming(start=np.concatenate(starts), end=np.concatenate(ends))
