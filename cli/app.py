"""The commands. Heavy imports wait until a command needs them, so that ``validate`` answers at once."""

from __future__ import annotations

import enum
import sys
from pathlib import Path
from typing import Annotated

import typer
from graspdsl.cli.messages import as_file_json, complain, result, result_json

from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors

app = typer.Typer(
    name="graspdsl",
    help="Write grasp controllers as formulas, run them, see what they did.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

SpecPath = Annotated[Path, typer.Argument(metavar="SPEC", help="A spec file (YAML).")]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout and nothing else.")]
Setting = Annotated[list[str], typer.Option("--set", metavar="KEY=VALUE", help="Change a value, scene.friction=0.6.")]


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
    specs: Annotated[list[Path], typer.Argument(metavar="SPEC…", help="Spec files (YAML).")], as_json: AsJson = False
) -> None:
    """Check specs: every fault of every file, with its place and a way out. Starts no simulator."""
    files, sound = [], True
    for path in specs:
        source, diagnostics = _examined(path)
        sound = sound and not has_errors(diagnostics)
        files.append(as_file_json(str(path), diagnostics))
        if not as_json:
            complain(str(path), source, diagnostics, sys.stdout)
            if not has_errors(diagnostics):
                result(f"{path}: ok")
    if as_json:
        result_json({"files": files})
    raise typer.Exit(0 if sound else 1)


def _examined(path: Path, overrides: tuple[str, ...] = ()) -> tuple[str, tuple[Diagnostic, ...]]:
    from graspdsl.compiler.program import examine
    from graspdsl.spec.files import read_text

    try:
        source = read_text(path)
    except DiagnosticError as error:
        return "", error.diagnostics
    return source, examine(source, path.name, overrides).diagnostics


@app.command()
def run(
    spec: Annotated[Path | None, typer.Argument(metavar="[SPEC]", help="A spec file (YAML).")] = None,
    trials: Annotated[int | None, typer.Option(help="How many trials, instead of what the spec says.")] = None,
    seed: Annotated[int | None, typer.Option(help="The seed, instead of what the spec says.")] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="How many processes; the numbers do not depend on it.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The run's folder; by default a new one in runs/.")
    ] = None,
    resume: Annotated[Path | None, typer.Option(metavar="DIR", help="Finish the run in this folder.")] = None,
    settings: Setting = [],  # noqa: B006 (typer copies it)
    as_json: AsJson = False,
) -> None:
    """Run a spec's trials and report what the controller did."""
    from graspdsl.cli.running import begin, finish, go_on

    if resume is not None:
        if trials is not None or seed is not None or out is not None or settings:
            raise typer.BadParameter("a resumed run keeps its trials, seed, folder and settings", param_hint="--resume")
        folder = go_on(resume, spec)
    elif spec is None:
        raise typer.BadParameter("give a spec, or --resume a run", param_hint="SPEC")
    else:
        overrides = list(settings)
        overrides += [f"trials.count={trials}"] if trials is not None else []
        overrides += [f"trials.seed={seed}"] if seed is not None else []
        source, diagnostics = _examined(spec, tuple(overrides))
        complain(str(spec), source, diagnostics)
        if has_errors(diagnostics):
            if as_json:
                result_json({"files": [as_file_json(str(spec), diagnostics)]})
            raise typer.Exit(1)
        folder = begin(spec, source, tuple(overrides), out)
    raise typer.Exit(finish(folder, workers, as_json))


class Form(enum.StrEnum):
    """The ways to show a formula."""

    TEXT = "text"
    UNICODE = "unicode"
    ASCII = "ascii"
    TREE = "tree"
    PIPELINE = "pipeline"
    JSON = "json"


@app.command()
def explain(
    what: Annotated[str, typer.Argument(metavar="SPEC|EXPRESSION", help="A spec file or a formula.")],
    form: Annotated[Form, typer.Option("--as", help="What to show of it.")] = Form.TEXT,
    as_json: AsJson = False,
) -> None:
    """Show what a formula means: its equations, spaces, shapes and the pipeline it becomes."""
    from graspdsl.cli.explaining import explanations_of_expression, explanations_of_spec

    is_file = what.endswith((".yaml", ".yml")) or Path(what).is_file()
    explanations = explanations_of_spec(Path(what)) if is_file else explanations_of_expression(what)
    if explanations is None:
        raise typer.Exit(1)
    if as_json or form is Form.JSON:
        result_json({"phases": [explanation.as_dict() for explanation in explanations]})
        return
    show = {
        Form.TEXT: lambda explanation: explanation.text(),
        Form.UNICODE: lambda explanation: explanation.unicode(),
        Form.ASCII: lambda explanation: explanation.ascii(),
        Form.TREE: lambda explanation: explanation.tree(),
        Form.PIPELINE: lambda explanation: explanation.pipeline(),
    }[form]
    result("\n\n".join(show(explanation) for explanation in explanations))


@app.command()
def report(
    folder: Annotated[Path, typer.Argument(metavar="RUN", help="The folder of a run.")], as_json: AsJson = False
) -> None:
    """Summarise a run."""
    from graspdsl.cli.tables import show_summary

    from graspdsl.report.summary import summary
    from graspdsl.trials.store import RunFolder

    numbers = summary(RunFolder.open(folder))
    if as_json:
        result_json(numbers)
    else:
        show_summary(numbers)


@app.command()
def schema() -> None:
    """Print the JSON Schema of specs, for editors."""
    from graspdsl.spec.loading import json_schema

    result_json(json_schema())
