"""The chapter's experiments on the command line: run them all, then hold them against the chapter."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rich.text import Text

from graspdsl.api.runs import Run
from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import result, result_json, say
from graspdsl.cli.running import RUNS, carried_on, keeping, opened
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Span, on_one_line, reading
from graspdsl.places.document import parse_document
from graspdsl.report.claims import Claim
from graspdsl.report.experiment_setups import departure
from graspdsl.report.experiments_page import verdict, write_experiments
from graspdsl.report.points import EXPERIMENTS
from graspdsl.report.summary import plain
from graspdsl.report.tables import Column, Table
from graspdsl.trials.runner import new_run, pending
from graspdsl.trials.store import MANIFEST, fresh_folder, locked, made

ANOTHER = "name another folder with --out"


@dataclass(frozen=True, slots=True)
class Asked:
    """What was asked for on the command line."""

    specs: tuple[Path, ...]
    settings: tuple[str, ...] = ()
    trials: int | None = None
    seed: int | None = None
    workers: int | None = None
    out: Path | None = None
    as_json: bool = False
    allow_code: bool = False

    @property
    def overrides(self) -> tuple[str, ...]:
        """The settings with those that have an option of their own."""
        named = (("trials.count", self.trials), ("trials.seed", self.seed))
        return (*self.settings, *(f"{path}={value}" for path, value in named if value is not None))

    def words(self, out: Path) -> list[str]:
        """The command that goes on with the runs in a folder."""
        options = (("--trials", self.trials), ("--seed", self.seed), ("--workers", self.workers))
        words = ["experiments", *map(str, self.specs)]
        words += [word for name, value in options if value is not None for word in (name, str(value))]
        words += [word for setting in self.settings for word in ("--set", setting)]
        words += ["--allow-code"] if self.allow_code else []
        return [*words, "--out", str(out), *(["--json"] if self.as_json else [])]


@dataclass(frozen=True, slots=True)
class Experiment:
    """A spec of an experiment, checked."""

    spec: Path
    program: Program

    @property
    def name(self) -> str:
        """The experiment's name, and its folder's."""
        return self.program.spec.name

    @property
    def text(self) -> str:
        """The text of the spec."""
        return self.program.source.text


def run_experiments(asked: Asked) -> int:
    """Run the specs one after the other, each into a folder of its own, and say which claims agree.

    Returns the exit code. Every spec, and every run begun before, is checked before the first one runs.
    """
    chosen = [Experiment(spec, sound(spec, asked.overrides, allow_code=asked.allow_code)) for spec in asked.specs]
    for experiment in chosen:
        _known(experiment)
    _told_apart(chosen)
    if asked.out is not None:
        try:
            _free_for(asked.out, chosen, asked.overrides)
        except OSError as error:
            message = f"cannot look into this folder: {(error.strerror or 'unknown reason').lower()}"
            raise DiagnosticError([Diagnostic("folder-not-readable", message, hint=ANOTHER)], str(asked.out)) from None
    with reading(str(asked.out or RUNS)):
        whole = made(asked.out) if asked.out else fresh_folder(RUNS, "experiments")
    with keeping(whole, *asked.words(whole)), locked(whole):
        return _run_all(chosen, whole, asked)


def _run_all(chosen: Sequence[Experiment], whole: Path, asked: Asked) -> int:
    claims: list[Claim] = []
    reports: dict[str, str] = {}
    for experiment in chosen:
        run = _begun(experiment, whole / experiment.name)
        code = carried_on(run, asked.workers, *asked.words(whole))
        if code != 0:
            return code
        reports[experiment.name] = run.report().relative_to(whole).as_posix()
        claims += run.claims
    page = write_experiments(whole, claims, reports)
    if asked.as_json:
        result_json({"run": str(whole), "claims": plain(claims)})
    else:
        result(_text(claims))
    say(f"report: {on_one_line(str(page))}")
    return 0


def _known(experiment: Experiment) -> None:
    """There must be claims about a spec: its name must be that of an experiment, and it must be that experiment."""
    if experiment.name not in EXPERIMENTS:
        code, message = "unknown-experiment", f"there are no claims about {experiment.name!r}"
        hint = f"known experiments: {', '.join(EXPERIMENTS)}"
    elif differs := departure(experiment.program):
        code, message = (
            "other-experiment",
            f"this is not the chapter's {experiment.name}, so it has no claims: {differs}",
        )
        hint = "give it another name and use 'graspdsl run', or run the experiment as the chapter has it"
    else:
        return
    raise DiagnosticError(
        [Diagnostic(code, message, _named_at(experiment), hint)], str(experiment.spec), experiment.text
    )


def _named_at(experiment: Experiment) -> Span | None:
    """Where in its file a spec has its name, unless that was given on the command line."""
    document = parse_document(experiment.text, experiment.spec.name)
    return document.span(("name",)) if document.data.get("name") == experiment.name else None


def _told_apart(chosen: Sequence[Experiment]) -> None:
    """Each experiment may be given once, since its runs have a folder of its name."""
    before: dict[str, Experiment] = {}
    for experiment in chosen:
        first = before.setdefault(experiment.name, experiment)
        if first is experiment:
            continue
        if first.spec.resolve() == experiment.spec.resolve():
            code, message, hint = "experiment-twice", "this spec is given twice", "leave one out"
        else:
            span = _named_at(first)
            where = f"{first.spec}, line {span.line}," if span else str(first.spec)
            code, message = "same-name", f"this spec and {where} share the name {experiment.name}"
            hint = "leave one out, or run them one after the other into folders of their own"
        raise DiagnosticError(
            [Diagnostic(code, message, _named_at(experiment), hint)], str(experiment.spec), experiment.text
        )


def _free_for(out: Path, chosen: Sequence[Experiment], overrides: tuple[str, ...]) -> None:
    """Every run that is already in the folder must be one that this command began."""
    if (out / MANIFEST).exists():
        message = "this folder holds a run"
        raise DiagnosticError([Diagnostic("folder-not-empty", message, hint=ANOTHER)], str(out))
    for experiment in chosen:
        place = out / experiment.name
        if (place / MANIFEST).exists():
            _goes_on(experiment, overrides, place)
        elif place.exists() and (not place.is_dir() or any(place.iterdir())):
            message = "there is something here, but no run that could go on"
            raise DiagnosticError([Diagnostic("folder-not-empty", message, hint=ANOTHER)], str(place))


def _goes_on(experiment: Experiment, overrides: tuple[str, ...], place: Path) -> None:
    """A run that was begun before must have been begun in the same way."""
    begun = opened(place, allow_code=experiment.program.source.allow_code)
    if begun.program.source.text != experiment.text:
        message = f"this run was begun from another spec than {experiment.spec}"
    elif begun.program.source.overrides != overrides:
        said = shlex.join(word for setting in begun.program.source.overrides for word in ("--set", setting))
        message = f"this run was begun with other settings: {said or 'none'}"
    else:
        try:
            pending(begun.folder, begun.program, begun.folder.finished())
        except DiagnosticError as error:
            faults = [replace(fault, hint=ANOTHER) for fault in error.diagnostics]
            raise DiagnosticError(faults, str(place)) from None
        return
    raise DiagnosticError([Diagnostic("run-differs", message, hint=ANOTHER)], str(place))


def _begun(experiment: Experiment, place: Path) -> Run:
    """A new run of an experiment, or the one that was begun here before."""
    if (place / MANIFEST).exists():
        return opened(place, allow_code=experiment.program.source.allow_code)
    with reading(str(place)):
        return Run(new_run(place, experiment.program), experiment.program)


def _text(claims: Sequence[Claim]) -> str:
    rows: list[tuple[str, ...]] = []
    before = ""
    for claim in claims:
        if claim.experiment != before:
            rows.append((claim.experiment, "", "", ""))
            before = claim.experiment
        rows.append((f"  {claim.says}", claim.bound, claim.measured, claim.verdict.mark))
    columns = tuple(map(Column, ("claim", "agrees if", "measured", "verdict")))
    doubts = [f"{claim.experiment}: {claim.says} {claim.why}." for claim in claims if claim.why]
    listed = laid_out(Table("The chapter's claims", columns, tuple(rows)))
    return text_of([listed, Text(verdict(claims)), *[Text(doubt) for doubt in doubts]])
