"""The metal of random plans, piece by piece: from the emitted toolpath against the sections' areas, and what was warned of.

python -m tests.figures.plans [count] [seed] [real parts, STEP files ...]
"""

from __future__ import annotations

import itertools
import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import brep_slicer as bs
from brep_slicer.planning import Plan

FIXTURES = Path(__file__).resolve().parents[2] / "fixtures" / "step"
# (file, substrate radius mm, layer thickness mm, step-over mm)
PARTS = (
    ("spur_gear_tooth", None, 1.4, 3.4),
    ("helical_gear_tooth", None, 1.4, 3.4),
    ("propeller", None, 2.0, 3.4),
    ("wind_blade", 40.0, 2.0, 1.5),
    ("cam", 40.0, 2.0, 2.0),
    ("keyed_band", 45.0, 2.0, 3.0),
    ("box_on_shaft", 50.0, 4.0, 3.0),
    ("eccentric_disc", 15.0, 4.0, 2.0),
    ("drilled_tube", 30.0, 4.0, 3.0),
    ("oblique_tube", 30.0, 4.0, 3.0),
)
# The first layer planned is drawn from these; others from 0 to 2. The blade begins farther out than its shaft.
FIRST = {"wind_blade": (40, 160), "propeller": (0, 40)}
# A bead's round end holds as much as this length of it, in widths: a parabola's cross-section w wide turned about its middle.
ROUND_END = 3.0 * math.pi / 32.0
WITHIN = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """A piece's metal over its area times t, and whether a warning names the piece."""

    layer: int
    piece: int
    share: float
    named: bool


def metal_by_piece(plan: Plan) -> list[Found]:
    """Each piece's metal, from points and speeds of the toolpath: t d per length at the usual speed, and round ends.

    Where bead centres come nearer to the outline than half a step-over, what they lay beyond it is wanted, too.
    """
    process, path = plan.process, plan.toolpath
    usual = process.value("deposition_speed_mm_s")
    share = np.where(path.deposits, path.segment_lengths() * usual / path.speed, 0.0)
    held = np.bincount(path.runs(), weights=share)
    beads = [(layer, bead) for layer, fill in zip(plan.layers, plan.fills, strict=True) for bead in fill.beads]
    metal: dict[tuple[int, int], float] = {}
    for k, (layer, bead) in enumerate(beads):
        ends = 2.0 if bead.speed is None else float((1.0 / bead.speed[[0, -1]]).sum())
        laid = held[k] + (0.0 if bead.closed else ROUND_END * process.width * ends)
        metal[layer.index, bead.piece] = metal.get((layer.index, bead.piece), 0.0) + process.step_over * laid
    named = {(la, pi) for notice in plan.notices for la, pi in itertools.product(notice.layers, notice.pieces)}
    beyond = 0.5 * process.step_over - process.value("inset")
    out = []
    for layer in plan.layers:
        for number, piece in enumerate(layer.region.pieces):
            lines = [bead.points for la, bead in beads if la is layer and bead.piece == number]
            area = piece.area() if beyond <= 0.0 else _grown(piece, beyond, lines, process.step_over)
            key = layer.index, number
            out.append(Found(layer=layer.index, piece=number, share=metal.get(key, 0.0) / area, named=key in named))
    return out


def _grown(piece, distance: float, lines, step_over: float) -> float:
    import shapely

    from brep_slicer.region import band_between, polygon_from_piece

    copies = [piece.closure.moved(points, k) for points in lines for k in (-1, 0, 1)]
    beside = shapely.MultiLineString(copies).buffer(0.5 * step_over, cap_style="square")
    if not piece.winds:
        shape = polygon_from_piece(piece, chord=0.005)
        return shape.union(shape.buffer(distance).intersection(beside)).area
    shape = band_between(piece, piece.cut - 1.0, piece.cut + 2.0, chord=0.005)
    grown = shape.union(shape.buffer(distance).intersection(beside))
    _, low, _, high = grown.bounds
    return grown.intersection(piece.closure.window(piece.cut, piece.cut + 1.0, low, high)).area


def random_plan(rng: np.random.Generator, parts=PARTS) -> tuple[str, Plan]:
    """A plan of a part, some of its layers, with random pattern, contours, fit, angle and order."""
    name, substrate, t, d = parts[rng.integers(len(parts))]
    path = FIXTURES / f"{name}.step"
    known = path.exists()
    settings = {
        "pattern": str(rng.choice([p.value for p in bs.InnerPattern])),
        "contours": int(rng.choice([0, 0, 1, 1, 2])),
        "fit": str(rng.choice(["in", "in", "on", "out"])),
        "hatch_angles_deg": float(rng.choice([0.0, 90.0, rng.uniform(0.0, 180.0)])),
        "order": str(rng.choice(["shortest", "pattern"])),
        "step_over": d * float(rng.uniform(0.8, 1.25)),
    }
    process = bs.Process(layer_thickness=t, **settings)
    first = int(rng.integers(*FIRST.get(name, (0, 3))))
    part = bs.read_step(path if known else name)
    made = bs.plan(part, process, axis="Z" if known else None, substrate=substrate, layers=(first, first + 2))
    words = ", ".join(f"{k} {v:.4g}" if isinstance(v, float) else f"{k} {v}" for k, v in settings.items())
    return f"{Path(name).stem} {first}:{first + 2}, {words}", made


def main(count: int, seed: int, real: list[str]) -> None:
    rng = np.random.default_rng(seed)
    parts = (*PARTS, *((name, None, 1.0, 1.0) for name in real))
    pieces = off = silent = refused = 0
    for _ in range(count):
        try:
            words, made = random_plan(rng, parts)
        except bs.BrepSlicerError as error:
            refused += 1
            print(f"refused\t{error}", flush=True)
            continue
        found = metal_by_piece(made)
        wrong = [f for f in found if abs(f.share - 1.0) > WITHIN]
        unsaid = [f for f in wrong if not f.named]
        pieces, off, silent = pieces + len(found), off + len(wrong), silent + len(unsaid)
        span = f"{min(f.share for f in found):.3f} to {max(f.share for f in found):.3f}" if found else "no piece"
        print(f"{'SILENT' if unsaid else 'ok'}\t{span}\t{len(wrong)} of {len(found)} off\t{words}", flush=True)
    print(f"{count} plans, {refused} refused; {pieces} pieces, {off} more than {WITHIN:g} off, {silent} of them unsaid")


if __name__ == "__main__":
    main(int((sys.argv[1:2] or ["200"])[0]), int((sys.argv[2:3] or ["1"])[0]), sys.argv[3:])
