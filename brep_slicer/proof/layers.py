"""The proof of a whole plan, layer by layer, as plain values.

In: a plan's layers, fills and toolpath. Out: for each layer coverage, deposit, measured step-over, duty.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from brep_slicer.fill import LayerFill
from brep_slicer.maps import Array
from brep_slicer.notices import Notice, NoticeKind
from brep_slicer.region import Layer, polygon_from_piece
from brep_slicer.substrate.axis import Axis
from brep_slicer.toolpath import Toolpath
from brep_slicer.wording import counted

from .coverage import coverage_of_shares
from .deposit import evenness_of
from .equals import shares_of
from .step_over import step_over_of

# Bins of the histogram of spacings.
BINS = 13
# Spacings within this of what their layer's fill asks for are as planned, mm.
AS_PLANNED = 1e-3
# Metal is even when no layer leaves more than this share bare, its mean height is t to this share, and beads of one kind are as
# far apart as planned at this share of places: what a deposition process varies by itself anyway.
EVEN_BARE, EVEN_HEIGHT, EVEN_SPACED = 0.02, 0.02, 0.99
# A peak, averaged over half a bead's width, that is higher than so many t is warned of: it stands where the next layer's top is
# to be.
HIGHEST_PEAK = 2.0
# Beads of a fill and of the toolpath made of it are equally long to this share, whatever was rounded on the way.
SAME_LENGTH = 1e-6
# Pieces are drawn to this for asking in which of them a peak lies, mm.
CHORD = 0.05
# Averaged heights within this share of t are even.
EVEN = 0.02


def proof_of_layers(
    layers: Sequence[tuple[Layer, LayerFill]],
    toolpath: Toolpath,
    axis: Axis,
    *,
    width: float,
    step_over: float,
    progress: Callable[[int, int], None] | None = None,
) -> list[dict[str, Any]]:
    """A row a layer: shares of area, mean and peak height over t, variation, spacings in mm, their histogram, duty, starts."""
    summaries = {row["layer"]: row for row in toolpath.summary_by_layer()}
    whole = [(layer, fill) for layer, fill in layers if not layer.region.is_empty]
    rows = []
    for done, (layer, fill) in enumerate(whole, start=1):
        row = _row(layer, fill, toolpath, axis, width, step_over)
        rows.append({"layer": layer.index, **row, **_duty(summaries.get(layer.index))})
        if progress is not None:
            progress(done, len(whole))
    return rows


def summary_of_proof(rows: Sequence[dict[str, Any]]) -> str:
    """One line: a verdict, then the worst of all layers."""
    if not rows:
        return "no layer holds metal"
    bare = max(rows, key=lambda row: row["bare_share"])
    heights = [row["mean_height_over_t"] for row in rows]
    return (
        f"{verdict_of_proof(rows)}; {spacings_in_words(rows)}; at most {100.0 * bare['bare_share']:.3g} % left bare (layer"
        f" {bare['layer']}); mean height {min(heights):.3f} to {max(heights):.3f} t, {_peak_in_words(_highest(rows))}"
    )


def notices_of_proof(rows: Sequence[dict[str, Any]]) -> tuple[Notice, ...]:
    """What the proof warns of: peaks of more than twice t, with their height, and where the highest is."""
    high = [row for row in rows if row["peak_height_over_t"] > HIGHEST_PEAK]
    if not high:
        return ()
    heights = [row["peak_height_over_t"] for row in high]
    return (
        Notice(
            kind=NoticeKind.PEAK,
            text=f"the deposit stands higher than {HIGHEST_PEAK:g} t at places: {_peak_in_words(_highest(high))}",
            layers=tuple(row["layer"] for row in high),
            figures={"peak_over_t": (min(heights), max(heights))},
        ),
    )


def _highest(rows: Sequence[dict[str, Any]]) -> dict[str, Any]:
    return max(rows, key=lambda row: row["peak_height_over_t"])


def _peak_in_words(row: dict[str, Any]) -> str:
    place = row["peak_at"]
    where = "" if place is None else f", piece {place['piece']}, at kappa {place['kappa_mm']:.4g}, v {place['v_mm']:.4g} mm"
    return f"highest {row['peak_height_over_t']:.3g} t (layer {row['layer']}{where})"


def verdict_of_proof(rows: Sequence[dict[str, Any]]) -> str:
    """Whether the metal is even, and what is not: bare area, mean height, the spacing of beads of one kind."""
    doubts = []
    bare = [row for row in rows if row["bare_share"] > EVEN_BARE]
    if bare:
        worst = max(bare, key=lambda row: row["bare_share"])
        doubts.append(f"{counted(len(bare), 'layer')} with more than {EVEN_BARE:.0%} bare, most on layer {worst['layer']}")
    heights = [row for row in rows if abs(row["mean_height_over_t"] - 1.0) > EVEN_HEIGHT]
    if heights:
        worst = max(heights, key=lambda row: abs(row["mean_height_over_t"] - 1.0))
        doubts.append(
            f"{counted(len(heights), 'layer')} whose mean height is off t by more than {EVEN_HEIGHT:.0%}, most layer"
            f" {worst['layer']} ({worst['mean_height_over_t']:.3f} t)"
        )
    if notices_of_proof(rows):
        doubts.append(_peak_in_words(_highest(rows)))
    for pair, known in _by_neighbours(rows).items():
        if _alike(pair) and known["as_planned"] < EVEN_SPACED * known["spacings"]:
            doubts.append(f"{pair} not spaced as planned")
    return f"uneven: {', '.join(doubts)}" if doubts else "even"


def spacings_in_words(rows: Sequence[dict[str, Any]]) -> str:
    """By kind of neighbours: at how many places beads are as far apart as planned, and how far they are at the others."""
    pairs = _by_neighbours(rows)
    if not pairs:
        return "no two beads beside each other"
    measured = [row["step_over_measured_mm"] for row in rows if row["step_over_measured_mm"]["spacings"]]
    planned = _span([step for m in measured for step in m["planned"]], ".4g")
    apart = f"beads {planned} mm apart as planned (within {AS_PLANNED:g} mm)"
    return f"{apart}: " + ", ".join(_pair_in_words(pair, known) for pair, known in pairs.items())


def _pair_in_words(pair: str, known: dict[str, Any]) -> str:
    places, planned = known["spacings"], known["as_planned"]
    if planned == places:
        return f"{pair} at all {places} places"
    others = _span([known["others_lowest"], known["others_highest"]], ".3f")
    # a contour and the hatch that ends at it are no neighbours side by side: no step-over is asked for between them
    if not _alike(pair):
        return f"{pair} {others} mm at {places - planned} of {places} places, where they meet on purpose"
    share = math.floor(1000.0 * planned / places) / 10.0
    return f"{pair} at {share:.3g} % of {places} places, {others} mm at the others"


def _alike(pair: str) -> bool:
    """Whether both neighbours are of one kind, so that a step-over is asked for between them."""
    one, other = pair.split("-")
    return one == other


def _by_neighbours(rows: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """The measured spacings of all layers by kind of neighbours, those of one kind first."""
    out: dict[str, dict[str, Any]] = {}
    for row in rows:
        for pair, known in row["step_over_measured_mm"]["by_neighbours"].items():
            before = out.get(pair, {"spacings": 0, "as_planned": 0, "others_lowest": None, "others_highest": None})
            ends = [k[key] for k in (before, known) for key in ("others_lowest", "others_highest") if k[key] is not None]
            out[pair] = {
                **{key: before[key] + known[key] for key in ("spacings", "as_planned")},
                "others_lowest": min(ends, default=None),
                "others_highest": max(ends, default=None),
            }
    return dict(sorted(out.items(), key=lambda item: (not _alike(item[0]), item[0])))


def _kinds_of_beads(layer: int, fill: LayerFill, toolpath: Toolpath) -> dict[int, str]:
    """What laid each bead of a layer, by its number in the toolpath; "bead" where the two cannot be told to be the same."""
    laid = (toolpath.layer == layer) & toolpath.deposits
    numbers, at = np.unique(toolpath.bead[laid], return_inverse=True)
    lengths = np.bincount(at, weights=toolpath.segment_lengths()[laid], minlength=len(numbers))
    own = np.array([bead.length() for bead in fill.beads])
    if len(own) == len(lengths) and np.allclose(own, lengths, rtol=SAME_LENGTH, atol=AS_PLANNED):
        return {int(number): bead.kind.value for number, bead in zip(numbers, fill.beads, strict=True)}
    return {int(number): "bead" for number in numbers}


def _spacings_by_neighbours(
    between: NDArray[np.int64], near: Array, off: NDArray[np.bool_], kinds: dict[int, str]
) -> dict[str, Any]:
    pairs = np.array(["-".join(sorted((kinds[int(i)], kinds[int(j)]))) for i, j in between])
    out = {}
    for pair in np.unique(pairs):
        mine = pairs == pair
        others = near[mine & off]
        out[str(pair)] = {
            "spacings": int(mine.sum()),
            "as_planned": int((mine & ~off).sum()),
            "others_lowest": float(others.min()) if len(others) else None,
            "others_highest": float(others.max()) if len(others) else None,
        }
    return out


def _span(values: Sequence[float], form: str) -> str:
    low, high = f"{min(values):{form}}", f"{max(values):{form}}"
    return low if low == high else f"{low} to {high}"


def _row(layer: Layer, fill: LayerFill, toolpath: Toolpath, axis: Axis, width: float, step_over: float) -> dict[str, Any]:
    thickness = layer.thickness or 1.0
    shares = shares_of(layer.region, fill, width=width)
    coverage = coverage_of_shares(shares, width)
    sizes = {"width": width, "thickness": thickness, "step_over": step_over, "tolerance": EVEN}
    deposit = evenness_of(layer.region, fill.beads, **sizes, shares=shares)
    measured = step_over_of(toolpath, axis, layer.index, within=2.0 * step_over)
    near = measured.spacings
    planned = np.unique(np.round([step_over, *fill.step_over], 9))
    off = np.abs(near[:, None] - planned).min(axis=1) > AS_PLANNED
    others = near[off]
    counts, edges = np.histogram(near, bins=BINS, range=(0.5 * step_over, 1.5 * step_over))
    return {
        "bare_share": coverage.bare_share,
        "once_share": coverage.once / coverage.area,
        "more_share": coverage.more / coverage.area,
        "outside_mm2": coverage.outside,
        "mean_height_over_t": deposit.mean / thickness,
        "height_variation": deposit.variation,
        "height_within_2_percent": deposit.within,
        "peak_height_over_t": deposit.peak / thickness,
        "peak_at": _place(layer, deposit.peak_at),
        "step_over_measured_mm": {
            "spacings": len(near),
            "lowest": float(near.min()) if len(near) else None,
            "highest": float(near.max()) if len(near) else None,
            "planned": planned.tolist(),
            "as_planned": int((~off).sum()),
            "others_lowest": float(others.min()) if len(others) else None,
            "others_highest": float(others.max()) if len(others) else None,
            "by_neighbours": _spacings_by_neighbours(measured.between, near, off, _kinds_of_beads(layer.index, fill, toolpath)),
            "histogram": {"edges_mm": edges.tolist(), "counts": counts.tolist()},
        },
    }


def _place(layer: Layer, at: tuple[float, float] | None) -> dict[str, Any] | None:
    """A place in the plane and the piece that it lies in, or next to."""
    if at is None:
        return None
    import shapely

    polygons = [polygon_from_piece(piece, chord=CHORD) for piece in layer.region.pieces]
    closure = layer.region.pieces[0].closure
    points = [shapely.Point(closure.moved(np.array(at), k)) for k in closure.beside]
    distances = [min(polygon.distance(point) for point in points) for polygon in polygons]
    return {"piece": int(np.argmin(distances)), "kappa_mm": at[0], "v_mm": at[1]}


def _duty(summary: dict[str, Any] | None) -> dict[str, Any]:
    """Share of the way with the laser on, and how often it starts."""
    if summary is None:
        return {"duty": None, "starts": 0}
    laid, moved = summary["deposition_length_mm"], summary["travel_length_mm"]
    return {"duty": laid / math.fsum([laid, moved]) if laid else 0.0, "starts": summary["beads"]}
