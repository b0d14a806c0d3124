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
from brep_slicer.process import PATTERNS

from .bits import bits_of_layer

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
# A piece's metal is what it should be within this share.
WITHIN = 0.02
# What lies beyond the outline is told of from this share of a piece's metal on.
MOST_BEYOND = 0.1
# Two accounts of it agree within this.
ACCOUNTS = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """A piece's metal within its outline over its area times t, what its beads lay beyond, and whether a warning names it."""

    layer: int
    piece: int
    share: float
    beyond: float
    named: bool

    @property
    def off(self) -> bool:
        """Whether more than 2 % of its metal is missing or surplus, or more than a tenth lies beyond it."""
        return abs(self.share - 1.0) > WITHIN or self.beyond > MOST_BEYOND + ACCOUNTS


def metal_by_piece(plan: Plan) -> list[Found]:
    """Each piece's metal: bits of beads, from the toolpath's points and speeds and the bead's profile, inside of outlines."""
    process = plan.process
    named = {(la, pi) for notice in plan.notices for la, pi in itertools.product(notice.layers, notice.pieces)}
    sizes = {"step_over": process.step_over, "width": process.width, "usual": process.deposition_speed}
    out = []
    for layer, fill in zip(plan.layers, plan.fills, strict=True):
        # which piece a bead was meant for, for what it lays beyond
        meant = np.array([bead.piece for bead in fill.beads], dtype=int)
        bits = bits_of_layer(plan.toolpath, layer.index, period=2.0 * math.pi * layer.radius, **sizes)
        for number, piece in enumerate(layer.region.pieces):
            inside, area = _inside(piece, bits.places), piece.area()
            share = float(bits.metal[inside].sum()) / area
            beyond = float(bits.metal[~inside & (meant[bits.bead] == number)].sum()) / area
            if process.inset < 0.499 * process.width:
                beyond = 0.0  # as the fit asks for
            out.append(Found(layer=layer.index, piece=number, share=share, beyond=beyond, named=(layer.index, number) in named))
    return out


def _inside(piece, places):
    """Which places (n, 2) lie in a piece, whole turns aside."""
    import shapely

    from brep_slicer.region import band_between, polygon_from_piece

    closure = piece.closure
    if piece.winds:
        first, shape = piece.cut, band_between(piece, piece.cut, piece.cut + 1.0, chord=0.002)
    else:
        shape = polygon_from_piece(piece, chord=0.002)
        first = sum(closure.span_of(shape.bounds)) / 2.0 - 0.5
    shapely.prepare(shape)
    return shapely.contains_xy(shape, closure.canonical(places, first))


# The patterns that random plans are filled by.
PATTERN_NAMES = PATTERNS.own()


def random_plan(rng: np.random.Generator, parts=PARTS) -> tuple[str, Plan]:
    """A plan of a part, some of its layers, with random pattern, contours, fit, angle and order."""
    name, substrate, t, d = parts[rng.integers(len(parts))]
    path = FIXTURES / f"{name}.step"
    known = path.exists()
    settings = {
        "pattern": str(rng.choice(PATTERN_NAMES)),
        "contours": int(rng.choice([0, 0, 1, 1, 2])),
        "outline_position": str(rng.choice(["in", "in", "on", "out"])),
        "angle_deg": float(rng.choice([0.0, 90.0, rng.uniform(0.0, 180.0)])),
        "order": str(rng.choice(["shortest", "pattern"])),
        "step_over": d * float(rng.uniform(0.8, 1.25)),
    }
    fill: dict[str, object] = {name: value for name, value in settings.items() if name not in ("step_over", "angle_deg")}
    if settings["pattern"] in ("auto", "hatch", "zigzag"):
        fill["pattern"] = {"name": settings["pattern"], "angle_deg": settings["angle_deg"]}
    process = bs.Process(layer_thickness=t, step_over=settings["step_over"], fill=fill)
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
        wrong = [f for f in found if f.off]
        unsaid = [f for f in wrong if not f.named]
        pieces, off, silent = pieces + len(found), off + len(wrong), silent + len(unsaid)
        span = f"{min(f.share for f in found):.3f} to {max(f.share for f in found):.3f}" if found else "no piece"
        print(f"{'SILENT' if unsaid else 'ok'}\t{span}\t{len(wrong)} of {len(found)} off\t{words}", flush=True)
    print(f"{count} plans, {refused} refused; {pieces} pieces, {off} more than {WITHIN:g} off, {silent} of them unsaid")


if __name__ == "__main__":
    main(int((sys.argv[1:2] or ["200"])[0]), int((sys.argv[2:3] or ["1"])[0]), sys.argv[3:])
