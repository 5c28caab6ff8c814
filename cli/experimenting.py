"""The chapter's experiments on the command line: run them all, then hold them against the chapter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.text import Text

from graspdsl.api.runs import Run
from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import result, result_json, say
from graspdsl.cli.several import Asked, Part, folder_for, run_each
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Span, on_one_line
from graspdsl.places.document import parse_document
from graspdsl.report.claims import Claim
from graspdsl.report.experiment_setups import departure
from graspdsl.report.experiments_page import verdict, write_experiments
from graspdsl.report.points import EXPERIMENTS
from graspdsl.report.summary import plain
from graspdsl.report.tables import Column, Table


def run_experiments(asked: Asked) -> int:
    """Run the specs one after the other, each into a folder of its own, and say which claims agree.

    Returns the exit code. Every spec, and every run begun before, is checked before the first one runs.
    """
    programs = [sound(spec, asked.overrides, allow_code=asked.allow_code) for spec in asked.specs]
    chosen = [Part(program.spec.name, spec, program) for spec, program in zip(asked.specs, programs, strict=True)]
    for experiment in chosen:
        _known(experiment)
    _told_apart(chosen)
    with folder_for(chosen, asked) as whole:
        return _run_all(chosen, whole, asked)


def _run_all(chosen: Sequence[Part], whole: Path, asked: Asked) -> int:
    claims: list[Claim] = []
    reports: dict[str, str] = {}

    def report(experiment: Part, run: Run) -> None:
        reports[experiment.name] = run.report().relative_to(whole).as_posix()
        claims.extend(run.claims)

    if code := run_each(chosen, whole, asked, report):
        return code
    page = write_experiments(whole, claims, reports)
    if asked.as_json:
        result_json({"run": str(whole), "claims": plain(claims)})
    else:
        result(_text(claims))
    say(f"report: {on_one_line(str(page))}")
    return 0


def _known(experiment: Part) -> None:
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


def _named_at(experiment: Part) -> Span | None:
    """Where in its file a spec has its name, unless that was given on the command line."""
    document = parse_document(experiment.text, experiment.spec.name)
    return document.span(("name",)) if document.data.get("name") == experiment.name else None


def _told_apart(chosen: Sequence[Part]) -> None:
    """Each experiment may be given once, since its runs have a folder of its name."""
    before: dict[str, Part] = {}
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
