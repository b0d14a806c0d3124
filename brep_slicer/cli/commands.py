"""The command: brep-slicer inspect, plan, init, view.

In: words from a shell. Out: files, a few lines on the terminal, an exit code.
"""

from __future__ import annotations

import contextlib
import functools
import gc
import json
import os
import sys
from inspect import Parameter
from inspect import signature as inspect_signature
from pathlib import Path
from typing import Annotated, Any

import typer
import typer.core
import typer.main

from brep_slicer.errors import BrepSlicerError, InputError

from .summary import say, warn

# New objects between two searches for cycles of them: a plan makes many objects that live on and hardly a cycle, so that
# searching as often as Python does by default (700) finds nothing.
OBJECTS_BETWEEN_SEARCHES = 100_000

# The groups of plan's options that are no process parameters.
INPUT, OUTPUT, TUNING = "Part: what is built, on what", "What is written", "How it is computed"


class Commands(typer.core.TyperGroup):
    """The commands; `plan` gets its options from the process's declarations when it is asked for, and not before."""

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        return _plan_command() if cmd_name == "plan" else super().get_command(ctx, cmd_name)


app = typer.Typer(
    name="brep-slicer",
    cls=Commands,
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


@app.command("plan")
def _plan_by_name() -> None:
    """Keep the place of `plan` in the list of commands; `Commands` has the command itself."""


def plan(
    part: PartFile,
    out: Annotated[Path, typer.Option("-o", "--out", help="Folder to write to.", rich_help_panel=OUTPUT)] = Path("out"),
    write: Annotated[
        str | None,
        typer.Option(
            "--write",
            help="What is written, as csv,json; all are listed above. With a + before it, beside the usual: +dxf.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    proof: Annotated[
        bool,
        typer.Option(
            "--proof",
            help="Measure step-over, coverage and deposit; goes into report.json and proof.png.",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
    process: Annotated[
        Path | None,
        typer.Option("--process", help="TOML file with process parameters; options overrule it.", rich_help_panel=INPUT),
    ] = None,
    axis: AxisText = None,
    substrate: SubstrateRadius = None,
    solid: SolidNames = None,
    build: BuildNames = None,
    stands: StandNames = None,
    unit: Unit = None,
    layers: Annotated[
        str | None, typer.Option("--layers", help="Plan only layers a:b (from 0, b not included).", rich_help_panel=INPUT)
    ] = None,
    engine: Annotated[
        str, typer.Option("--engine", help="analytic (default) or boolean.", rich_help_panel=TUNING)
    ] = "analytic",
    allow_failed: Annotated[
        bool, typer.Option("--allow-failed", help="Write the toolpath even if some layers failed.", rich_help_panel=TUNING)
    ] = False,
    yes: Annotated[
        bool, typer.Option("--yes", help="Plan without asking, however long it may take.", rich_help_panel=TUNING)
    ] = False,
    **given: Any,
) -> None:
    """Plan the deposition of a part: toolpath, report, pictures."""
    from brep_slicer.output.atomic import ensure_folder
    from brep_slicer.output.write import report_alone, write_plan, writers_of
    from brep_slicer.planning import check_complete, cut_layers, fill_layers
    from brep_slicer.planning.estimate import estimate_of
    from brep_slicer.planning.report import summary_of_sections

    settings = _process(process, given)
    writers = writers_of(write)
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
        report_alone(sections, out)
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
    written = write_plan(made, out, write=writers, allow_failed=allow_failed, proof=proof)
    say(made, proof=proof)
    typer.echo("written: " + ", ".join(str(path) for path in written))


@functools.cache
def _plan_command() -> Any:
    """The command `plan` with an option for every parameter of a process."""
    from .options import process_options

    def command(**given: Any) -> None:
        plan(**given)

    own = inspect_signature(plan, eval_str=True)
    named = [one for one in own.parameters.values() if one.kind is not Parameter.VAR_KEYWORD]
    part, *others = (one.replace(kind=Parameter.KEYWORD_ONLY) for one in named)
    command.__doc__ = plan.__doc__
    command.__signature__ = own.replace(parameters=[part, *process_options(), *others])  # type: ignore[attr-defined]
    alone = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    alone.command("plan", cls=PlanCommand)(command)
    return typer.main.get_command(alone)


class PlanCommand(typer.core.TyperCommand):
    """Plan, with all patterns and writers in its help, which are looked for only then."""

    def format_help(self, ctx: Any, formatter: Any) -> None:
        from .help import plan_help

        self.help = plan_help()
        super().format_help(ctx, formatter)


def _process(path: Path | None, given: dict[str, Any]) -> Any:
    from brep_slicer.process import process_from_values, read_process

    from .options import process_values

    values = process_values(given)
    if path is not None:
        return read_process(path, **values)
    if not {"layer_thickness", "step_over"} <= values.keys():
        raise InputError("layer thickness and step-over are required; give -t and -d, in mm, or a file with --process")
    return process_from_values({}, source="options", **values)


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
def init(
    file: Annotated[Path, typer.Argument(help="Process file to write.", metavar="FILE.toml")] = Path("process.toml"),
    layer_thickness: Annotated[float, typer.Option("-t", "--layer-thickness", help="Layer thickness t, mm.")] = 1.4,
    step_over: Annotated[float, typer.Option("-d", "--step-over", help="Step-over d between bead centres, mm.")] = 3.4,
    force: Annotated[bool, typer.Option("--force", help="Write over files that are there.")] = False,
) -> None:
    """Write a process file with a comment on every parameter, and beside it the schema by which editors check it."""
    from brep_slicer.output.atomic import ensure_folder, write_text
    from brep_slicer.process.schema import schema_of_process
    from brep_slicer.process.template import process_template

    schema = file.with_suffix(".schema.json")
    for path in (file, schema):
        if path.exists() and not force:
            raise InputError(f"{path}: this file is there already; --force writes over it")
    text = process_template(layer_thickness, step_over, schema=f"./{schema.name}")
    ensure_folder(file.parent)
    for path, content in ((file, text), (schema, json.dumps(schema_of_process(), indent=1) + "\n")):
        typer.echo(f"written: {write_text(path, content)}")


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
