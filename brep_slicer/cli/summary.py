"""What the command says of a plan: warnings, totals, a table of its layers, the proof.

In: a Plan. Out: lines on the terminal.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import typer

from brep_slicer.wording import counted, in_words_of_length, in_words_of_time

if TYPE_CHECKING:
    from brep_slicer.notices import Notice
    from brep_slicer.planning import Plan

# So many lines of one kind of warning are shown; the report has all of them.
MOST_OF_A_KIND = 5
# Of more layers than this, the table shows the first and the last ones.
MOST_ROWS = 12


def warn(notices: Iterable[Notice]) -> None:
    """Warnings on standard error, of each kind no more than a screen holds; none hides another kind."""
    notices = list(notices)
    kinds = list(dict.fromkeys(notice.kind for notice in notices))
    for kind in kinds:
        alike = [notice for notice in notices if notice.kind is kind]
        for notice in alike[:MOST_OF_A_KIND]:
            typer.echo(f"warning: {notice}", err=True)
        if len(alike) > MOST_OF_A_KIND:
            typer.echo(f"warning: {len(alike) - MOST_OF_A_KIND} more of this kind ({kind.value}) in report.json", err=True)


def say(plan: Plan, *, proof: bool) -> None:
    """What was planned, on standard output."""
    report = plan.report()
    typer.echo(totals_in_words(plan, report))
    for line in table_of_layers(report["layers"], plan.process.step_over):
        typer.echo(line)
    if proof:
        from brep_slicer.proof import summary_of_proof

        typer.echo(f"proof: {summary_of_proof(plan.proof())}")


def totals_in_words(plan: Plan, report: dict[str, Any]) -> str:
    """Layers, their radii, beads, lengths, times, metal and catchment in one line."""
    totals = report["totals"]
    first, last = plan.layers[0], plan.layers[-1]
    which = f"numbers {first.index} to {last.index} at R" if last is not first else f"number {first.index} at R"
    radii = f"{first.radius:.6g} to {last.radius:.6g} mm" if last is not first else f"{first.radius:.6g} mm"
    catchment = report["catchment"]
    powder = "not known without --powder-feed and --powder-density" if catchment is None else f"{100.0 * catchment:.3g} %"
    return (
        f"{counted(len(plan.layers), 'layer')} on R {plan.substrate.radius:.6g} mm, {which} {radii} ({plan.substrate.reason});"
        f" {counted(totals['beads'], 'bead')}, {in_words_of_length(totals['deposition_length_mm'])} deposited in"
        f" {in_words_of_time(totals['deposition_time_s'])}, {in_words_of_length(totals['travel_length_mm'])} travel;"
        f" catchment {powder}"
    )


def table_of_layers(rows: Sequence[dict[str, Any]], step_over: float) -> list[str]:
    """A line a layer: radius, area, beads, metal laid (step-over times thickness along the beads) and its share, time.

    `rows` are a report's layers. The share is that of the metal that the layer's own area and thickness hold.
    """
    planned = [row for row in rows if not row["failed"]]
    shown = planned if len(planned) <= MOST_ROWS else [*planned[: MOST_ROWS // 2], None, *planned[-(MOST_ROWS // 2) :]]
    lines = [f"{'layer':>6} {'R mm':>9} {'area mm2':>10} {'beads':>6} {'metal cm3':>10} {'of it':>6} {'time':>9}"]
    for row in shown:
        if row is None:
            lines.append(f"{'...':>6} {counted(len(planned) - MOST_ROWS, 'layer')} more in report.json")
            continue
        thickness = row["thickness_mm"] or 0.0
        laid, wanted = row["deposition_length_mm"] * step_over * thickness, row["area_mm2"] * thickness
        share = f"{100.0 * laid / wanted:.0f} %" if wanted > 0.0 else "-"
        time = in_words_of_time(row["deposition_time_s"] + row["travel_time_s"])
        lines.append(
            f"{row['layer']:>6} {row['radius_mm']:>9.6g} {row['area_mm2']:>10.5g} {row['beads']:>6}"
            f" {laid / 1000.0:>10.4g} {share:>6} {time:>9}"
        )
    return lines
