"""The commands. Heavy imports wait until a command needs them, so that ``validate`` answers at once."""

from __future__ import annotations

import enum
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer.models import CommandInfo

from graspdsl.cli.inputs import answering, judged, named, sound
from graspdsl.cli.messages import WRONG_INPUT, as_file_json, complain, printable, result, result_json
from graspdsl.cli.words import Beginnings, Commands
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, on_one_line

if TYPE_CHECKING:
    from graspdsl.trials.workers import Workers as SharedBy

app = typer.Typer(
    name="graspdsl",
    cls=Commands,
    help="Write grasp controllers as formulas, run them, see what they did.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

# The bounds of trials.count and trials.seed in a spec, repeated here because typer needs them at once.
MOST_TRIALS, LARGEST_SEED = 100_000, 2**63 - 1
MOST_WORKERS = 1024


class Evaluator(enum.StrEnum):
    """What evaluates ticks: graspdsl.backends.BACKENDS, repeated here because typer needs them at once."""

    NUMPY = "numpy"
    JAX = "jax"
    CASADI = "casadi"


class Engine(enum.StrEnum):
    """Who runs trials: graspdsl.trials.workers.ENGINES, repeated here because typer needs them at once."""

    LOCAL = "local"
    DASK = "dask"


AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout and nothing else.")]
Trials = Annotated[int | None, typer.Option(min=1, max=MOST_TRIALS, help="How many trials, not what the spec says.")]
Seed = Annotated[int | None, typer.Option(min=0, max=LARGEST_SEED, help="The seed, not what the spec says.")]
Workers = Annotated[
    int | None, typer.Option(min=1, max=MOST_WORKERS, help="How many processes; the numbers do not depend on it.")
]
Shared = Annotated[
    Engine,
    typer.Option("--engine", help="Who runs the trials: processes of this machine, or a Dask cluster, an extra."),
]
Scheduler = Annotated[
    str | None,
    typer.Option(metavar="ADDRESS|FILE", help="Dask's scheduler; by default there is one here, with --workers."),
]
Out = Annotated[
    Path | None, typer.Option(parser=named, metavar="DIR", help="The run's folder; by default a new one in runs/.")
]
Resume = Annotated[Path | None, typer.Option(parser=named, metavar="DIR", help="Finish the run in this folder.")]
AllowCode = Annotated[
    bool, typer.Option("--allow-code", help="Run the Python files that the spec names under 'code'. Read them first.")
]
Evaluated = Annotated[
    Evaluator | None,
    typer.Option("--backend", help="What evaluates ticks, not what the spec says; jax and casadi are extras."),
]
Kept = Annotated[
    str | None,
    typer.Option(
        metavar="all|ends|none|every=N", help="Which ticks of trajectories are kept; trials measure the same with each."
    ),
]
Setting = Annotated[
    list[str],
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Change a value: scene.friction=0.6; several, 0.3,0.6, are a sweep."
    ),
]


def _with_backend(settings: list[str], backend: Evaluator | None) -> list[str]:
    """The settings, with that of a backend which has an option of its own."""
    return [*settings, *([f"control.backend={backend.value}"] if backend else [])]


def _sharing(workers: int | None, engine: Engine, scheduler: str | None) -> SharedBy:
    """Who shares the trials."""
    from graspdsl.trials.workers import sharing

    try:
        return sharing(workers, engine.value, scheduler)
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--scheduler") from None


def only(words: Sequence[str]) -> None:
    """Leave the command that the words begin with, if they begin with one: typer makes every command there is."""
    named = [command for command in app.registered_commands if _name_of(command) in words]
    if named:
        app.registered_commands, app.registered_groups = named, []


def _name_of(command: CommandInfo) -> str:
    return command.name or getattr(command.callback, "__name__", "").replace("_", "-")


def _version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        result(f"graspdsl {version('graspdsl')}")
        raise typer.Exit


