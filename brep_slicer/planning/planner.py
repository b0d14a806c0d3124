"""The stages strung together: part and process in, layers, beads, toolpath and report out. No geometry here.

In: a part, a Process, what is known about axis and substrate. Out: a Plan.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from brep_slicer.errors import InputError, LayerError, PlanningError
from brep_slicer.fill import LayerFill, PatternChoice, fill_layer
from brep_slicer.part import Part, as_part
from brep_slicer.process import Process, choice, layer_range
from brep_slicer.region import FailedLayer, Layer, Region, features_of, slice_solids, slice_with_allowance
from brep_slicer.section import CutSolid, Engine, cut_solids
from brep_slicer.substrate.axis import Axis, as_axis
from brep_slicer.substrate.layers import LayerStack, stack_layers
from brep_slicer.substrate.radius import Substrate, find_substrate
from brep_slicer.toolpath import DepositLayer, Motion, Obstacles, Toolpath, lift_layers, obstacles_of
from brep_slicer.wording import counted, in_words_of_length, shortened

from .warnings import warnings_of

Progress = Callable[[int, int], None]
# More beads than this are a step-over in the wrong unit, and more than memory holds.
MOST_BEADS = 5e6
# A last layer that the part fills to less than this share may as well be left out.
THIN = 0.2


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan:
    """A planned part: what was read, what was chosen, the layers with their fills, the toolpath."""

    part: Part
    process: Process
    axis: Axis
    axis_was_given: bool
    substrate: Substrate
    stack: LayerStack
    highest: float
    layers: tuple[Layer | FailedLayer, ...]
    fills: tuple[LayerFill, ...]
    toolpath: Toolpath
    warnings: tuple[str, ...]
    _proven: list[dict[str, Any]] = field(init=False, repr=False, default_factory=list)

    def __repr__(self) -> str:
        laid = float(self.toolpath.segment_lengths()[self.toolpath.deposits].sum())
        failed = f" ({len(self.failed)} failed)" if self.failed else ""
        beads = counted(sum(len(fill.beads) for fill in self.fills), "bead")
        return (
            f"Plan({shortened(self.part.source)!r}: {counted(len(self.layers), 'layer')}{failed} on R"
            f" {self.substrate.radius:.6g} mm, {beads}, {in_words_of_length(laid)}, {counted(len(self.warnings), 'warning')})"
        )

    @property
    def failed(self) -> tuple[FailedLayer, ...]:
        """Layers that could not be cut with certainty."""
        return tuple(layer for layer in self.layers if isinstance(layer, FailedLayer))

    def proof(self, progress: Progress | None = None) -> list[dict[str, Any]]:
        """How even the metal is, a row a layer: coverage, simulated deposit, step-over on the emitted points, duty.

        It is worked out once; `progress` is called with (layers done, layers in all).
        """
        if not self._proven:
            from brep_slicer.proof import proof_of_layers

            whole = [(layer, fill) for layer, fill in zip(self.layers, self.fills, strict=True) if isinstance(layer, Layer)]
            width, step_over = self.process.width, self.process.step_over
            self._proven.extend(
                proof_of_layers(whole, self.toolpath, self.axis, width=width, step_over=step_over, progress=progress)
            )
        return list(self._proven)

    def report(self) -> dict[str, Any]:
        """Everything that report.json says, as plain values."""
        from brep_slicer.output.report import report_of_plan

        return report_of_plan(self)


def plan(
    part: Any,
    process: Process,
    *,
    axis: Any = None,
    substrate: float | None = None,
    substrate_solids: Sequence[int] | None = None,
    layers: tuple[int | None, int | None] | str | None = None,
    engine: Engine | str = Engine.ANALYTIC,
    pattern: PatternChoice | None = None,
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
    substrate_solids : sequence of int, optional
        Indices of the solids that stand already.
    layers : (first, past the last) or a text "a:b", optional
        Plan only these layers; they keep their numbers.
    engine : Engine or str
        How sections are cut.
    pattern : callable, optional
        Given a layer's number and a piece, the Pattern to fill it with; by default the process's for every piece.
    progress : callable, optional
        Called with (layers done, layers in all).

    Returns
    -------
    Plan
        With failed layers, if any, in `failed`; they have no beads.

    Raises
    ------
    InputError
        If a value does not suit the part.
    PlanningError
        If there is no axis, no substrate, no layer, or no metal in a layer.
    """
    cutter = choice("engine", engine, Engine)
    asked = (None, None) if layers is None else layer_range("layers", layers)
    part = as_part(part)
    given = axis is not None
    axis = as_axis(axis, part)
    solids = cut_solids(part, axis)
    reach = {s.index: s.critical.highest for s in solids}
    chosen = find_substrate(part, axis, reach=reach, radius=substrate, solids=substrate_solids)
    features = [r for i, r in reach.items() if i not in chosen.solids]
    if not features or max(features) <= chosen.radius:
        raise PlanningError(f"{part.source}: nothing stands beyond the substrate, R {chosen.radius:.6g} mm; give a smaller one")
    highest = max(features) + process.allowance
    _check_step_over(part, process, highest)
    stack = stack_layers(chosen.radius, highest, process)
    numbers = _chosen_layers(part, len(stack.radii), asked)
    cut = _cut(solids, stack, numbers, chosen, process, cutter, progress)
    if all(not isinstance(layer, FailedLayer) and layer.region.is_empty for layer in cut):
        raise PlanningError(
            f"{part.source}: no layer meets any metal outside of R {chosen.radius:.6g} mm; check axis and substrate"
        )
    fills = _fills(part, process, cut, pattern)
    standing = _standing(part, axis, [s for s in solids if s.index in chosen.solids], chosen.radius)
    toolpath = lift_layers(_deposits(cut, fills, stack, process.by_feature), motion_of(process), axis, standing)
    notes = [*part.notes, *chosen.warnings, *stack.notes, *_unplanned(part)]
    return Plan(
        part=part,
        process=process,
        axis=axis,
        axis_was_given=given,
        substrate=chosen,
        stack=stack,
        highest=highest,
        layers=cut,
        fills=fills,
        toolpath=toolpath,
        warnings=(*notes, *warnings_of(cut, fills, process)),
    )


