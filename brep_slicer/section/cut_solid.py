"""One solid made ready for cutting: in the axis frame, its geometry in numpy, its critical levels.

In: a Solid, an Axis, a family of layers. Out: a CutSolid, computed once and used for every level.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from brep_slicer.field import Critical, EdgeStretches, critical_radii, edge_stretches
from brep_slicer.geometry import Brep
from brep_slicer.geometry.gaps import edge_gaps
from brep_slicer.layers import CYLINDERS, LayerFamily
from brep_slicer.maps import Array
from brep_slicer.part import Part, Solid
from brep_slicer.substrate.axis import Axis

# A solid so many times its own size from the axis's origin is brought near before it is read: it has lost two digits there.
FAR = 100.0
# What a coordinate in a file is good for, as a share of the distance from its origin: some units in the last place.
NOISE = 1e-15


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CutSolid:
    """A solid in the axis frame moved down by `brep.lift`: the OCP solid `wrapped`, its `brep`.

    Its edges' `stretches`, its `critical` levels in a `family` of layers.

    `gaps` (edges,) is how far each edge's curve and its faces lie apart in truth, mm: files understate it.
    """

    index: int
    name: str
    wrapped: Any
    brep: Brep
    stretches: EdgeStretches
    critical: Critical
    gaps: Array
    family: LayerFamily = CYLINDERS


def cut_solid(solid: Solid, axis: Axis, family: LayerFamily = CYLINDERS) -> CutSolid:
    """Make one solid ready for cutting about `axis`."""
    from brep_slicer.kernel.brep import brep_from_solid
    from brep_slicer.kernel.facets import corners_of
    from brep_slicer.kernel.shapes import into_frame

    corners = corners_of(solid.wrapped)
    # a cylinder's level does not depend on where along the axis the part lies
    lift = _lift(axis.axis_from_file(corners)) if family == CYLINDERS else 0.0
    moved = into_frame(solid.wrapped, axis.origin + lift * axis.direction, axis.rotation)
    brep = brep_from_solid(moved, lift, NOISE * float(np.abs(corners).max(initial=0.0)))
    stretches = edge_stretches(brep, family)
    return CutSolid(
        index=solid.index,
        name=solid.name,
        wrapped=moved,
        brep=brep,
        stretches=stretches,
        critical=critical_radii(brep, stretches, family),
        gaps=edge_gaps(brep),
        family=family,
    )


def _lift(corners: Array) -> float:
    """How far along the axis (whole mm) the solid with these corners (n, 3) is brought near before it is read; 0 if it is."""
    if not len(corners):
        return 0.0
    low, high = float(corners[:, 2].min()), float(corners[:, 2].max())
    middle = 0.5 * (low + high)
    size = max(high - low, float(np.hypot(corners[:, 0], corners[:, 1]).max()))
    return float(round(middle)) if abs(middle) > FAR * size else 0.0


def cut_solids(part: Part, axis: Axis, family: LayerFamily = CYLINDERS) -> tuple[CutSolid, ...]:
    """Every solid of a part, made ready."""
    return tuple(cut_solid(solid, axis, family) for solid in part.solids)


def noise_of_outermost(solid: CutSolid) -> float:
    """How far (mm) a file leaves it open where its solid ends: the tolerance or gap of the edges that may be outermost."""
    edges = solid.brep.edges
    reach = np.where(np.isfinite(solid.stretches.edge_level), solid.stretches.edge_level, -np.inf)
    np.maximum.at(reach, solid.stretches.edge, solid.stretches.rho.max(axis=1))
    loose = np.maximum([edge.tolerance for edge in edges], solid.gaps)
    return float(loose[reach + loose >= solid.critical.highest].max(initial=0.0))
