"""The report of a run as files: one page that needs no other, and its figures for papers."""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

from graspdsl.report.claims import Claim
from graspdsl.report.drawing import Drawing
from graspdsl.report.evidence import Evidence
from graspdsl.report.figure_data import figures_of, tick_of
from graspdsl.report.figures import drawing_of
from graspdsl.report.modes import LEVEL
from graspdsl.report.outcomes import representatives
from graspdsl.report.run_tables import (
    WHOLE,
    page_tables,
    quality_tables,
    starts_tables,
    trials_table,
)
from graspdsl.report.statistics import wilson
from graspdsl.report.summary import Summary
from graspdsl.report.templating import rendered
from graspdsl.report.wording import conditions, counted, feasible, percent, percents, repetition
from graspdsl.report.writing import FIGURES, PAGE, replace
from graspdsl.trials.outcomes import OUTCOMES, Outcome
from graspdsl.trials.record import TrialRecord

Frames = Mapping[str, bytes]
NO_FRAMES: Frames = MappingProxyType({})


def write_report(
    evidence: Evidence, summary: Summary, *, frames: Frames = NO_FRAMES, claims: Sequence[Claim] = ()
) -> Path:
    """Write the page of a run and its figures, as SVG and PNG, into the run's folder; returns where the page is.

    Each file takes the place of an earlier one only once it is whole; figures that the run no longer has are removed.
    Raises DiagnosticError where the folder cannot be written to.
    """
    drawings = drawings_of(evidence, summary)
    made = page(evidence, summary, drawings, frames=frames, claims=claims)
    return write_page(evidence.folder.path, made, drawings)


def write_page(folder: Path, made: str, drawings: Sequence[Drawing]) -> Path:
    """Write a page and its figures into a folder, as :func:`write_report` does; returns where the page is."""
    files: dict[str, str | bytes] = {PAGE: made}
    for drawing in drawings:
        files |= drawing.files(f"{FIGURES}/")
    replace(folder, files, outdated=(f"{FIGURES}/*.svg", f"{FIGURES}/*.png"))
    return folder / PAGE


def drawings_of(evidence: Evidence, summary: Summary) -> list[Drawing]:
    """The figures of a run's page."""
    return [drawing_of(figure) for figure in figures_of(evidence, summary)]


def page(
    evidence: Evidence,
    summary: Summary,
    drawings: Sequence[Drawing],
    *,
    frames: Frames = NO_FRAMES,
    claims: Sequence[Claim] = (),
) -> str:
    """The page of a run: one file that needs no other.

    frames: a PNG picture of the end of one trial for each outcome, by the outcome's name, of the trials that
    :func:`graspdsl.report.outcomes.representatives` names. claims: what the chapter says of it, and what was measured.
    """
    tick = tick_of(evidence)
    return rendered(
        "report.html",
        summary=summary,
        spec=evidence.program.spec,
        spec_text=evidence.folder.spec_text,
        overrides=evidence.folder.manifest.overrides,
        phases=[phase.label for phase in evidence.program.phases],
        setting=setting(evidence),
        verdict=verdict(summary),
        conditions=conditions(summary.converged.means),
        notes=notes(evidence, summary),
        left_out=left_out(evidence),
        funnel=_of_kind(drawings, "funnel"),
        sure=percent(1.0 - LEVEL),
        residual_figures=_of_kind(drawings, "residuals"),
        convergence=_of_kind(drawings, "convergence"),
        ticks=[WHOLE.written(value) for value in (summary.ticks_to_converge, summary.ticks_to_converge_p90)],
        frames=_framed(evidence, frames),
        starts=starts_tables(summary),
        start_figures=_of_kind(drawings, "starts"),
        map=_of_kind(drawings, "map"),
        quality=quality_tables(summary.quality),
        levels=[level.said(evidence.program.target.each) for level in summary.priorities.levels],
        priority_figures=_of_kind(drawings, "priorities"),
        tick=tick,
        each=evidence.program.target.each,
        trials=trials_table(summary, tick),
        **page_tables(summary, claims),
    )


