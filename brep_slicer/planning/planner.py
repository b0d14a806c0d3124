"""The stages strung together: part and process in, layers, beads, toolpath and report out. No geometry here.

In: a part, a Process, what is known about axis and substrate. Out: a Plan.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, PlanningError
from brep_slicer.fill import LayerFill, PatternChoice, fill_layer
from brep_slicer.process import Process
from brep_slicer.region import Layer, features_of
from brep_slicer.section import Engine, cut_solids
from brep_slicer.toolpath import DepositLayer, Motion, Obstacles, lift_layers, obstacles_of

from .planned import Plan, PlanSections, Progress
from .sections import check_complete, cut_layers
from .warnings import notices_of_fills

# More beads than this are a step-over in the wrong unit, and more than memory holds.
MOST_BEADS = 5e6


def plan(
    part: Any,
    process: Process,
    *,
    axis: Any = None,
    substrate: float | None = None,
    build: Sequence[str | int] | None = None,
    stands: Sequence[str | int] | None = None,
    layers: tuple[int | None, int | None] | str | None = None,
    engine: Engine | str = Engine.ANALYTIC,
    pattern: PatternChoice | None = None,
    allow_failed: bool = False,
    progress: Progress | None = None,
) -> Plan:
    """Plan the deposition of a part.

    Parameters
    ----------
    part
        A Part, or anything that `as_part` takes.
    process : Process
        Layer thickness, step-over and the rest.
    axis : optional
        An Axis, a text as `axis_from_text` reads it, or a host's line, plane or vector (see `as_axis`); found by a vote of the
        faces if not given.
    substrate : float, optional
        Radius (mm) to build on; by default the rule of `find_substrate`.
    build, stands : sequence of str or int, optional
        Names or indices of solids that are to be built, or that stand already; the others' roles follow from how they touch
        (`substrate.roles`), and the plan says which they are.
    layers : (first, past the last) or a text "a:b", optional
        Plan only these layers; they keep their numbers.
    engine : Engine or str
        How sections are cut.
    pattern : callable, optional
        Given a layer's number and a piece, the Pattern to fill it with; by default the process's for every piece.
    allow_failed : bool
        Plan the other layers where some cannot be cut with certainty.
    progress : callable, optional
        Called with (layers cut, layers in all).

    Returns
    -------
    Plan
        With failed layers, if any and allowed, in `failed`; they have no beads.

    Raises
    ------
    InputError
        If a value does not suit the part.
    PlanningError
        If there is no axis, no substrate, no layer, or no metal in a layer.
    LayerError
        If some layer cannot be cut with certainty and `allow_failed` is not set: before anything is filled, with the failed
        layers in its `failed`.
    """
    sections = cut_layers(
        part,
        process,
        axis=axis,
        substrate=substrate,
        build=build,
        stands=stands,
        layers=layers,
        engine=engine,
        progress=progress,
    )
    if not allow_failed:
        check_complete(sections)
    return fill_layers(sections, pattern=pattern)


def fill_layers(sections: PlanSections, *, pattern: PatternChoice | None = None, progress: Progress | None = None) -> Plan:
    """The plan of sections: beads and toolpath of all layers that did not fail; `progress` counts the layers filled.

    Raises
    ------
    InputError, PlanningError
        If the beads are too many, or none fits.
    """
    process = sections.process
    _check_number_of_beads(sections)
    fills = []
    for layer in sections.layers:
        fills.append(fill_layer(layer, process, pattern))
        if progress is not None:
            progress(len(fills), len(sections.layers))
    _check_beads(sections, fills)
    deposits = _deposits(sections.layers, fills, process.fill.by_feature)
    toolpath = lift_layers(deposits, motion_of(process), sections.axis, _standing(sections))
    inherited = {f.name: getattr(sections, f.name) for f in fields(PlanSections)}
    inherited["notices"] = (*sections.notices, *notices_of_fills(sections.layers, fills, process))
    return Plan(**inherited, fills=tuple(fills), toolpath=toolpath)


def _standing(sections: PlanSections) -> Obstacles:
    """What no travel goes through: the solids that stand, and those of the file that were not chosen to be built."""
    part, substrate = sections.part, sections.substrate
    others = cut_solids(replace(part, solids=part.others), sections.axis)
    standing = [s for s in sections.solids if s.index in (*substrate.solids, *substrate.alone)]
    whole = obstacles_of([s.brep for s in (*standing, *others)], substrate.radius)
    if not substrate.zones:
        return whole
    collars = obstacles_of([s.brep for s in sections.solids if s.index in substrate.built], substrate.radius)
    return whole.joined(collars.within(substrate.zones))


def _check_number_of_beads(sections: PlanSections) -> None:
    """At least as many as fit side by side across each piece's narrower extent."""
    step_over = sections.process.step_over
    boxes = np.array([p.bounds() for layer in sections.layers for p in layer.region.pieces]).reshape(-1, 4)
    count = float((boxes[:, 2:] - boxes[:, :2]).min(axis=1).sum()) / step_over
    if count > MOST_BEADS:
        raise InputError(
            f"{sections.part.source}: at a step-over of {step_over:g} mm the layers take {count:.2g} beads or more; make it"
            " larger (-d), or plan fewer layers at once (--layers)"
        )


def _check_beads(sections: PlanSections, fills: Sequence[LayerFill]) -> None:
    if any(fill.beads for fill in fills) or not sections.layers:
        return
    raise PlanningError(
        f"{sections.part.source}: no bead fits into any layer, {sections.process.inset:.4g} mm inside of its outline;"
        " make the bead narrower (-w), the inset smaller (--inset) or the step-over smaller (-d)"
    )


def _deposits(layers: Sequence[Layer], fills: Sequence[LayerFill], by_feature: bool) -> list[DepositLayer]:
    """The beads in the order of deposition: layer by layer, or one feature after the other."""
    made = [
        DepositLayer(index=layer.index, radius=layer.radius, thickness=layer.thickness or 0.0, beads=fill.beads)
        for layer, fill in zip(layers, fills, strict=True)
    ]
    if not by_feature:
        return made
    features = features_of([layer.region for layer in layers])
    count = 1 + max((n for numbers in features for n in numbers), default=-1)
    parts = []
    for feature in range(count):
        for layer, pieces in zip(made, features, strict=True):
            mine = tuple(k for k, bead in enumerate(layer.beads) if pieces[bead.piece] == feature)
            parts.append(replace(layer, beads=tuple(layer.beads[k] for k in mine), numbers=mine))
    return [part for part in parts if part.beads]


def motion_of(process: Process) -> Motion:
    """Speeds and distances of the nozzle's motion."""
    return Motion(
        deposition_speed=process.deposition_speed,
        travel_speed=process.travel_speed,
        clearance=process.clearance,
        hop_length=process.hop_length,
        chord=process.chord,
        margin=0.5 * process.width,
        lead_in=process.motion.lead_in,
        lead_out=process.motion.lead_out,
        laser_on_delay=process.laser.on_delay,
        laser_off_delay=process.laser.off_delay,
    )
