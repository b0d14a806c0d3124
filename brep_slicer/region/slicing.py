"""A part cut at given levels: every solid by itself, the sections joined in the plane.

In: a part, levels (radii, on cylinders), an axis. Out: one Layer or FailedLayer per level.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, LayerError
from brep_slicer.layers import CYLINDERS, LayerFamily, Sheet
from brep_slicer.maps import Array
from brep_slicer.part import as_part
from brep_slicer.process import check_levels, check_radii, choice
from brep_slicer.section import Certificate, CutSolid, Engine, cut_solids
from brep_slicer.section.boolean import COINCIDENCE_STEP, COINCIDENT
from brep_slicer.section.certificate import LARGEST_ERROR
from brep_slicer.section.engines import SolidSections
from brep_slicer.section.stepped import moved_by_step
from brep_slicer.substrate.axis import as_axis

from .layer import FailedLayer, Layer
from .overlay import difference_of_regions, union_of_regions
from .region import Region, region_from_loops

Section = tuple[Region, Certificate] | LayerError
# Outlines of neighbours that were cut at one radius fit within this, mm; one that has been moved farther leaves a slit.
FITS = 1e-5


def slice_part(
    part: Any,
    radii: Sequence[float],
    *,
    axis: Any = None,
    engine: Engine | str = Engine.ANALYTIC,
    substrate_solids: Sequence[int] = (),
    family: LayerFamily = CYLINDERS,
) -> list[Layer | FailedLayer]:
    """Cut a part with coaxial cylinders, or with the layers of another family.

    Parameters
    ----------
    part
        A Part, or anything that `as_part` takes.
    radii : sequence of float
        Increasing radii, mm; of another family its levels c.
    axis : optional
        An Axis, a text, or a host's line, plane or vector, as `as_axis` takes them; found by `find_axis` if not given.
    engine : Engine or str
        ANALYTIC (level sets of rho, exact; falls back to the other where its certificate fails) or BOOLEAN (OCCT).
    substrate_solids : sequence of int
        Indices of solids that are built upon: their sections are taken away from those of the others.
    family : LayerFamily
        Cylinders(), Cones(half_angle_deg) or Planes(normal), about the axis and in its frame. Layers that are no cylinders are
        cut by the analytic engine only.

    Returns
    -------
    list of Layer or FailedLayer
        One per radius; a radius that meets no metal gives an empty Layer.

    Raises
    ------
    InputError
        If the part or a radius cannot be used.
    PlanningError
        If the part has no axis, or several.
    """
    checked = check_radii(radii) if family == CYLINDERS else check_levels(radii)
    cutter = choice("engine", engine, Engine)
    if family != CYLINDERS and cutter is not Engine.ANALYTIC:
        raise InputError(f"layers that are {family.name} are cut by the analytic engine, not by {cutter.value}")
    part = as_part(part)
    axis = as_axis(axis, part)
    unknown = set(substrate_solids) - {s.index for s in part.solids}
    if unknown:
        raise InputError(f"{part.source}: there is no solid {min(unknown)} to be the substrate")
    solids = cut_solids(part, axis, family)
    return slice_solids(solids, checked, engine=cutter, substrate_solids=substrate_solids)


def slice_solids(
    solids: Sequence[CutSolid],
    radii: Sequence[float],
    *,
    engine: Engine = Engine.ANALYTIC,
    substrate_solids: Sequence[int] = (),
    progress: Callable[[int], None] | None = None,
) -> list[Layer | FailedLayer]:
    """`slice_part` for solids that are ready; `progress` is called with the number of each finished layer."""
    ahead = {s.index: SolidSections(s, radii, engine) for s in solids}
    family = solids[0].family if solids else CYLINDERS
    out: list[Layer | FailedLayer] = []
    for i, radius in enumerate(radii):
        sections = {s.index: _section(ahead[s.index], i) for s in solids}
        if len(solids) > 1:
            meeting = _meeting_stepped(sections, [n for n in sections if _changes(ahead[n].solid, radius)])
            sections |= _side_by_side({n: ahead[n] for n in meeting}, radius)
        out.append(_layer(i, family.sheet(float(radius)), sections, set(substrate_solids)))
        if progress is not None:
            progress(i)
    return out


def _section(sections: SolidSections, i: int) -> Section:
    """A solid's section at level number i as a region; a region that the loops do not make sends the layer to the fallback."""
    loops = sections.section(i)
    sheet = sections.solid.family.sheet(float(sections.radii[i]))
    if isinstance(loops, LayerError):
        return loops
    try:
        return region_from_loops(sheet, loops[0]), loops[1]
    except LayerError as error:
        if loops[1].fallback or loops[1].engine is Engine.BOOLEAN:
            return error
        second = sections.fallback(i, str(error))
    try:
        return second if isinstance(second, LayerError) else (region_from_loops(sheet, second[0]), second[1])
    except LayerError as error:
        return error


def _stepped(section: Section) -> bool:
    """Whether a solid was cut so far beside its radius that its outline no longer fits to those of its neighbours."""
    return not isinstance(section, LayerError) and bool(section[1].fallback) and section[1].residual > FITS