def _standing(part: Part, axis: Axis, solids: Sequence[CutSolid], radius: float) -> Obstacles:
    """What no travel goes through: the solids that stand, and those of the file that were not chosen to be built."""
    others = cut_solids(replace(part, solids=part.others), axis)
    return obstacles_of([s.brep for s in (*solids, *others)], radius)


def _unplanned(part: Part) -> list[str]:
    if not part.others:
        return []
    names = ", ".join(f"{s.index} ({s.name})" for s in part.others)
    return [f"solids that were not chosen are taken to stand, as obstacles to travels, and not to be built: {names}"]


def _check_step_over(part: Part, process: Process, highest: float) -> None:
    if process.step_over > 2.0 * highest:
        raise InputError(
            f"{part.source}: step-over {process.step_over:g} mm is larger than the part (R {highest:.6g} mm); make it smaller"
        )


def _check_number_of_beads(part: Part, process: Process, layers: Sequence[Layer | FailedLayer]) -> None:
    """At least as many as fit side by side across each piece's narrower extent."""
    boxes = np.array([p.bounds() for layer in layers if isinstance(layer, Layer) for p in layer.region.pieces]).reshape(-1, 4)
    count = float((boxes[:, 2:] - boxes[:, :2]).min(axis=1).sum()) / process.step_over
    if count > MOST_BEADS:
        raise InputError(
            f"{part.source}: at a step-over of {process.step_over:g} mm the layers take {count:.2g} beads or more; make it"
            " larger (-d), or plan fewer layers at once (--layers)"
        )


def _check_beads(part: Part, process: Process, layers: Sequence[Layer | FailedLayer], fills: Sequence[LayerFill]) -> None:
    if any(fill.beads for fill in fills) or all(isinstance(layer, FailedLayer) for layer in layers):
        return
    raise PlanningError(
        f"{part.source}: no bead fits into any layer, {process.value('inset'):.4g} mm inside of its outline; make the bead"
        " narrower (-w), the inset smaller (--inset) or the step-over smaller (-d)"
    )