@app.callback()
def _graspdsl(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    pass


@app.command()
def validate(
    specs: Annotated[
        list[Path], typer.Argument(parser=named, metavar="SPEC", help="Spec files, hand or mount files (YAML).")
    ],
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Check specs, hand and mount files: every fault, with its place and a way out."""
    files, every_one_sound = [], True
    with answering():
        for path in specs:
            source, diagnostics = judged(path, allow_code=allow_code)
            faulty = has_errors(diagnostics)
            every_one_sound = every_one_sound and not faulty
            files.append(as_file_json(str(path), diagnostics))
            if not as_json:
                complain(str(path), source, diagnostics, sys.stdout)
                if not faulty:
                    result(on_one_line(f"{path}: ok"))
        if as_json:
            result_json({"files": files})
    raise typer.Exit(0 if every_one_sound else WRONG_INPUT)


@app.command()
def run(
    spec: Annotated[Path | None, typer.Argument(parser=named, metavar="SPEC", help="A spec file (YAML).")] = None,
    trials: Trials = None,
    seed: Seed = None,
    workers: Workers = None,
    engine: Shared = Engine.LOCAL,
    scheduler: Scheduler = None,
    out: Out = None,
    resume: Resume = None,
    settings: Setting = [],  # noqa: B006 (typer copies it)
    backend: Evaluated = None,
    keep: Kept = None,
    no_report: Annotated[
        bool, typer.Option("--no-report", help="Make no page now: graspdsl report makes it at any time.")
    ] = False,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Run a spec's trials, at every point of its sweep, and report what the controller did."""
    with answering(as_json):
        sharing = _sharing(workers, engine, scheduler)
        if resume is not None:
            if trials is not None or seed is not None or out is not None or settings or backend or keep:
                message = "a resumed run keeps its trials, seed, folder and settings"
                raise typer.BadParameter(message, param_hint="--resume")
            from graspdsl.cli.running import finish, go_on

            made = go_on(resume, spec, allow_code=allow_code)
        elif spec is None:
            raise typer.BadParameter("give a spec, or --resume a run", param_hint="SPEC")
        else:
            overrides = _with_backend(settings, backend)
            overrides += [f"trials.count={trials}"] if trials is not None else []
            overrides += [f"trials.seed={seed}"] if seed is not None else []
            overrides += [f"trials.keep={keep}"] if keep is not None else []
            program = sound(spec, tuple(overrides), allow_code=allow_code, sweeps=True)
            from graspdsl.api.sweeps import of_either_kind
            from graspdsl.cli.running import begin, finish

            made = of_either_kind(begin("run", program, out), program)
        code = finish(made, sharing, as_json, page=not no_report)
    raise typer.Exit(code)


@app.command(name="map")
def map_(
    spec: Annotated[Path | None, typer.Argument(parser=named, metavar="SPEC", help="A spec file (YAML).")] = None,
    over: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y",
            help="Two numbers of a start, across and up, as roll,height or roll=-1.5:1.5,height=0.06:0.16; without "
            "bounds, between those that the spec draws from. For floating contacts azimuth,polar: the direction, from "
            "the object's centre, that one contact starts in.",
        ),
    ] = None,
    grid: Annotated[
        str | None, typer.Option(metavar="COLUMNSxROWS", help="How many cells across and up; by default 40x40.")
    ] = None,
    contact: Annotated[str | None, typer.Option(help="Which floating contact; by default the grasp's first.")] = None,
    seed: Seed = None,
    workers: Workers = None,
    engine: Shared = Engine.LOCAL,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None, typer.Option(parser=named, metavar="DIR", help="The map's folder; by default a new one in runs/.")
    ] = None,
    resume: Annotated[
        Path | None, typer.Option(parser=named, metavar="DIR", help="Finish the map in this folder.")
    ] = None,
    settings: Setting = [],  # noqa: B006 (typer copies it)
    backend: Evaluated = None,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Map the domain of attraction: which starts end in which mode or outcome."""
    with answering(as_json):
        from graspdsl.cli.mapping import USUAL_GRID, make_map, resume_map, wanted_axes

        sharing = _sharing(workers, engine, scheduler)
        if resume is not None:
            if any(value is not None for value in (spec, over, grid, contact, seed, out, backend)) or settings:
                raise typer.BadParameter("a resumed map keeps all that it was begun with", param_hint="--resume")
            code = resume_map(resume, sharing, as_json, allow_code=allow_code)
        elif spec is None or over is None:
            raise typer.BadParameter("give a spec and --over two parameters, or --resume a map", param_hint="SPEC")
        else:
            axes = wanted_axes(over, USUAL_GRID if grid is None else grid)
            overrides = [*_with_backend(settings, backend), *([f"trials.seed={seed}"] if seed is not None else [])]
            code = make_map(
                *(spec, axes, tuple(overrides)),
                contact=contact,
                workers=sharing,
                out=out,
                as_json=as_json,
                allow_code=allow_code,
            )
    raise typer.Exit(code)


class Form(enum.StrEnum):
    """The ways to show a formula."""

    TEXT = "text"
    UNICODE = "unicode"
    ASCII = "ascii"
    LATEX = "latex"
    TREE = "tree"
    PIPELINE = "pipeline"
    JSON = "json"


@app.command()
def explain(
    what: Annotated[
        str, typer.Argument(metavar="SPEC|EXPRESSION|CODE", help="A spec file, a formula, or the code of a complaint.")
    ],
    form: Annotated[Form, typer.Option("--as", help="What to show of it.")] = Form.TEXT,
    profile: Annotated[
        bool, typer.Option("--profile", help="With --as pipeline: how long each step takes, and a whole tick.")
    ] = False,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Show what a formula means: equations, spaces, pipeline; of a complaint, a wrong and a right example."""
    from graspdsl.cli.explaining import explanations, show_complaint

    wants_json = as_json or form is Form.JSON
    with answering(wants_json):
        if profile and (wants_json or form is not Form.PIPELINE):
            raise typer.BadParameter("it is of the pipeline: give --as pipeline", param_hint="--profile")
        if show_complaint(what, wants_json):
            return
        found = explanations(what, allow_code=allow_code)
        if wants_json:
            result_json({"phases": [explanation.as_dict() for explanation in found]})
            return
        from graspdsl.compiler.explain import Explanation

        if form is Form.PIPELINE:
            shown = [explanation.pipeline(profile=profile) for explanation in found]
        else:
            show = {
                Form.TEXT: Explanation.text,
                Form.UNICODE: Explanation.unicode,
                Form.ASCII: Explanation.ascii,
                Form.LATEX: Explanation.latex,
                Form.TREE: Explanation.tree,
            }[form]
            shown = [show(explanation) for explanation in found]
        result(printable("\n\n".join(shown)))


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(parser=named, metavar="RUN", help="The folder of a run.")],
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Summarise a run, finished or not, and write its page and figures anew."""
    with answering(as_json):
        from graspdsl.cli.running import opened_either, show

        show(opened_either(folder, allow_code=allow_code), as_json)


@app.command()
def runs(
    folder: Annotated[
        Path, typer.Argument(parser=named, metavar="FOLDER", help="Where the runs are; by default runs/.")
    ] = Path("runs"),
    as_json: AsJson = False,
) -> None:
    """List the runs in a folder: of what, how far, how many converged, and whether one runs now."""
    with answering(as_json):
        from graspdsl.cli.run_list import show_runs

        show_runs(folder, as_json)


@app.command()
def rm(
    folders: Annotated[list[Path], typer.Argument(parser=named, metavar="RUN", help="Folders of runs.")],
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask.")] = False,
) -> None:
    """Remove runs: what they are made of, and nothing else that is in their folders."""
    with answering():
        from graspdsl.cli.removing import remove_runs

        remove_runs(folders, sure=yes)


@app.command()
def export(
    run: Annotated[Path, typer.Argument(parser=named, metavar="RUN", help="The folder of a run.")],
    to: Annotated[
        Path,
        typer.Option(
            parser=named,
            metavar="FILE",
            help="A .csv, .jsonl, .parquet or .npz file; - is stdout; with --what all a folder.",
        ),
    ] = Path("-"),
    what: Annotated[
        str,
        typer.Option(
            metavar="TABLE",
            help="trials, trajectory, what its report shows: summary, modes, figure-funnel, …; or all of it.",
        ),
    ] = "trials",
    trial: Annotated[int | None, typer.Option(min=0, help="Of which trial, of a trajectory.")] = None,
    form: Annotated[
        str | None,
        typer.Option(
            "--format",
            metavar="csv|jsonl|parquet|npz",
            help="By default what the file's name ends with; with --what all csv.",
        ),
    ] = None,
    allow_code: AllowCode = False,
) -> None:
    """Write a run's trials, a trajectory, or what a table or figure of its report shows, for other programs."""
    if (what == "trajectory") != (trial is not None):
        raise typer.BadParameter("a trajectory is of one trial: --what trajectory --trial N", param_hint="--trial")
    with answering():
        from graspdsl.cli.exporting import export_run

        export_run(run, to, what, trial, form, allow_code=allow_code)


