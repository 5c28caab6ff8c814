"""The chapter's experiments on the command line: run them all, then hold them against the chapter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.text import Text

from graspdsl.cli.inputs import InputError, reading, sound
from graspdsl.cli.messages import result, result_json, say
from graspdsl.cli.running import RUNS, begin, carried_on, go_on, page_of
from graspdsl.cli.tables import row, table, text_of
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic
from graspdsl.report.claim_words import MARKS
from graspdsl.report.conformance import EXPERIMENTS, Claim, claims_of
from graspdsl.report.evidence import gathered
from graspdsl.report.experiments_page import as_data, verdict, write_experiments
from graspdsl.trials.store import MANIFEST, RunFolder, fresh_folder


def run_experiments(
    specs: Sequence[Path], overrides: tuple[str, ...], workers: int | None, out: Path | None, as_json: bool
) -> int:
    """Run the specs one after the other, each into a folder of its own, and say which claims agree.

    Returns the exit code. Every spec is checked before the first one runs.
    """
    programs = [(spec, *sound(spec, overrides)) for spec in specs]
    for spec, program, text in programs:
        if program.spec.name not in EXPERIMENTS:
            message = f"there are no claims about {program.spec.name!r}"
            hint = f"known experiments: {', '.join(EXPERIMENTS)}"
            raise InputError(str(spec), text, [Diagnostic("unknown-experiment", message, hint=hint)])
    _told_apart(programs)
    if out is not None and (out / MANIFEST).exists():
        message, hint = "this folder holds a run", "name another folder for the experiments"
        raise InputError(str(out), "", [Diagnostic("folder-not-empty", message, hint=hint)])
    with reading(str(out or RUNS)):
        whole = out or fresh_folder(RUNS, "experiments")
    claims: list[Claim] = []
    reports: dict[str, str] = {}
    for spec, program, text in programs:
        folder = _begun(program, text, spec, overrides, whole / program.spec.name)
        code = carried_on(folder, workers, "run")
        if code != 0:
            return code
        with reading(str(folder.path)):
            evidence = gathered(folder)
            found = claims_of(evidence)
            page = page_of(evidence)
        claims += found
        reports[program.spec.name] = page.relative_to(whole).as_posix()
    with reading(str(whole)):
        page = write_experiments(whole, claims, reports)
    if as_json:
        result_json({"run": str(whole), "claims": as_data(claims)})
    else:
        result(_text(claims))
    say(f"report: {page}")
    return 0


def _told_apart(programs: Sequence[tuple[Path, Program, str]]) -> None:
    """Each experiment may be given once, since its runs have a folder of its name."""
    names: set[str] = set()
    for spec, program, text in programs:
        if program.spec.name in names:
            message = f"{program.spec.name} is given twice"
            raise InputError(str(spec), text, [Diagnostic("experiment-twice", message, hint="leave one out")])
        names.add(program.spec.name)


def _begun(program: Program, text: str, spec: Path, overrides: tuple[str, ...], place: Path) -> RunFolder:
    """A new run of an experiment, or the one that was begun here before."""
    if not (place / MANIFEST).exists():
        return begin(program, text, str(spec), overrides, place)
    folder = go_on(place, spec)
    if folder.manifest.overrides != overrides:
        message, hint = "this run was begun with other settings", "name another folder, or give the same settings"
        raise InputError(str(place), "", [Diagnostic("run-differs", message, hint=hint)])
    return folder


def _text(claims: Sequence[Claim]) -> str:
    listed = table("The chapter's claims", "claim", "agrees if", "measured", "verdict", words=True)
    before = ""
    for claim in claims:
        if claim.experiment != before:
            row(listed, f"{claim.experiment}", "", "", "")
            before = claim.experiment
        row(listed, f"  {claim.says}", claim.bound, claim.measured, MARKS[claim.verdict])
    doubts = [f"{claim.experiment}: {claim.says} {claim.why}." for claim in claims if claim.why]
    return text_of([listed, Text(verdict(claims)), *[Text(doubt) for doubt in doubts]])
