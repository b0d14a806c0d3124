"""The first half of planning: a part and a process to layers that are cut and judged, before anything is filled.

In: a part, a Process, what is known about axis and substrate. Out: PlanSections, with the layers that failed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from brep_slicer.errors import InputError, LayerError, PlanningError
from brep_slicer.layers import cylinder
from brep_slicer.notices import Notice, NoticeKind, grouped
from brep_slicer.part import Part, as_part
from brep_slicer.process import Process, choice, layer_range
from brep_slicer.region import FailedLayer, Layer, outside_of_zones, slice_solids, slice_with_allowance
from brep_slicer.section import CutSolid, Engine, cut_solids, noise_of_outermost, reach_of_faces
from brep_slicer.substrate.axis import as_axis
from brep_slicer.substrate.layers import LayerStack, stack_layers
from brep_slicer.substrate.radius import Substrate, find_substrate

from .planned import PlanSections, Progress
from .support import CutLayer, notices_of_support
from .warnings import notices_of_sections

# A last layer that the part fills to less than this share may as well be left out.
THIN = 0.2


def cut_layers(
    part: Any,
    process: Process,
    *,
    axis: Any = None,
    substrate: float | None = None,
    build: Sequence[str | int] | None = None,
    stands: Sequence[str | int] | None = None,
    layers: tuple[int | None, int | None] | str | None = None,
    engine: Engine | str = Engine.ANALYTIC,
    progress: Progress | None = None,
) -> PlanSections:
    """Cut a part into its layers, and judge them: parameters and errors as of `plan`, but for layers that fail.

    Returns
    -------
    PlanSections
        With failed layers, if any, in `failed`.
    """
    cutter = choice("engine", engine, Engine)
    asked = (None, None) if layers is None else layer_range("layers", layers)
    part = as_part(part)
    given = axis is not None
    axis = as_axis(axis, part)
    solids = cut_solids(part, axis)
    reach = {s.index: s.critical.highest for s in solids}
    chosen = find_substrate(part, axis, reach=reach, radius=substrate, build=build, stands=stands)
    features = {s.index: _reach_of_features(s, chosen) for s in solids if s.index in chosen.built}
    outermost = max(features.values(), default=0.0)
    if outermost <= chosen.radius:
        raise PlanningError(f"{part.source}: nothing stands beyond the substrate, R {chosen.radius:.6g} mm; give a smaller one")
    highest = outermost + process.layers.allowance
    _check_step_over(part, process, highest)
    noise = max(noise_of_outermost(s) for s in solids if features.get(s.index) == outermost)
    stack = stack_layers(chosen.radius, highest, process, noise=noise)
    numbers = _chosen_layers(part, len(stack.radii), asked)
    cuttable = [s for s in solids if s.index not in chosen.alone]
    cut = _cut(cuttable, stack, numbers, chosen, process, cutter, progress)
    made = PlanSections(
        part=part,
        process=process,
        axis=axis,
        axis_was_given=given,
        substrate=chosen,
        stack=stack,
        highest=highest,
        solids=solids,
        layers=tuple(layer for layer in cut if isinstance(layer, Layer)),
        failed=tuple(layer for layer in cut if isinstance(layer, FailedLayer)),
        notices=tuple(_of_the_part(part, chosen, stack)),
    )
    return _judged(made, cutter, lambda number: _cut(cuttable, stack, [number], chosen, process, cutter, None)[0])


def _judged(sections: PlanSections, engine: Engine, cut: CutLayer) -> PlanSections:
    """Sections with what there is to say of their layers; an error if there is no metal at all."""
    layers, failed = sections.layers, sections.failed
    if not failed and all(layer.region.is_empty for layer in layers):
        raise PlanningError(
            f"{sections.part.source}: no layer meets any metal outside of R {sections.substrate.radius:.6g} mm; check axis and"
            " substrate"
        )
    notices = [
        *sections.notices,
        *notices_of_sections(layers, failed, sections.process),
        *notices_of_support(sections, engine=engine, cut=cut),
    ]
    return replace(sections, notices=grouped(notices))


def _reach_of_features(solid: CutSolid, substrate: Substrate) -> float:
    """How far out what is built of a solid reaches, mm: all of it, or what is outside of the zones that stand."""
    if not substrate.zones:
        return solid.critical.highest
    return reach_of_faces(solid, [face for index, face in substrate.built_faces if index == solid.index])


def _of_the_part(part: Part, substrate: Substrate, stack: LayerStack) -> list[Notice]:
    """What reading the part, choosing its substrate and stacking its layers gave to say."""
    said = (
        (NoticeKind.PART, part.notes),
        (NoticeKind.SUBSTRATE, substrate.warnings),
        (NoticeKind.STACK, stack.notes),
        (NoticeKind.PART, _unplanned(part)),
    )
    return [Notice(kind=kind, text=text) for kind, texts in said for text in texts]


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


def _chosen_layers(part: Part, count: int, asked: tuple[int | None, int | None]) -> range:
    numbers = range(count)[slice(*asked)]
    if not numbers:
        text = ":".join("" if x is None else str(x) for x in asked)
        raise InputError(f"{part.source}: layers {text} are none of the {count} layers; give a:b within 0:{count}")
    return numbers


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
            allowance=process.layers.allowance,
            lowest=substrate.radius,
            chord=process.chord,
            engine=engine,
            substrate_solids=substrate.solids,
            progress=done,
        )
        if process.layers.allowance
        else slice_solids(solids, radii, engine=engine, substrate_solids=substrate.solids, progress=done)
    )
    out: list[Layer | FailedLayer] = []
    for i, layer in zip(numbers, sliced, strict=True):
        radius = stack.radii[i]
        layer = replace(layer, index=i, level=radius, thickness=stack.thicknesses[i])
        if isinstance(layer, Layer) and substrate.zones:
            layer = _without_zones(layer, substrate)
        if isinstance(layer, Layer):
            # cut elsewhere in its thickness: theta kept, kappa rescaled to the surface that is deposited on
            layer = replace(layer, region=layer.region.on_sheet(cylinder(radius)))
        out.append(layer)
    return tuple(out)


def _without_zones(layer: Layer, substrate: Substrate) -> Layer | FailedLayer:
    """A layer without the collars and flanges that stand."""
    try:
        region = outside_of_zones(layer.region, substrate.zones)
    except LayerError as error:
        return FailedLayer(
            index=layer.index,
            level=layer.level,
            cut_level=layer.cut_level,
            thickness=layer.thickness,
            reason=f"collars that stand cannot be taken away: {error}",
        )
    return replace(layer, region=region, area=region.area)


def check_complete(sections: PlanSections) -> None:
    """Raise a LayerError, with all of them in its `failed`, if any layer failed."""
    if not sections.failed:
        return
    first, stack = sections.failed[0], sections.stack
    # a last layer that is but a sliver of one, cut where the part ends
    thickness = stack.thicknesses[-1]
    sliver = first.index == len(stack.radii) - 1 and thickness - stack.overshoot < THIN * thickness
    remedy = "--last-layer drop leaves it out" if sliver else "--allow-failed plans the others"
    others = "".join(f", {layer.index} (R {layer.radius:.6g} mm)" for layer in sections.failed[1:])
    raise LayerError(
        f"{sections.part.source}: {len(sections.failed)} of {len(sections.failed) + len(sections.layers)} layers failed, first"
        f" layer {first.index} (R {first.radius:.6g} mm): {first.reason}{'; then' + others[1:] if others else ''};"
        f" {remedy}",
        failed=sections.failed,
    )