def _changes(solid: CutSolid, radius: float) -> bool:
    """Whether a solid may have other pieces where its neighbours are cut beside the radius: it begins or ends in between."""
    critical = solid.critical.radii
    return bool(np.any((critical > radius - COINCIDENT) & (critical <= radius + 2.0 * COINCIDENCE_STEP)))


def _meeting_stepped(sections: dict[int, Section], changing: Sequence[int] = ()) -> list[int]:
    """Solids that were cut beside their radius and those whose outlines they may meet, and so on, by boxes of their pieces.

    Those that are `changing` just outside of it may meet any.
    """
    stepped = [n for n, section in sections.items() if _stepped(section)]
    boxes = {n: _boxes(section) for n, section in sections.items() if not isinstance(section, LayerError)} if stepped else {}
    found: set[int] = set()
    new = {*stepped, *changing} & boxes.keys()
    while new:
        found |= new
        new = {n for n in boxes.keys() - found if any(_meet(boxes[n], boxes[m]) for m in new)}
    return sorted(found) if len(found) > 1 else []


def _boxes(section: tuple[Region, Certificate]) -> Array:
    """(n, 4) boxes of a region's pieces, mm, wider by what its outline may be off by, a turn to either side too."""
    region, certificate = section
    wide = certificate.bound + FITS
    boxes = np.array([piece.bounds() for piece in region.pieces]).reshape(-1, 4) + wide * np.array([-1.0, -1.0, 1.0, 1.0])
    corners = boxes.reshape(-1, 2, 2)
    return np.concatenate([region.closure.moved(corners, turns).reshape(-1, 4) for turns in region.closure.beside])


def _meet(one: Array, other: Array) -> bool:
    """Whether any box of one meets any of the other."""
    a, b = one[:, None], other[None]
    return bool(np.any((a[..., :2] <= b[..., 2:]).all(axis=-1) & (b[..., :2] <= a[..., 2:]).all(axis=-1)))


def _side_by_side(solids: dict[int, SolidSections], radius: float) -> dict[int, Section]:
    """Solids cut at one radius a step farther out, drawn on `radius`; none if one of them cannot be, or moves too far."""
    out: dict[int, Section] = {}
    for index, solid in solids.items():
        sheet = solid.solid.family.sheet(radius)
        near, far = (_section(solid.beside(radius + k * COINCIDENCE_STEP), 0) for k in (1.0, 2.0))
        if isinstance(near, LayerError) or isinstance(far, LayerError) or _stepped(near):
            return {}
        region, beyond = near[0].on_sheet(sheet), far[0].on_sheet(sheet)
        moved = moved_by_step(region.loops, beyond.loops, (1.0, 2.0))
        reason = near[1].fallback or "a neighbour was cut beside its radius"
        certificate = replace(near[1], residual=max(near[1].residual, moved), fallback=reason, coincident=True)
        if certificate.bound > LARGEST_ERROR:
            return {}
        out[index] = region, certificate
    return out


def _layer(index: int, sheet: Sheet, sections: dict[int, Section], substrate: set[int]) -> Layer | FailedLayer:
    several = len(sections) > 1
    failed = [f"solid {n}: {s}" if several else str(s) for n, s in sections.items() if isinstance(s, LayerError)]
    reason = "; ".join(failed)
    if not failed:
        try:
            return _joined(index, sheet, sections, substrate)  # type: ignore[arg-type]
        except LayerError as error:
            reason = str(error)
    level = sheet.level
    return FailedLayer(index=index, level=level, cut_level=level, thickness=None, reason=reason, family=sheet.family)


def _joined(index: int, sheet: Sheet, sections: dict[int, tuple[Region, Certificate]], substrate: set[int]) -> Layer:
    features = [region for i, (region, _) in sections.items() if i not in substrate]
    standing = [region for i, (region, _) in sections.items() if i in substrate]
    region = union_of_regions(sheet, features)
    for other in standing:
        region = difference_of_regions(region, other)
    certificate = _merged({i: c for i, (_, c) in sections.items()})
    if region.touch > 0.0:
        jog = max((loop.jog() for loop in region.loops), default=0.0)
        certificate = replace(
            certificate,
            residual=max(certificate.residual, region.touch),
            jog=max(certificate.jog, jog),
            checks={**certificate.checks, "solids_joined_within_mm": region.touch},
        )
    return Layer(
        index=index,
        level=sheet.level,
        cut_level=sheet.level,
        thickness=None,
        region=region,
        area=region.area,
        certificate=certificate,
    )


def _merged(by_solid: dict[int, Certificate]) -> Certificate:
    """One certificate for several solids, by their numbers: the worst of each figure."""
    certificates = list(by_solid.values())
    if len(certificates) == 1:
        return certificates[0]
    engines = {c.engine for c in certificates}
    checks = {f"{k}@{i}": v for i, c in by_solid.items() for k, v in c.checks.items()}
    return Certificate(
        engine=Engine.BOOLEAN if Engine.BOOLEAN in engines else Engine.ANALYTIC,
        residual=float(np.max([c.residual for c in certificates])),
        jog=float(np.max([c.jog for c in certificates])),
        contradiction=float(np.max([c.contradiction for c in certificates])),
        checks=checks,
        fallback="; ".join(f"solid {i}: {c.fallback}" for i, c in by_solid.items() if c.fallback),
        coincident=any(c.coincident for c in certificates),
    )