def _of_kind(drawings: Sequence[Drawing], kind: str) -> list[Drawing]:
    return [drawing for drawing in drawings if drawing.name.startswith(kind)]


def _framed(evidence: Evidence, frames: Frames) -> list[dict[str, str]]:
    """The pictures as addresses that hold them, with their captions."""
    return [
        {
            "address": f"data:image/png;base64,{base64.b64encode(frames[outcome]).decode('ascii')}",
            "caption": f"{outcome}: trial {record.number} at its end; {record.detail or OUTCOMES[outcome].means}",
        }
        for outcome, record in representatives(evidence.records).items()
        if outcome in frames
    ]


def verdict(summary: Summary) -> str:
    """Whether it worked, in a sentence with an interval."""
    finished, infeasible = summary.finished, summary.count(Outcome.INFEASIBLE_START)
    if not finished:
        return "No trial has finished, so nothing is known."
    if infeasible == finished:
        return f"None of {counted(finished, 'trial', 'trials')} could begin: no start that was drawn was feasible."
    good = summary.count(Outcome.CONVERGED)
    conditional = f", {said}" if (said := feasible(summary.starts)) else ""
    return (
        f"{good} of {counted(finished, 'trial', 'trials')} converged: {percent(good / finished)} "
        f"(95 % interval {percents(wilson(good, finished))}){conditional}."
    )


def notes(evidence: Evidence, summary: Summary) -> list[str]:
    """What a reader must know to take the verdict for what it is."""
    asked, finished = summary.asked, summary.finished
    infeasible = summary.count(Outcome.INFEASIBLE_START)
    good = summary.count(Outcome.CONVERGED)
    said = []
    if finished < asked:
        said.append(f"Only {finished} of {counted(asked, 'trial', 'trials')} are finished.")
    if repeated := repetition(summary.finished, summary.different):
        said.append(repeated)
    if 0 < infeasible < finished:
        able = finished - infeasible
        said.append(
            f"{counted(infeasible, 'trial', 'trials')} could not begin; of the other {able}, {good} converged: "
            f"{percent(good / able)} ({percents(wilson(good, able))})."
        )
    if evidence.program.spec.trials.grid is not None:
        said.append(
            "Starts lie on a grid and are not drawn at random: shares are of its cells, and intervals are what they "
            "would be for as many starts drawn evenly over it."
        )
    if not evidence.program.world.has("hand"):
        said.append("Contacts float: they are points on the object's surface, without a hand, friction or dynamics.")
    if evidence.program.probes:
        said.append("Contacts are displaced by probing: lifted, moved and put down again; a tick is a probe.")
    return said


def setting(evidence: Evidence) -> list[tuple[str, str]]:
    """What ran where: names and values."""
    spec, program = evidence.program.spec, evidence.program
    hand = f"{spec.scene.hand} on {spec.scene.mount}" if program.world.has("hand") else spec.scene.hand
    return [
        ("World", spec.scene.world),
        ("Hand", hand),
        ("Object", program.body.name),
        ("Trials", f"{len(evidence.records)} of {evidence.folder.manifest.asked}"),
        ("Seed", str(evidence.folder.manifest.seed)),
    ]


def left_out(evidence: Evidence) -> list[str]:
    """How many trials do not count where grasps ended, and why."""
    reasons = Counter(reason for reason in (_reason(evidence, record) for record in evidence.records) if reason)
    return [f"{counted(count, 'trial', 'trials')} ({reason})" for reason, count in reasons.most_common()]


def _reason(evidence: Evidence, record: TrialRecord) -> str:
    touching = evidence.touching(record)
    if record.outcome is Outcome.INFEASIBLE_START:
        return "no start was feasible"
    if touching is None:
        return "nothing was recorded of the end, or its trajectory cannot be read"
    if not touching:
        return "a contact did not touch at the end"
    if not math.isfinite(record.orientation_end):
        return "the grasp has no orientation, as one contact alone has none"
    return ""
