"""What a part looks like to a planner, before anything is planned.

In: a part, perhaps an axis. Out: an Inspection: axes, cylinders, radial range, overhangs, warnings.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from brep_slicer.errors import PlanningError
from brep_slicer.field import radial_gradient, radii_of
from brep_slicer.geometry import Face
from brep_slicer.part import Part, as_part
from brep_slicer.section import CutSolid, cut_solids
from brep_slicer.section.volume import closure_of
from brep_slicer.substrate.axis import Axis, as_axis, axis_candidates, describe_candidate
from brep_slicer.substrate.radius import CylinderCandidate, coaxial_cylinders, find_substrate
from brep_slicer.wording import counted, shortened

# A face overhangs where its outward normal points towards the axis by more than this (a slope of 1 degree).
OVERHANG = 0.0175
SAMPLES = 9


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Inspection:
    """A part's solids, axis, cylinders, substrate (or why there is none) and what to look out for."""

    source: str
    unit: str
    solids: tuple[dict[str, Any], ...]
    axis: Axis
    candidates: tuple[str, ...]
    cylinders: tuple[CylinderCandidate, ...]
    substrate_radius: float | None
    substrate_reason: str
    roles: str
    left_out: str
    overhang_share: float
    warnings: tuple[str, ...]

    def __repr__(self) -> str:
        on = "none" if self.substrate_radius is None else f"R {self.substrate_radius:.6g} mm"
        return (
            f"Inspection({shortened(self.source)!r}: {counted(len(self.solids), 'solid')}, {self.axis!r}, substrate {on},"
            f" {counted(len(self.cylinders), 'cylinder')}, {counted(len(self.warnings), 'warning')})"
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for --json."""
        return {
            "part": self.source,
            "unit_in_file": self.unit,
            "solids": list(self.solids),
            "axis": self.axis.as_dict(),
            "axis_candidates": list(self.candidates),
            "cylinders": [asdict(c) for c in self.cylinders],
            "substrate_radius_mm": self.substrate_radius,
            "substrate_reason": self.substrate_reason,
            "roles": self.roles,
            "left_out": self.left_out,
            "overhang_share": self.overhang_share,
            "warnings": list(self.warnings),
        }


def inspect_part(
    part: Any,
    *,
    axis: Any = None,
    substrate: float | None = None,
    build: Sequence[str | int] | None = None,
    stands: Sequence[str | int] | None = None,
) -> Inspection:
    """Look at a part as a planner would.

    Raises
    ------
    InputError
        If the part cannot be used.
    PlanningError
        If it has no axis, or several, and none is given.
    """
    part = as_part(part)
    candidates = axis_candidates(part)
    axis = as_axis(axis, part)
    solids = cut_solids(part, axis)
    reach = {s.index: s.critical.highest for s in solids}
    warnings = list(part.notes)
    radius, reason, roles, left_out = None, "", "", ""
    try:
        chosen = find_substrate(part, axis, reach=reach, radius=substrate, build=build, stands=stands)
        radius, reason, roles, left_out = chosen.radius, chosen.reason, chosen.roles, chosen.left_out
        warnings += chosen.warnings
    except PlanningError as error:
        reason = str(error)
    share = overhang_share(solids, radius or 0.0)
    if share > 0.0:
        warnings.append(f"{share:.1%} of the surface outside of the substrate overhangs (faces that look towards the axis)")
    return Inspection(
        source=part.source,
        unit=part.unit,
        solids=tuple(_described(part, s) for s in solids),
        axis=axis,
        candidates=tuple(describe_candidate(c) for c in candidates[:5]),
        cylinders=tuple(coaxial_cylinders(part, axis)),
        substrate_radius=radius,
        substrate_reason=reason,
        roles=roles,
        left_out=left_out,
        overhang_share=share,
        warnings=tuple(warnings),
    )


def _described(part: Part, solid: CutSolid) -> dict[str, Any]:
    from brep_slicer.kernel.revolutes import surface_kinds

    volume, uncertainty = measured_volume(solid)
    return {
        "index": solid.index,
        "name": solid.name,
        "volume_mm3": volume,
        "volume_uncertainty_mm3": uncertainty,
        "radial_range_mm": [solid.critical.lowest, solid.critical.highest],
        "faces": surface_kinds(solid.wrapped),
        "critical_radii": len(solid.critical.radii),
    }


def measured_volume(solid: CutSolid) -> tuple[float, float]:
    """A solid's volume by the surface integral, and how far it is uncertain, mm**3.

    Two quadratures tell what the integral is good for; by how far the faces fail to close, what the file is good for: where
    they gape, the volume depends on where it is measured from. (OCCT's quadrature was 4e-3 off on a worm, and does not say so.)
    """
    closure = closure_of(solid.brep)
    return closure.volume, closure.quadrature + closure.defect * abs(closure.volume)


def volume_text(volume: float, uncertainty: float) -> str:
    """A volume with the digits that it has, six at most, and what it is good for where that is fewer (mm**3)."""
    if uncertainty <= 1e-6 * abs(volume):
        return f"{volume:.6g} mm3"
    return f"{volume:.6g} mm3 (to {uncertainty:.1g})"


def overhang_share(solids: tuple[CutSolid, ...], beyond: float) -> float:
    """The share of the surface outside of radius `beyond` whose outward normal points towards the axis (by samples)."""
    total = hanging = 0.0
    for solid in solids:
        for face in solid.brep.faces:
            area, slope, rho = _sampled(face)
            outside = rho > beyond + 1e-6
            total += float(area[outside].sum())
            hanging += float(area[outside & (slope < -OVERHANG)].sum())
    return hanging / total if total > 0.0 else 0.0


def _sampled(face: Face) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Area weights, n . e_rho and rho at a grid of points over the face's box."""
    share = (np.arange(SAMPLES) + 0.5) / SAMPLES
    lines = [face.box[0, k] + share * (face.box[1, k] - face.box[0, k]) for k in (0, 1)]
    uv = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
    p, su, sv = face.surface.derivatives(uv)
    normal = face.sign * np.cross(su, sv)
    size = np.linalg.norm(normal, axis=1)
    slope = np.einsum("ij,ij->i", normal, radial_gradient(p)) / np.maximum(size, 1e-300)
    cell = float(np.prod((face.box[1] - face.box[0]) / SAMPLES))
    return size * cell, slope, radii_of(p)
