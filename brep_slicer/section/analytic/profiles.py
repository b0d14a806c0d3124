"""Where a swept face's profile meets the layers: rulings of extrusions along the axis, circles of surfaces of revolution.

In: a face's profile curve, the face parameters of its nodes. Out: for each node the place on the profile that has its layer's
radius: the same for all nodes on one ruling or circle, however far the edges lie off the face.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from brep_slicer.field.turning_points import turning_points
from brep_slicer.geometry import Edge, EdgeCurve
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array

from .nodes import crossings

# The profile is looked at beyond the face by what its nodes overstep, and this share of its own range.
BEYOND = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Places:
    """For each node (n,): the `number` of its place among all, the profile's parameter there, its point (n, 3)."""

    number: NDArray[np.int64]
    parameter: Array
    point: Array


def places_on_profile(
    curve: EdgeCurve, ends: Array, parameter: Array, layer: NDArray[np.int64], radius: Array, family: LayerFamily = CYLINDERS
) -> Places:
    """For nodes at `parameter` (n,) near a profile, the nearest place at the level `radius` (n,) of their `layer` (n,).

    `ends` (2,) is the profile's own range. Where it does not come to the radius at all (a node on an edge beyond its crest),
    its crest is the place: the gap is the edge's, and is held against what the edge's gaps explain like any other.
    """
    slack = BEYOND * float(ends[1] - ends[0])
    first, last = min(float(ends[0]), parameter.min()) - slack, max(float(ends[1]), parameter.max()) + slack
    (turns,) = turning_points([Edge(curve=curve, first=first, last=last, vertices=(0, 0), tolerance=0.0)], family)
    t = np.concatenate([[first], turns, [last]])
    rho = family.value(curve.points(t))
    layers, where = np.unique(layer, return_index=True)
    radii = radius[where]
    # every layer with every stretch of the profile that it crosses
    row, stretch = np.nonzero((rho[:-1] > radii[:, None]) != (rho[1:] > radii[:, None]))
    span = np.stack([t[stretch], t[stretch + 1]], axis=1)
    found = crossings(curve.derivatives, span, radii[row], family) if len(row) else np.zeros(0)
    lost = np.setdiff1d(np.arange(len(layers)), row)
    crest = t[np.abs(rho[None, :] - radii[lost, None]).argmin(axis=1)]
    row, place = np.concatenate([row, lost]), np.concatenate([found, crest])
    mine = np.searchsorted(layers, layer)
    number = _nearest(mine, parameter, row, place)
    return Places(number=number, parameter=place[number], point=curve.points(place)[number])


def _nearest(group: NDArray[np.int64], value: Array, groups: NDArray[np.int64], places: Array) -> NDArray[np.int64]:
    """Of the places (m,) of its own group, the number of the one nearest to each value (n,)."""
    order = np.lexsort((places, groups))
    first = np.searchsorted(groups[order], group, side="left")
    last = np.searchsorted(groups[order], group, side="right") - 1
    low, high = places.min(), places.max()
    width = max(float(max(high, value.max()) - min(low, value.min())), 1e-300)
    keys = groups[order] * 4.0 * width + places[order]
    after = np.searchsorted(keys, group * 4.0 * width + value)
    before, after = np.clip(after - 1, first, last), np.clip(after, first, last)
    nearer = np.abs(places[order[before]] - value) <= np.abs(places[order[after]] - value)
    return order[np.where(nearer, before, after)]