@app.command()
def doctor(
    run: Annotated[Path, typer.Argument(parser=named, metavar="RUN", help="The folder of a run.")],
    repair: Annotated[
        bool,
        typer.Option("--repair", help="Remove what is damaged, so that run --resume runs it again; mend what can be."),
    ] = False,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Say what of a run is whole, and mend what can be mended."""
    with answering(as_json):
        from graspdsl.cli.doctoring import show_health

        code = show_health(run, as_json, repair=repair, allow_code=allow_code)
    raise typer.Exit(code)


@app.command()
def compare(
    folders: Annotated[
        list[Path], typer.Argument(parser=named, metavar="RUN RUN", help="Folders of runs; the first is the measure.")
    ],
    out: Annotated[
        Path | None,
        typer.Option(parser=named, metavar="DIR", help="The comparison's folder; by default a new one in runs/."),
    ] = None,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Put runs side by side, with differences, ratios and their intervals; figures and a page as files."""
    if len(folders) < 2:
        raise typer.BadParameter("give at least two runs", param_hint="RUN")
    with answering(as_json):
        from graspdsl.cli.comparing import show_comparison

        show_comparison(folders, out, as_json, allow_code=allow_code)


@app.command()
def diff(
    first: Annotated[Path, typer.Argument(parser=named, metavar="RUN", help="The folder of a run.")],
    second: Annotated[Path, typer.Argument(parser=named, metavar="RUN", help="The folder of another.")],
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Say what differs between two runs before any trial: their specs, versions, plug-ins and files."""
    with answering(as_json):
        from graspdsl.cli.differing import show_differences

        show_differences((first, second), as_json, allow_code=allow_code)


@app.command()
def experiments(
    specs: Annotated[
        list[Path], typer.Argument(parser=named, metavar="SPEC", help="Specs of the chapter's experiments.")
    ],
    trials: Trials = None,
    seed: Seed = None,
    workers: Workers = None,
    engine: Shared = Engine.LOCAL,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None,
        typer.Option(parser=named, metavar="DIR", help="Where the runs go; one begun there before goes on."),
    ] = None,
    settings: Setting = [],  # noqa: B006 (typer copies it)
    backend: Evaluated = None,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Run the chapter's experiments and say, point by point, what agrees with the chapter."""
    with answering(as_json):
        from graspdsl.cli.experimenting import run_experiments
        from graspdsl.cli.several import Asked

        sharing = _sharing(workers, engine, scheduler)
        given = (tuple(specs), tuple(_with_backend(settings, backend)), trials, seed, sharing, out, as_json, allow_code)
        code = run_experiments(Asked("experiments", *given))
    raise typer.Exit(code)


@app.command()
def engines(
    spec: Annotated[Path, typer.Argument(parser=named, metavar="SPEC", help="A spec file (YAML).")],
    worlds: Annotated[
        str | None,
        typer.Option(metavar="NAME,NAME", help="Which engines, the first is the measure; by default all there are."),
    ] = None,
    plain: Annotated[
        bool, typer.Option("--plain", help="The engines alone, not at half and twice the time step and solver effort.")
    ] = False,
    trials: Trials = None,
    seed: Seed = None,
    workers: Workers = None,
    engine: Shared = Engine.LOCAL,
    scheduler: Scheduler = None,
    out: Annotated[
        Path | None,
        typer.Option(parser=named, metavar="DIR", help="Where the runs go; one begun there before goes on."),
    ] = None,
    settings: Setting = [],  # noqa: B006 (typer copies it)
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """Run a spec on every engine, at half and twice the time step and solver effort, and say where they agree."""
    with answering(as_json):
        from graspdsl.cli.engines import run_engines
        from graspdsl.cli.several import Asked

        options = (*(("--worlds", worlds) if worlds is not None else ()), *(("--plain",) if plain else ()))
        sharing = _sharing(workers, engine, scheduler)
        given = ((spec,), tuple(settings), trials, seed, sharing, out, as_json, allow_code, options)
        names = None if worlds is None else worlds.split(",")
        code = run_engines(Asked("engines", *given), names, finer=not plain)
    raise typer.Exit(code)


@app.command()
def view(
    run: Annotated[Path | None, typer.Argument(parser=named, metavar="RUN", help="The folder of a run.")] = None,
    trial: Annotated[int | None, typer.Option(min=0, help="Which trial of it; by default 0.")] = None,
    thing: Annotated[
        str | None,
        typer.Option(
            "--object", metavar="NAME|FILE", help="An object of the catalogue, or a file of one (STL, OBJ, URDF)."
        ),
    ] = None,
    hand: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="A hand of the catalogue, or a hand file (YAML).")
    ] = None,
    images: Annotated[
        Path | None, typer.Option(parser=named, metavar="DIR", help="Write pictures (PNG) into this folder.")
    ] = None,
    video: Annotated[
        Path | None, typer.Option(parser=named, metavar="FILE", help="Write a film (.mp4) of the trial.")
    ] = None,
    frames: Annotated[
        int | None, typer.Option(min=1, max=1000, help="How many pictures of a trial; by default 6.")
    ] = None,
    allow_code: AllowCode = False,
) -> None:
    """Look at a trial, an object or a hand: in a window, as pictures or as a film."""
    if sum(chosen is not None for chosen in (run, thing, hand)) != 1:
        raise typer.BadParameter("give one of RUN, --object and --hand", param_hint="RUN")
    if run is None and video is not None:
        raise typer.BadParameter("only a trial can be filmed", param_hint="--video")
    if run is None and trial is not None:
        raise typer.BadParameter("only a RUN has trials", param_hint="--trial")
    if frames is not None and (run is None or images is None):
        raise typer.BadParameter("only pictures of a trial are counted: RUN with --images", param_hint="--frames")
    with answering():
        from graspdsl.cli import viewing

        if run is not None:
            count = viewing.PICTURES if frames is None else frames
            viewing.view_trial(run, trial or 0, images, video, count, allow_code=allow_code)
        elif thing is not None:
            viewing.view_object(thing, images)
        else:
            viewing.view_hand(hand or "", images)


init = typer.Typer(
    cls=Beginnings,
    help="Write a spec to begin with: graspdsl init [FILE] is graspdsl init spec [FILE]; or a hand or mount file.",
    rich_markup_mode=None,
)
app.add_typer(init, name="init")


@init.command(name=Beginnings.usual)
def init_spec(
    file: Annotated[
        Path | None, typer.Argument(parser=named, metavar="[FILE]", help="The spec; by default grasp.yaml, here.")
    ] = None,
    thing: Annotated[
        str | None,
        typer.Option(
            "--object", metavar="NAME|FILE", help="Of the catalogue, a file (STL, OBJ, URDF …) or {cylinder: {…}}."
        ),
    ] = None,
    hand: Annotated[
        str | None, typer.Option(metavar="NAME|FILE", help="A hand of the catalogue, or a hand file (YAML).")
    ] = None,
    world: Annotated[str | None, typer.Option(metavar="NAME", help="What the trials run in.")] = None,
    sensing: Annotated[str | None, typer.Option(metavar="NAME", help="What a contact feels through.")] = None,
    controller: Annotated[
        str | None, typer.Option(metavar="NAME", help="What the contacts do, as π_sgx or pi_sgx.")
    ] = None,
    shipped_as: Annotated[
        str | None,
        typer.Option("--from", metavar="EQUATION|NAME", help="A spec that ships: 4.26, experiment-2, or by its name."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Write over a file that is there.")] = False,
) -> None:
    """Write a spec to begin with; at a terminal, what is not given is asked for."""
    chosen = (thing, hand, world, sensing, controller)
    if shipped_as is not None and any(choice is not None for choice in chosen):
        raise typer.BadParameter(
            "a spec that ships has its own object, hand, world and controller", param_hint="--from"
        )
    with answering():
        from graspdsl.cli.first_spec import Wishes, init_spec

        init_spec(file, Wishes(*chosen), shipped_as=shipped_as, force=force)


@init.command(name="mount")
def init_mount(
    model: Annotated[Path, typer.Argument(parser=named, metavar="MODEL", help="A URDF or MJCF file of an arm.")],
    out: Annotated[
        Path | None,
        typer.Option(parser=named, metavar="FILE", help="The mount file; by default of the model's name, here."),
    ] = None,
    face: Annotated[
        str, typer.Option(metavar="LINK", help="The link that the hand is fixed to; by default behind the last joint.")
    ] = "",
) -> None:
    """Guess a mount file from the model of an arm: its face, its joints and their weights, where it stands."""
    with answering():
        from graspdsl.cli.starting import init_mount

        code = init_mount(model, out, face)
    raise typer.Exit(code)


@init.command(name="hand")
def init_hand(
    model: Annotated[Path, typer.Argument(parser=named, metavar="MODEL", help="A URDF or MJCF file of a hand.")],
    out: Annotated[
        Path | None,
        typer.Option(parser=named, metavar="FILE", help="The hand file; by default of the model's name, here."),
    ] = None,
    root: Annotated[
        str, typer.Option(metavar="LINK", help="The link that the hand begins with; by default its palm or the root.")
    ] = "",
) -> None:
    """Guess a hand file from a model, and a spec that grasps with it; draw the hand open and closed."""
    with answering():
        from graspdsl.cli.starting import init_hand

        code = init_hand(model, out, root)
    raise typer.Exit(code)


@app.command(name="list")
def list_(
    kind: Annotated[str | None, typer.Argument(metavar="KIND", help="What to list; by default the kinds.")] = None,
    spec: Annotated[
        Path | None,
        typer.Argument(parser=named, metavar="SPEC", help="A spec file (YAML) whose own controllers are listed too."),
    ] = None,
    as_json: AsJson = False,
    allow_code: AllowCode = False,
) -> None:
    """List what there is to write with."""
    with answering(as_json):
        from graspdsl.cli.listing import show_kinds, show_list

        if kind is None:
            show_kinds(as_json)
        else:
            show_list(kind, as_json, spec, allow_code=allow_code)


@app.command()
def check_plugin(
    what: Annotated[
        str,
        typer.Argument(
            metavar="DIST|FILE", help="An installed distribution, a Python file, which is run, or a YAML file."
        ),
    ],
    as_json: AsJson = False,
) -> None:
    """Hold what a package or a file brings against the contracts that the built-in things keep."""
    with answering(as_json):
        from graspdsl.cli.checking import check_plugin as check

        code = check(what, as_json)
    raise typer.Exit(code)


@app.command()
def schema() -> None:
    """Print the JSON Schema of specs, for editors, with what is installed."""
    with answering():
        from graspdsl.compiler.program import known_names
        from graspdsl.plugins.adoption import adopted_all
        from graspdsl.plugins.kinds import KINDS
        from graspdsl.spec.loading import json_schema

        complain("graspdsl", "", adopted_all(KINDS))
        result_json(json_schema(known_names()))


@app.command()
def fmt(
    specs: Annotated[list[Path], typer.Argument(parser=named, metavar="SPEC", help="Spec files (YAML).")],
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; name the files that are not formatted and exit with 1.")
    ] = False,
    diff: Annotated[bool, typer.Option("--diff", help="Write nothing; show what would change.")] = False,
    in_ascii: Annotated[bool, typer.Option("--ascii", help="Formulas and names in ASCII, not in Unicode.")] = False,
    allow_code: AllowCode = False,
) -> None:
    """Write specs in one style: keys in order, formulas in one spelling; comments and meaning stay."""
    with answering():
        from graspdsl.cli.formatting import format_specs

        code = format_specs(specs, check=check, diff=diff, in_ascii=in_ascii, allow_code=allow_code)
    raise typer.Exit(code)


@app.command(name="import")
def import_(
    paper: Annotated[Path, typer.Argument(parser=named, metavar="TEX", help="A LaTeX file, or a piece of one.")],
) -> None:
    """Make a spec of the controllers and resources that a paper defines; it goes to stdout."""
    with answering():
        from graspdsl.cli.importing import import_tex

        import_tex(paper)


@app.command()
def lsp(allow_code: AllowCode = False) -> None:
    """Answer an editor, over the Language Server Protocol on stdin and stdout."""
    with answering():
        try:
            from graspdsl.cli.lsp import serve
        except ModuleNotFoundError as missing:
            message, hint = f"the language server needs {missing.name}", "install it: pip install 'graspdsl[lsp]'"
            raise DiagnosticError([Diagnostic("not-installed", message, hint=hint)]) from None
        serve(allow_code=allow_code)


@app.command()
def docs(
    path: Annotated[bool, typer.Option("--path", help="Only print the folder in which the pages lie.")] = False,
    out: Annotated[
        Path | None, typer.Option(parser=named, metavar="DIR", help="The site's folder; by default a temporary one.")
    ] = None,
) -> None:
    """Open the documentation: as a site, if mkdocs is installed, else as the pages that it is made of."""
    with answering():
        from graspdsl.cli.documentation import show_documentation

        show_documentation(out, path=path)
