"""layers.png and toolpath.png, and proof.png of a plan that was proved.

In: a Plan. Out: pictures.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from ..writer import Writer

if TYPE_CHECKING:
    from brep_slicer.planning import Plan


class PicturesWriter(Writer):
    """The pictures of a plan."""

    name = "pictures"
    suffix = ".png"
    help = "layers.png (unrolled), toolpath.png (on the part); proof.png with --proof"
    usual = True

    def write(self, plan: Plan, folder: Path) -> list[Path]:
        from ..pictures import draw_layers, draw_toolpath

        written = [draw_layers(plan, folder / "layers.png"), draw_toolpath(plan, folder / "toolpath.png")]
        if plan.proven:
            from ..pictures.proof import draw_proof

            written.append(draw_proof(plan, plan.proof(), folder / "proof.png"))
        return written
