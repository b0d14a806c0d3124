"""One solid made ready for cutting: in the axis frame, its geometry in numpy, its critical radii.

In: a Solid and an Axis. Out: a CutSolid, computed once and used for every radius.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from brep_slicer.field import Critical, EdgeStretches, critical_radii, edge_stretches
from brep_slicer.geometry import Brep
from brep_slicer.geometry.gaps import edge_gaps
from brep_slicer.maps import Array
from brep_slicer.part import Part, Solid
from brep_slicer.substrate.axis import Axis


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class CutSolid:
    """A solid in the axis frame: the OCP solid `wrapped`, its `brep`, its edges' `stretches`, its `critical` radii.

    `gaps` (edges,) is how far each edge's curve and its faces lie apart in truth, mm: files understate it.
    """

    index: int
    name: str
    wrapped: Any
    brep: Brep
    stretches: EdgeStretches
    critical: Critical
    gaps: Array


def cut_solid(solid: Solid, axis: Axis) -> CutSolid:
    """Make one solid ready for cutting about `axis`."""
    from brep_slicer.kernel.brep import brep_from_solid
    from brep_slicer.kernel.shapes import transformed

    brep = brep_from_solid(solid.wrapped, axis.matrix)
    stretches = edge_stretches(brep)
    return CutSolid(
        index=solid.index,
        name=solid.name,
        wrapped=transformed(solid.wrapped, axis.matrix),
        brep=brep,
        stretches=stretches,
        critical=critical_radii(brep, stretches),
        gaps=edge_gaps(brep),
    )


def cut_solids(part: Part, axis: Axis) -> tuple[CutSolid, ...]:
    """Every solid of a part, made ready."""
    return tuple(cut_solid(solid, axis) for solid in part.solids)


def noise_of_outermost(solid: CutSolid) -> float:
    """How far (mm) a file leaves it open where its solid ends: the tolerance or gap of the edges that may be outermost."""
    edges = solid.brep.edges
    reach = np.where(np.isfinite(solid.stretches.edge_level), solid.stretches.edge_level, -np.inf)
    np.maximum.at(reach, solid.stretches.edge, solid.stretches.rho.max(axis=1))
    loose = np.maximum([edge.tolerance for edge in edges], solid.gaps)
    return float(loose[reach + loose >= solid.critical.highest].max(initial=0.0))
