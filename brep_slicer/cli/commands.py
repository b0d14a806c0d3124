"""The command: brep-slicer inspect, plan, view.

In: words from a shell. Out: files, a few lines on the terminal, an exit code.
"""

from __future__ import annotations

import contextlib
import gc
import json
import os
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from brep_slicer.errors import BrepSlicerError, InputError

from .help import INPUT, LAYERS, METAL, OUTPUT, PLAN_HELP, TUNING, pattern_names
from .summary import say, warn

# New objects between two searches for cycles of them: a plan makes many objects that live on and hardly a cycle, so that
# searching as often as Python does by default (700) finds nothing.
OBJECTS_BETWEEN_SEARCHES = 100_000

app = typer.Typer(
    name="brep-slicer",
    help="Plan laser metal deposition on shafts: cut a STEP solid with coaxial cylinders, fill the layers with beads.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

PartFile = Annotated[Path, typer.Argument(help="STEP file of the part.", metavar="PART.step")]
AxisText = Annotated[
    str | None,
    typer.Option(
        "--axis",
        help="Axis of the shaft: X, Y, Z, or origin:direction as 0,0,5:0,0,1. Found if not given.",
        rich_help_panel=INPUT,
    ),
]
SubstrateRadius = Annotated[
    float | None,
    typer.Option(
        "--substrate", help="Radius of the cylinder to build on, mm. Chosen and explained if not given.", rich_help_panel=INPUT
    ),
]
SolidNames = Annotated[
    list[str] | None,
    typer.Option("--solid", help="Plan only this solid, by name or index; may be repeated.", rich_help_panel=INPUT),
]
BuildNames = Annotated[
    list[str] | None,
    typer.Option("--build", help="This solid is to be built, by name or index; may be repeated.", rich_help_panel=INPUT),
]
StandNames = Annotated[
    list[str] | None,
    typer.Option("--stands", help="This solid stands already, by name or index; may be repeated.", rich_help_panel=INPUT),
]
Unit = Annotated[
    str | None,
    typer.Option(
        "--unit", help="Length unit of the file if it states none (or a wrong one): mm, cm, m, inch, ...", rich_help_panel=INPUT
    ),
]


def _version(asked: bool) -> None:
    if asked:
        from brep_slicer.version import version

        typer.echo(f"brep-slicer {version()}")
        raise typer.Exit()


@app.callback()
def _root(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")] = False,
) -> None:
    """Plan laser metal deposition on shafts."""


def _part(path: Path, unit: str | None, solids: list[str] | None) -> Any:
    from brep_slicer.part import read_step

    return read_step(path, unit=unit, solids=solids or None)


@app.command()
def inspect(
    part: PartFile,
    axis: AxisText = None,
    substrate: SubstrateRadius = None,
    solid: SolidNames = None,
    build: BuildNames = None,
    stands: StandNames = None,
    unit: Unit = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print plain JSON.")] = False,
) -> None:
    """Say what a part looks like to a planner: axis, cylinders, radial range, overhangs."""
    from brep_slicer.inspection import inspect_part, volume_text

    found = inspect_part(_part(part, unit, solid), axis=axis, substrate=substrate, build=build, stands=stands)
    if as_json:
        typer.echo(json.dumps(found.as_dict(), indent=1))
        return
    lines = [f"{found.source}: {len(found.solids)} solid(s), unit {found.unit}"]
    for s in found.solids:
        low, high = s["radial_range_mm"]
        kinds = ", ".join(f"{count} {kind}" for kind, count in s["faces"].items())
        volume = volume_text(s["volume_mm3"], s["volume_uncertainty_mm3"])
        lines.append(f"  {s['index']}: {s['name']}: {volume}, R {low:.6g} to {high:.6g} mm; faces: {kinds}")
    lines.append(f"axis: {', '.join(found.candidates) if axis is None else axis}")
    for c in found.cylinders:
        lines.append(
            f"  R {c.radius:.6g} mm {'outside' if c.external else 'bore'}, {c.area:.5g} mm2, solid(s) {list(c.solids)}"
        )
    chosen = "none" if found.substrate_radius is None else f"R {found.substrate_radius:.6g} mm"
    lines.append(f"substrate: {chosen} ({found.substrate_reason})")
    if found.roles:
        lines += [f"roles: {found.roles}", f"left out: {found.left_out}"]
    lines += [f"warning: {warning}" for warning in found.warnings]
    typer.echo("\n".join(lines))


@app.command(help=PLAN_HELP)
def plan(
    part: PartFile,
    layer_thickness: Annotated[
        float | None, typer.Option("-t", "--layer-thickness", help="Layer thickness t, mm.", rich_help_panel=LAYERS)
    ] = None,
    step_over: Annotated[
        float | None, typer.Option("-d", "--step-over", help="Step-over d between bead centres, mm.", rich_help_panel=METAL)
    ] = None,
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder to write to.", rich_help_panel=OUTPUT)] = Path("out"),
    process: Annotated[
        Path | None,
        typer.Option("--process", help="TOML file with process parameters; options overrule it.", rich_help_panel=INPUT),
    ] = None,
    width: Annotated[
        float | None, typer.Option("-w", "--bead-width", help="Bead width w, mm (default 1.44 d).", rich_help_panel=METAL)
    ] = None,
    inset: Annotated[
        float | None,
        typer.Option("--inset", help="Outermost bead centres inside of the outline, mm (default w/2).", rich_help_panel=METAL),
    ] = None,
    contours: Annotated[
        int | None,
        typer.Option("--contours", help="Beads along the outline before hatching (default 0).", rich_help_panel=METAL),
    ] = None,
    pattern: Annotated[
        str | None,
        typer.Option(
            "--pattern", help=f"Inside of the contours: {', '.join(pattern_names())}; see above.", rich_help_panel=METAL
        ),
    ] = None,
    fit: Annotated[
        str | None,
        typer.Option(
            "--fit", help="Outermost bead centres in (w/2 inside, default), on, or out of the outline.", rich_help_panel=METAL
        ),
    ] = None,
    allowance: Annotated[
        float | None,
        typer.Option(
            "--allowance",
            help="Machining allowance: grow the part by this much all over, mm (default 0).",
            rich_help_panel=LAYERS,
        ),
    ] = None,
    order: Annotated[
        str | None,
        typer.Option("--order", help="Beads in the pattern's order (default), or shortest travels.", rich_help_panel=METAL),
    ] = None,
    even_height: Annotated[
        bool,
        typer.Option(
            "--even-height",
            help="Faster where beads come nearer to each other, so that the height stays t.",
            rich_help_panel=METAL,
        ),
    ] = False,
    proof: Annotated[
        bool,
        typer.Option(
            "--proof",
            help="Measure step-over, coverage and deposit; goes into report.json and proof.png.",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
    angle: Annotated[
        list[float] | None,
        typer.Option(
            "--angle",
            help="Hatch angle, degrees from the circumference; repeated: layer by layer in turn.",
            rich_help_panel=METAL,
        ),
    ] = None,
    angle_step: Annotated[
        float | None,
        typer.Option("--angle-step", help="Turn the hatch by this many degrees from layer to layer.", rich_help_panel=METAL),
    ] = None,
    one_way: Annotated[
        bool, typer.Option("--one-way", help="Lay all hatch beads in the same direction.", rich_help_panel=METAL)
    ] = False,
    speed: Annotated[
        float | None, typer.Option("--speed", help="Deposition speed, mm/s (default 9).", rich_help_panel=METAL)
    ] = None,
    chord: Annotated[
        float | None,
        typer.Option(
            "--chord", help="Tolerance of sampled curves, mm (default 0.01, or d / 100 for d below 1).", rich_help_panel=TUNING
        ),
    ] = None,
    last_layer: Annotated[
        str | None,
        typer.Option(
            "--last-layer",
            help="Last layer if t does not divide the height: auto (kept, unless a sliver), keep, drop, stretch.",
            rich_help_panel=LAYERS,
        ),
    ] = None,
    cut_at: Annotated[
        str | None,
        typer.Option(
            "--cut-at", help="Cut layers at the bottom (default) or the middle of their thickness.", rich_help_panel=LAYERS
        ),
    ] = None,
    layers: Annotated[
        str | None, typer.Option("--layers", help="Plan only layers a:b (from 0, b not included).", rich_help_panel=LAYERS)
    ] = None,
    engine: Annotated[
        str, typer.Option("--engine", help="analytic (default) or boolean.", rich_help_panel=TUNING)
    ] = "analytic",
    axis: AxisText = None,
    substrate: SubstrateRadius = None,
    solid: SolidNames = None,
    build: BuildNames = None,
    stands: StandNames = None,
    unit: Unit = None,
    allow_failed: Annotated[
        bool, typer.Option("--allow-failed", help="Write the toolpath even if some layers failed.", rich_help_panel=TUNING)
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Plan without asking, however long it may take.", rich_help_panel=TUNING)
    ] = False,
    step: Annotated[bool, typer.Option("--step", help="Also write the beads as STEP wires.", rich_help_panel=OUTPUT)] = False,
    dxf: Annotated[bool, typer.Option("--dxf", help="Also write the unrolled layers as DXF.", rich_help_panel=OUTPUT)] = False,
) -> None:
    """Plan the deposition of a part: toolpath.csv, toolpath.json, report.json, layers.png, toolpath.png."""
    from brep_slicer.output.atomic import ensure_folder
    from brep_slicer.output.write import write_plan, write_report
    from brep_slicer.planning import check_complete, cut_layers, fill_layers
    from brep_slicer.planning.estimate import estimate_of
    from brep_slicer.planning.report import summary_of_sections

    given = {
        "layer_thickness": layer_thickness,
        "step_over": step_over,
        "bead_width": width,
        "inset": inset,
        "contours": contours,
        "hatch_angles_deg": tuple(angle) if angle else None,
        "hatch_angle_step_deg": angle_step,
        "both_ways": False if one_way else None,
        "deposition_speed_mm_s": speed,
        "chord": chord,
        "pattern": _choice("--pattern", pattern, "InnerPattern"),
        "allowance": allowance,
        "fit": _choice("--fit", fit, "Fit"),
        "order": _choice("--order", order, "Order"),
        "speed_follows_spacing": True if even_height else None,
        "last_layer": _choice("--last-layer", last_layer, "LastLayer"),
        "cut_at": _choice("--cut-at", cut_at, "CutAt"),
    }
    settings = _process(process, given)
    read = _part(part, unit, solid)
    ensure_folder(out)
    with _progress("sections") as advance:
        sections = cut_layers(
            read,
            settings,
            axis=axis,
            substrate=substrate,
            build=build,
            stands=stands,
            layers=layers,
            engine=engine,
            progress=advance,
        )
    typer.echo(f"roles: {sections.substrate.roles}")
    # what is known of the sections is said at once: beads and proof may take minutes
    warn(sections.notices)
    if sections.failed and not allow_failed:
        write_report(sections, out)
        check_complete(sections)
    typer.echo(f"sections: {summary_of_sections(sections)}")
    _ask(estimate_of(sections), read.source, yes=yes)
    with _progress("beads") as advance:
        made = fill_layers(sections, progress=advance)
    warn(made.notices[len(sections.notices) :])
    if proof:
        with _progress("proof") as advance:
            made.proof(progress=advance)
        warn(made.proof_notices)
    written = write_plan(made, out, allow_failed=allow_failed, step=step, dxf=dxf, proof=proof)
    say(made, proof=proof)
    typer.echo("written: " + ", ".join(str(path) for path in written))


def _process(path: Path | None, given: dict[str, Any]) -> Any:
    from brep_slicer.process import process_from_values, read_process

    if path is not None:
        return read_process(path, **given)
    if given["layer_thickness"] is None or given["step_over"] is None:
        raise InputError("layer thickness and step-over are required; give -t and -d, in mm, or a file with --process")
    return process_from_values({}, source="options", **given)


def _choice(option: str, value: str | None, name: str) -> Any:
    if value is None:
        return None
    from brep_slicer import process

    return process.choice(option, value, getattr(process, name))


def _ask(estimate: Any, source: str, *, yes: bool) -> None:
    """Say how much there will be; ask on a terminal, and refuse in a pipe, where that is more than is waited for unasked."""
    from brep_slicer.planning.estimate import check_size

    typer.echo(f"estimate: {estimate}")
    if yes or not estimate.is_large:
        return
    if not (sys.stdin.isatty() and sys.stderr.isatty()):
        check_size(estimate, source)
    typer.confirm("That is much. Plan it all the same?", abort=True, err=True)


class _progress:
    """A progress bar on a terminal, nothing in a pipe."""

    def __init__(self, name: str) -> None:
        self.name = name

    def __enter__(self) -> Any:
        self.bar = None
        if not sys.stderr.isatty():
            return None
        from rich.console import Console
        from rich.progress import Progress

        self.bar = Progress(console=Console(stderr=True), transient=True)
        self.bar.start()
        task = self.bar.add_task(self.name, total=None)
        return lambda done, total: self.bar.update(task, completed=done, total=total)  # type: ignore[union-attr]

    def __exit__(self, *error: object) -> None:
        if self.bar is not None:
            self.bar.stop()


@app.command()
def view(folder: Annotated[Path, typer.Argument(help="Folder that `plan` has written.")]) -> None:
    """Show the pictures of a plan again (opens them, or names them where there is no screen)."""
    pictures = [folder / name for name in ("layers.png", "toolpath.png") if (folder / name).exists()]
    if not pictures:
        raise InputError(f"{folder}: there are no pictures of a plan in here; run brep-slicer plan first")
    for picture in pictures:
        typer.echo(str(picture))
        if sys.stdout.isatty():
            typer.launch(str(picture))


def run() -> None:
    """`main` as a process of its own, which is over with it.

    All files are closed by then, and to take the kernel's tables apart one by one takes longer than to read a part.
    """
    gc.set_threshold(OBJECTS_BETWEEN_SEARCHES)
    # no matrix here is large enough for numpy's threads: to start them, and to wake them, takes longer
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        main()
    except SystemExit as done:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(BrokenPipeError):
                stream.flush()
        os._exit(done.code if isinstance(done.code, int) else 1)


def main() -> None:
    """Every error that we know of is one line on standard error and an exit code."""
    try:
        sys.exit(app(standalone_mode=False, prog_name="brep-slicer") or 0)
    except BrepSlicerError as error:
        _end(str(error), error.exit_code)
    except MemoryError:
        _end("out of memory; plan fewer layers at once with --layers, or a coarser --chord", 2)
    except BrokenPipeError:
        # whoever read our output has closed it
        sys.stdout = sys.stderr
        sys.exit(1)
    except typer.Abort:
        _end("stopped; nothing was written", 1)
    except Exception as error:
        # words that are no options of ours: the parser's own errors, whose class is not public
        if not hasattr(error, "format_message"):
            raise
        message = str(error.format_message())
        sys.exit(2) if not message else _end(
            f"{message.rstrip('.')}; brep-slicer --help, or brep-slicer plan --help, lists what there is", 2
        )


def _end(message: str, code: int) -> None:
    typer.echo(f"brep-slicer: {' '.join(message.split())}", err=True)
    sys.exit(code)