def _cut(
    solids: Sequence[CutSolid],
    stack: LayerStack,
    numbers: Sequence[int],
    substrate: Substrate,
    process: Process,
    engine: Engine,
    progress: Progress | None,
) -> tuple[Layer | FailedLayer, ...]:
    done = (lambda i: progress(i + 1, len(numbers))) if progress is not None else None
    radii = [stack.cut_radii[i] for i in numbers]
    sliced = (
        slice_with_allowance(
            solids,
            radii,
            allowance=process.allowance,
            lowest=substrate.radius,
            chord=process.value("chord"),
            engine=engine,
            substrate_solids=substrate.solids,
            progress=done,
        )
        if process.allowance
        else slice_solids(solids, radii, engine=engine, substrate_solids=substrate.solids, progress=done)
    )
    out: list[Layer | FailedLayer] = []
    for i, layer in zip(numbers, sliced, strict=True):
        radius = stack.radii[i]
        layer = replace(layer, index=i, radius=radius, thickness=stack.thicknesses[i])
        if isinstance(layer, Layer):
            # cut elsewhere in its thickness: theta kept, kappa rescaled to the surface that is deposited on
            layer = replace(layer, region=layer.region.on_radius(radius))
        out.append(layer)
    return tuple(out)


def _fills(
    part: Part, process: Process, layers: Sequence[Layer | FailedLayer], pattern: PatternChoice | None
) -> tuple[LayerFill, ...]:
    """Every layer's beads; neither too many nor none at all."""
    _check_number_of_beads(part, process, layers)
    fills = tuple(LayerFill(beads=()) if isinstance(x, FailedLayer) else fill_layer(x, process, pattern) for x in layers)
    _check_beads(part, process, layers, fills)
    return fills


def _deposits(
    layers: Sequence[Layer | FailedLayer], fills: Sequence[LayerFill], stack: LayerStack, by_feature: bool
) -> list[DepositLayer]:
    """The beads in the order of deposition: layer by layer, or one feature after the other."""
    made = [
        DepositLayer(index=layer.index, radius=layer.radius, thickness=stack.thicknesses[layer.index], beads=fill.beads)
        for layer, fill in zip(layers, fills, strict=True)
    ]
    if not by_feature:
        return made
    whole = [layer.region if isinstance(layer, Layer) else Region(radius=layer.radius) for layer in layers]
    features = features_of(whole)
    count = 1 + max((n for numbers in features for n in numbers), default=-1)
    parts = [
        replace(layer, beads=tuple(bead for bead in layer.beads if numbers[bead.piece] == feature))
        for feature in range(count)
        for layer, numbers in zip(made, features, strict=True)
    ]
    return [part for part in parts if part.beads]


def motion_of(process: Process) -> Motion:
    """Speeds and distances of the nozzle's motion."""
    return Motion(
        deposition_speed=process.value("deposition_speed_mm_s"),
        travel_speed=process.value("travel_speed_mm_s"),
        clearance=process.value("clearance"),
        hop_length=process.value("hop_length"),
        chord=process.value("chord"),
        margin=0.5 * process.width,
        lead_in=process.lead_in,
        lead_out=process.lead_out,
        laser_on_delay=process.laser_on_delay,
        laser_off_delay=process.laser_off_delay,
    )


def _chosen_layers(part: Part, count: int, asked: tuple[int | None, int | None]) -> range:
    numbers = range(count)[slice(*asked)]
    if not numbers:
        text = ":".join("" if x is None else str(x) for x in asked)
        raise InputError(f"{part.source}: layers {text} are none of the {count} layers; give a:b within 0:{count}")
    return numbers


def check_complete(made: Plan) -> None:
    """Raise a LayerError if any layer of a plan failed."""
    if made.failed:
        first = made.failed[0]
        # a last layer that is but a sliver of one, cut where the part ends
        thickness = made.stack.thicknesses[-1]
        sliver = first.index == len(made.stack.radii) - 1 and thickness - made.stack.overshoot < THIN * thickness
        remedy = "--last-layer drop leaves it out" if sliver else "--allow-failed plans the others"
        raise LayerError(
            f"{made.part.source}: {len(made.failed)} of {len(made.layers)} layers failed, first layer {first.index}"
            f" (R {first.radius:.6g} mm): {first.reason}; {remedy}"
        )
