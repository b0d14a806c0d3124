"""What planning gives: the sections of a part as they are to be filled, and the plan with their beads.

In: what the stages made. Out: PlanSections and Plan values.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from brep_slicer.fill import LayerFill
from brep_slicer.notices import Notice
from brep_slicer.part import Part
from brep_slicer.process import Process
from brep_slicer.region import FailedLayer, Layer
from brep_slicer.section import CutSolid
from brep_slicer.substrate.axis import Axis
from brep_slicer.substrate.layers import LayerStack
from brep_slicer.substrate.radius import Substrate
from brep_slicer.toolpath import Toolpath
from brep_slicer.wording import counted, in_words_of_length, shortened

from .report import report_of_plan

Progress = Callable[[int, int], None]
# What a plan keeps its proof under.
PROOF = "proof"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class PlanSections:
    """A part cut into layers: what was read, what was chosen, the layers, those that failed, what there is to warn of.

    `layers` are those that were cut with certainty, `failed` the others, each with their numbers in `stack`; `solids` are the
    part's, ready to be cut; `notices` what there is to say.
    """

    part: Part
    process: Process
    axis: Axis
    axis_was_given: bool
    substrate: Substrate
    stack: LayerStack
    highest: float
    solids: tuple[CutSolid, ...] = field(repr=False)
    layers: tuple[Layer, ...]
    failed: tuple[FailedLayer, ...]
    notices: tuple[Notice, ...]

    def __repr__(self) -> str:
        return f"PlanSections({self._in_short()}, {counted(len(self.notices), 'warning')})"

    def _in_short(self) -> str:
        failed = f" ({len(self.failed)} failed)" if self.failed else ""
        layers = counted(len(self.layers) + len(self.failed), "layer")
        return f"{shortened(self.part.source)!r}: {layers}{failed} on R {self.substrate.radius:.6g} mm"

    @property
    def warnings(self) -> tuple[str, ...]:
        """The notices in words, a sentence each."""
        return tuple(str(notice) for notice in self.notices)

    def report(self) -> dict[str, Any]:
        """Everything that report.json says, as plain values."""
        return report_of_plan(self)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Plan(PlanSections):
    """A planned part: its sections, the `fills` of its layers (one each), the toolpath."""

    fills: tuple[LayerFill, ...]
    toolpath: Toolpath
    _kept: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def __repr__(self) -> str:
        laid = float(self.toolpath.segment_lengths()[self.toolpath.deposits].sum())
        beads = counted(sum(len(fill.beads) for fill in self.fills), "bead")
        return f"Plan({self._in_short()}, {beads}, {in_words_of_length(laid)}, {counted(len(self.notices), 'warning')})"

    def report(self) -> dict[str, Any]:
        """Everything that report.json says, as plain values; with how even the metal is, where that was proved."""
        report = report_of_plan(self, self.fills, self.toolpath)
        if not self.proven:
            return report
        notices = [*report["notices"], *(notice.as_dict() for notice in self.proof_notices)]
        return {**report, "notices": notices, "proof": self.proof()}

    @property
    def proven(self) -> bool:
        """Whether it was worked out how even the metal is."""
        return PROOF in self._kept

    @property
    def warnings(self) -> tuple[str, ...]:
        """The notices in words, a sentence each, and those of the proof once it was asked for."""
        return tuple(str(notice) for notice in (*self.notices, *self.proof_notices))

    @property
    def proof_notices(self) -> tuple[Notice, ...]:
        """What the proof warns of; nothing as long as `proof` was not called."""
        if not self.proven:
            return ()
        from brep_slicer.proof import notices_of_proof

        return notices_of_proof(self.proof())

    def proof(self, progress: Progress | None = None) -> list[dict[str, Any]]:
        """How even the metal is, a row a layer: coverage, simulated deposit, step-over on the emitted points, duty.

        It is worked out once; `progress` is called with (layers done, layers in all).
        """
        return list(self.once(PROOF, lambda: self._prove(progress)))

    def _prove(self, progress: Progress | None) -> list[dict[str, Any]]:
        from brep_slicer.proof import proof_of_layers

        pairs = list(zip(self.layers, self.fills, strict=True))
        width, step_over = self.process.width, self.process.step_over
        return proof_of_layers(pairs, self.toolpath, self.axis, width=width, step_over=step_over, progress=progress)

    def once(self, what: str, make: Callable[[], Any]) -> Any:
        """What follows from the plan and takes long: made when it is first asked for, and kept under a name."""
        if what not in self._kept:
            self._kept[what] = make()
        return self._kept[what]

    def forget(self, what: str) -> None:
        """Let go of what is kept under a name."""
        self._kept.pop(what, None)
