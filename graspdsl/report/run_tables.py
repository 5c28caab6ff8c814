"""The tables of a run: those of its page, and those in brief for a console."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from operator import itemgetter

from graspdsl.report.balance import Holding
from graspdsl.report.claims import Claim
from graspdsl.report.modes import LEVEL
from graspdsl.report.priorities import priorities_table
from graspdsl.report.quality import Confusion, Conventions, GradeSummary, Quality
from graspdsl.report.statistics import FEWEST
from graspdsl.report.summary import ModeSummary, Summary
from graspdsl.report.tables import (
    COUNT,
    ENDS,
    INTERVAL,
    MILLIMETRES,
    REASONS,
    SHARE,
    TEXT,
    WORDS,
    Column,
    Format,
    Table,
    Value,
    fixed,
    reasons_named,
    scaled,
    squared,
    trials_named,
)
from graspdsl.report.wording import STOPPED, counted, percent, percents
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord

MOST_ROWS = 5000  # trials that a page lists
RADIANS, RESIDUAL, NEWTONS = fixed(2, "rad"), fixed(3), fixed(2, "N")
MILLIMETRES_FINELY, DEGREES = fixed(2, "mm", 1e3), fixed(2, "°", math.degrees(1.0))
SQUARED, SQUARED_MILLIMETRES = squared(), squared("mm²", 1e6)
WHOLE, SECONDS = fixed(0), fixed(1, "s")
SHARES = (Column("trials", COUNT), Column("share", SHARE), Column("95 % interval", INTERVAL))


def brief_tables(summary: Summary) -> list[Table]:
    """What a console shows of a run."""
    reasons, graded = unconverged_table(summary), bool(summary.quality.grades)
    selected = [rejected_table(summary), kept_table(summary)] if summary.starts.rejected else []
    return [
        outcomes_table(summary).first(4),
        *(table for table in (reasons, stages_table(summary), *selected) if table.rows),
        brief_modes_table(summary),
        measured_table(summary),
        *([balance_table(summary.balance)] if summary.balance.trials else []),
        *([brief_quality_table(summary.quality)] if graded else []),
    ]


def page_tables(summary: Summary, claims: Sequence[Claim]) -> dict[str, Table]:
    """The tables that a page has one of, by name."""
    return {
        "outcomes": outcomes_table(summary),
        "modes": modes_table(summary),
        "residuals": residuals_table(summary),
        "stages": stages_table(summary),
        "balance": balance_table(summary.balance),
        "sensing": sensing_table(summary),
        "priorities": priorities_table(summary.priorities),
        "claims": claims_table(claims),
    }


def outcomes_table(summary: Summary) -> Table:
    """How trials ended, what that means, and what was said of them."""
    columns = (Column("outcome"), *SHARES, Column("meaning"), Column("details"))
    rows = tuple(
        (
            entry.outcome,
            entry.count,
            entry.share,
            entry.interval,
            entry.means,
            "; ".join(f"{said.detail} (trial {trials_named(said.trials)})" for said in entry.details),
        )
        for entry in summary.outcome_table
    )
    return Table("How trials ended", columns, rows)


def unconverged_table(summary: Summary) -> Table:
    """What was said most often of each outcome but convergence."""
    return reasons_table(
        "Why trials did not converge, mostly",
        [
            (entry.outcome, entry.details[0].detail, len(entry.details[0].trials), entry.count)
            for entry in summary.outcome_table
            if entry.outcome != Outcome.CONVERGED.value and entry.details
        ],
    )


def reasons_table(title: str, reasons: Sequence[tuple[str, str, int, int]]) -> Table:
    """Outcomes, each with what was said most often, of how many, and how many there are."""
    rows = tuple(
        (outcome, said if count == whole else f"{said} ({count} of {whole})") for outcome, said, count, whole in reasons
    )
    return Table(title, (Column("outcome"), Column("what was said")), rows)


def stages_table(summary: Summary) -> Table:
    """A row for each stage."""
    rows = tuple(
        (
            one.name,
            one.trials,
            one.ended,
            one.went_back,
            one.ticks,
            one.force_residual,
            one.moment_residual,
        )
        for one in summary.stages
    )
    columns = (
        Column("stage"),
        Column("trials", COUNT),
        Column("ended", COUNT),
        Column("went back", COUNT),
        Column("ticks", WHOLE),
        Column("‖ρ_f‖", RESIDUAL),
        Column("‖ρ_m‖", MILLIMETRES),
    )
    controllers = ", then ".join(one.controller for one in summary.stages)
    medians = f"Medians of ticks in a stage, and of residuals where the next took over{lost_said(summary)}."
    note = f"{medians} Controllers: {controllers}."
    return Table("Stages: in which of them trials ended", columns, rows, note)


def modes_table(summary: Summary) -> Table:
    """The modes of the end orientation, each with the medians of its trials."""
    columns = (
        Column("mode", Format(lambda rank: f"mode {rank}")),
        Column("peak", RADIANS),
        *SHARES,
        Column("‖ρ_f‖", RESIDUAL),
        Column("ε_f = ‖ρ_f‖²", SQUARED),
        Column("‖ρ_m‖", MILLIMETRES),
        Column("ε_m = ‖ρ_m‖²", SQUARED_MILLIMETRES),
    )
    rows = [
        (rank, *_shares(mode), mode.force_residual, mode.force_squared, mode.moment_residual, mode.moment_squared)
        for rank, mode in enumerate(summary.modes, 1)
    ]
    rows += [(Value(STOPPED, WORDS), None, *stopped, None, None, None, None) for stopped in _stopped(summary)]
    note = f"Modes are {modes_said(summary)}. Residuals: medians over a mode's trials."
    return Table("Modes of the end orientation", columns, tuple(rows), note)


def brief_modes_table(summary: Summary) -> Table:
    """The modes with fewer columns."""
    columns = (
        Column("orientation", RADIANS, left=True),
        *SHARES,
        Column("‖ρ_f‖", RESIDUAL),
        Column("‖ρ_m‖", MILLIMETRES),
    )
    rows = [(*_shares(mode), mode.force_residual, mode.moment_residual) for mode in summary.modes]
    rows += [(Value(STOPPED, WORDS), *stopped, None, None) for stopped in _stopped(summary)]
    return Table("Where grasps ended: modes of orientation, with medians", columns, tuple(rows), modes_said(summary))


def modes_said(summary: Summary) -> str:
    """What the modes are of, and that one is no proof that there is no other."""
    settled = summary.modes[0].of if summary.modes else 0
    said = f"of {counted(settled, 'trial', 'trials')} that settled in contact"
    if len(summary.modes) == 1 and settled < FEWEST:
        said += f"; fewer than {FEWEST} cannot show a second mode"
    elif len(summary.modes) == 1:
        said += f"; no second mode could be shown, at a level of {percent(LEVEL)}"
    if summary.stopped.trials:
        said += f"; stopped ones: of {summary.stopped.of} that ended in contact"
    return said + lost_said(summary)


def lost_said(summary: Summary) -> str:
    """How many trials cannot be told of; nothing where all can."""
    trials = counted(len(summary.lost), "trial", "trials")
    return f"; {trials} left out, with trajectories that cannot be read" if summary.lost else ""


def _stopped(summary: Summary) -> list[tuple[object, ...]]:
    """The row of the trials that a monitor stopped, where there are any."""
    stopped = summary.stopped
    return [(len(stopped.trials), stopped.share, stopped.interval)] if stopped.trials else []


def _shares(mode: ModeSummary) -> tuple[object, ...]:
    return mode.centre, len(mode.trials), mode.share, mode.interval


def residuals_table(summary: Summary) -> Table:
    """Residuals and squared errors before and after, medians over trials."""
    rows = tuple(
        (label, *(Value(end, form) for end in (found.start, found.end, found.end_in_contact)))
        for label, found, form in (
            ("force residual ‖ρ_f‖", summary.force, RESIDUAL),
            ("ε_f = ‖ρ_f‖²", summary.force_squared, SQUARED),
            ("moment residual ‖ρ_m‖ (mm)", summary.moment, MILLIMETRES),
            ("ε_m = ‖ρ_m‖² (mm²)", summary.moment_squared, SQUARED_MILLIMETRES),
        )
    )
    names = ("start", "end", "end, all contacts touching")
    columns = (Column("median over trials"), *(Column(name, TEXT) for name in names))
    return Table("Residuals at start and end", columns, rows)


def measured_table(summary: Summary) -> Table:
    """What was measured, start and end."""
    force, moment = summary.force, summary.moment
    start, end = _range(summary.orientation_start), _range(summary.orientation_end)
    pressed = _range([summary.least_contact_force, summary.largest_contact_force])
    rows: list[tuple[str, object, object, Format]] = [
        ("force residual ‖ρ_f‖", force.start, force.end, RESIDUAL),
        ("moment residual ‖ρ_m‖", moment.start, moment.end, MILLIMETRES),
        ("orientation, range", start, end, _span("rad")),
        ("contact force, range *", "", pressed, _span("N")),
        ("object moved", "", summary.object_shift, MILLIMETRES),
        ("  at most", "", summary.largest_object_shift, MILLIMETRES),
        ("ticks or probes to converge *", "", summary.ticks_to_converge, WHOLE),
        ("  9 in 10 within", "", summary.ticks_to_converge_p90, WHOLE),
        ("tactile samples *", "", summary.samples, WHOLE),
        ("probes, all trials", "", summary.probes or "", WHOLE),
        ("time of a trial *", "", summary.trial_s, SECONDS),
        *_disturbances(summary),
    ]
    return Table(
        "What was measured: medians over trials",
        (Column(""), Column("start", TEXT), Column("end", TEXT)),
        tuple(
            (label, *("" if value == "" else Value(value, form) for value in (before, after)))
            for label, before, after, form in rows
            if after != ""
        ),
        "* of converged trials",
    )


def balance_table(found: Holding) -> Table:
    """What acts on the object in converged grasps, and what is left over."""
    loads = {**found.parties, "together": found.together} if found.together else {}
    rows = tuple((_PARTIES[party], load.across, load.up, load.moment) for party, load in loads.items())
    columns = (Column("on the object"), Column("across", _FORCE), Column("up", _FORCE), Column("moment", _MOMENT))
    note = f"{found.says} In brackets: percentiles 10 to 90 of {counted(found.trials, 'trial', 'trials')}."
    return Table("What holds converged grasps: medians", columns, rows, note)


_PARTIES = {
    "contacts": "contacts of the fingertips",
    "links": "other links of the robot",
    "table": "the table",
    "gravity": "gravity",
    "together": "together: what is left over",
}


def _middle(digits: int, unit: str, scale: float = 1.0) -> Format:
    """Medians of spreads; what is rounded to nothing has no sign."""
    return Format(
        lambda found: f"{round(scale * found.median, digits) + 0.0:.{digits}f}",
        lambda found: scale * found.median,
        unit,
        parts=(
            ("median", lambda found: scale * found.median),
            ("p10", lambda found: scale * found.low),
            ("p90", lambda found: scale * found.high),
        ),
    )


_FORCE, _MOMENT = _middle(3, "N"), _middle(1, "mN·m", 1e3)


def _disturbances(summary: Summary) -> Iterator[tuple[str, object, object, Format]]:
    """How far each level that others are subject to was disturbed in one tick or probe."""
    for level in summary.priorities.certified:
        seen = level.observed
        yield f"{level.name} disturbed in a tick, at most", "", seen.median, seen.format
        yield f"  trial {seen.trial}, by {seen.cause}", "", seen.largest, seen.format


def _span(unit: str, form: str = ".2f") -> Format:
    return Format(lambda ends: f"{ends[0]:{form}} … {ends[1]:{form}}", lambda ends: float(ends[0]), unit, parts=ENDS)


def _range(values: Sequence[float | None]) -> tuple[float, float] | None:
    known = [value for value in values if value is not None]
    return (min(known), max(known)) if known else None


def starts_tables(summary: Summary) -> list[Table]:
    """Why draws of a start could not be taken up, and what that made of the starts; nothing where all could be."""
    if not summary.starts.rejected:
        return []
    rejected, kept = rejected_table(summary), kept_table(summary)
    reason, draws, share = rejected.columns
    columns = (reason, draws, replace(share, label="share of all draws"))
    tables = [
        replace(rejected, title="Draws that could not be taken up", columns=columns),
        replace(
            kept,
            title="Starts, asked for and kept",
            columns=(Column("number of a start"), Column("asked for", TEXT), Column("kept", TEXT)),
            rows=tuple(
                (_with_unit(name, found.unit), *row[1:])
                for (name, found), row in zip(summary.starts.parameters.items(), kept.rows, strict=True)
            ),
            note="Quantiles: 5 %, 50 % and 95 %.",
        ),
    ]
    return [table for table in tables if table.rows]


def rejected_table(summary: Summary) -> Table:
    """Why draws of a start could not be taken up."""
    draws = summary.starts.draws
    rows = tuple((reason, count, Value((count, draws), _OF_DRAWS)) for reason, count in summary.starts.rejected.items())
    columns = (Column("reason"), Column("draws", COUNT), Column("share", SHARE))
    return Table("Why draws of a start could not be taken up", columns, rows)


_OF_DRAWS = Format(lambda pair: percent(pair[0] / pair[1]), lambda pair: pair[0] / pair[1])


def kept_table(summary: Summary) -> Table:
    """The quantiles of starts, asked for and kept."""

    rows = tuple(
        (name, *(Value(values, _quantiles(found.unit)) for values in (found.asked, found.kept)))
        for name, found in summary.starts.parameters.items()
    )
    columns = (Column(""), Column("asked", TEXT), Column("kept", TEXT))
    return Table("Starts, asked for and kept: 5 %, 50 % and 95 % quantiles", columns, rows)


def _quantiles(unit: str) -> Format:
    return Format(
        lambda values: "  ".join(f"{value:.3g}" for value in values),
        itemgetter(1),
        unit,
        parts=(("p5", itemgetter(0)), ("p50", itemgetter(1)), ("p95", itemgetter(2))),
    )


def sensing_table(summary: Summary) -> Table:
    """The errors of sensed contact points and normals."""
    ends = (
        ("contact point (mm)", MILLIMETRES_FINELY, summary.point_error_p50, summary.point_error_p95),
        ("contact normal (°)", DEGREES, summary.normal_error_p50, summary.normal_error_p95),
    )
    rows = tuple((label, *(Value(error, form) for error in errors)) for label, form, *errors in ends)
    columns = (Column("error of the sensed"), Column("50th percentile", TEXT), Column("95th percentile", TEXT))
    return Table("Sensing error", columns, rows)


def quality_tables(quality: Quality) -> list[Table]:
    """The grades of final grasps: verdicts, measures, verdicts side by side; nothing where none is graded."""
    found = list(quality.grades.values())
    passing = [one for one in found if one.passed is not None]
    tables = [_verdicts(passing)] if passing else []
    tables += [_measures(one) for one in found if one.medians]
    if found and quality.confusion.of:
        tables.append(_side_by_side(quality.confusion))
    if passing:
        tables.append(_by_outcome(quality.confusion, passing))
    if quality.conventions:
        tables[0] = replace(tables[0], note=f"{tables[0].note} {judged_by(quality.conventions)}")
    return tables


def _verdicts(grades: Sequence[GradeSummary]) -> Table:
    rows = tuple(
        (one.grade.label, one.passed.passed, one.passed.of, one.passed.share, one.passed.interval, one.reasons)
        for one in grades
        if one.passed is not None
    )
    columns = (Column("grade"), Column("passed", COUNT), Column("of", COUNT), *SHARES[1:], Column("why not", REASONS))
    note = " ".join([*(one.grade.definition for one in grades), "Trials that could not begin are not counted."])
    return Table("Verdicts", columns, rows, note)


def _measures(found: GradeSummary) -> Table:
    grade, medians = found.grade, found.medians
    rows = tuple(
        (
            _with_unit(one.label, one.unit),
            Value(medians[one.key].median, scaled(one.form, one.unit)),
            Value(medians[one.key].range, _span(one.unit, one.form)),
            medians[one.key].of,
        )
        for one in grade.quantities
    )
    columns = (Column("measure"), Column("median", TEXT), Column("range", TEXT), Column("trials", COUNT))
    if grade.passed:  # the verdicts say what it is, and why not
        return Table(grade.label, columns, rows)
    missing = f" Without a measure: {reasons_named(found.reasons)}." if found.reasons else ""
    return Table(grade.label, columns, rows, grade.definition + missing)


def _with_unit(label: str, unit: str) -> str:
    return f"{label} ({unit})" if unit else label


def _side_by_side(confusion: Confusion) -> Table:
    names = [name for name in confusion.table[0] if name != "trials"]
    rows = tuple(
        (*("yes" if cell[name] else "no" for name in names), cell["trials"])
        for cell in confusion.table
        if cell["trials"]
    )
    columns = (*(Column(name.replace("_", " ")) for name in names), Column("trials", COUNT))
    note = "Converged: by the residuals. Kept: by the simulator, shaken where there was a shake, else lifted."
    return Table("Verdicts side by side", columns, rows, note)


def _by_outcome(confusion: Confusion, grades: Sequence[GradeSummary]) -> Table:
    rows = tuple(
        (outcome, row["trials"], *(row[one.grade.key] for one in grades)) for outcome, row in confusion.outcomes.items()
    )
    columns = (
        Column("outcome"),
        Column("trials", COUNT),
        *(Column(f"{one.grade.label} passed", COUNT) for one in grades),
    )
    return Table("Verdicts by outcome", columns, rows)


def brief_quality_table(quality: Quality) -> Table:
    """How many grasps passed each grade, by outcome, and the medians of measures."""
    grades = [one for one in quality.grades.values() if one.passed is not None]
    rows = [
        (outcome, *(f"{row[one.grade.key]} of {row['trials']}" for one in grades))
        for outcome, row in quality.confusion.outcomes.items()
    ]
    shares = [f"{percent(one.passed.share)} ({percents(one.passed.interval)})" for one in grades if one.passed]
    rows.append(("all, 95 % interval", *shares))
    notes = []
    for one in quality.grades.values():
        medians = [
            f"{quantity.label} {scaled(quantity.brief, quantity.unit).written(found.median, with_unit=True)}"
            for quantity in one.grade.quantities
            if (found := one.medians[quantity.key])
        ]
        notes += [f"{one.grade.column or one.grade.label}, medians: {', '.join(medians)}"] if medians else []
    columns = (Column(""), *(Column(one.grade.column, TEXT) for one in grades))
    note = ". ".join(
        ["; ".join(notes), *([judged_by(quality.conventions).removesuffix(".")] if quality.conventions else [])]
    )
    return Table("How good the grasps are, by outcome", columns, tuple(rows), note)


def judged_by(found: Conventions) -> str:
    """By what conventions the grasps of a run were judged, in a sentence or two."""
    scale = f"Moments are over a torque scale of {1000 * found.torque_scale:.3g} mm, {found.scale}, for all grasps."
    models = "; ".join(f"{model} ({counted(count, 'grasp', 'grasps')})" for model, count in found.models.items())
    return f"{scale} Contacts: {models}; {found.edges} edges to a friction cone." if models else scale


def claims_table(claims: Sequence[Claim]) -> Table:
    """What the chapter says of this experiment, and what was measured."""
    rows = tuple(
        (claim.says, claim.over, claim.bound, claim.measured, claim.verdict.mark, claim.why or claim.could_fail)
        for claim in claims
    )
    heads = ("the chapter says", "over", "agrees if", "measured", "verdict", "why, or how it could have failed")
    columns = tuple(map(Column, heads))
    note = (
        "Agrees: the 95 % interval of what was measured lies within the bound. Differs: it lies outside. Cannot be "
        "told: neither, or too few trials ended. No evidence: no run of this spec could show anything else. "
        "Control begins where the controller takes over from the guarded close; 20 s of it are the chapter's 1000 "
        "iterations. Intervals of shares are those of Clopper and Pearson here."
    )
    return Table("The chapter's claims", columns, rows, note)


def trials_table(summary: Summary, tick: str) -> Table:
    """The trials one by one."""
    records = summary.records
    note = f"The first {MOST_ROWS} of {len(records)} trials." if len(records) > MOST_ROWS else ""
    columns = (
        Column("trial", COUNT),
        Column("outcome"),
        Column("orientation, start", fixed(3, "rad")),
        Column("end", fixed(3, "rad")),
        Column("‖ρ_f‖, start", RESIDUAL),
        Column("end", RESIDUAL),
        Column("‖ρ_m‖, start", MILLIMETRES),
        Column("end", MILLIMETRES),
        Column("contact forces", _FORCES),
        Column("object moved", MILLIMETRES),
        Column(tick, COUNT),
        Column(f"{tick} to converge", WHOLE),
        Column("samples", COUNT),
        Column("simulated", SECONDS),
        Column("details"),
    )
    return Table("Trials", columns, tuple(map(_trial, records[:MOST_ROWS])), note)


_FORCES = Format(lambda forces: ", ".join(f"{force:.2f}" for force in forces), max, "N")


def _trial(record: TrialRecord) -> tuple[object, ...]:
    return (
        record.number,
        record.outcome.value,
        record.orientation_start,
        record.orientation_end,
        record.force_residual_start,
        record.force_residual_end,
        record.moment_residual_start,
        record.moment_residual_end,
        [force for force in record.contact_forces if math.isfinite(force)] or None,
        record.object_shift,
        record.ticks,
        record.ticks_to_converge,
        record.samples,
        record.world_s,
        record.detail,
    )
