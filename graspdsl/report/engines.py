"""A spec on several engines, time steps and solver efforts: what each run did, and whether they say the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graspdsl.report.agreement import Against, Known, Row, against, rows_of
from graspdsl.report.judgements import Verdict
from graspdsl.report.statistics import Interval
from graspdsl.report.summary import Summary
from graspdsl.report.tables import COUNT, TEXT, WORDS, Column, Format, Table, fixed
from graspdsl.report.wording import counted, percent, percents
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.variants import Variant

METHODS = (
    "Trials are paired by number where they began alike. Two runs agree in a quantity where the 95 % interval of what "
    "was measured lies within its bound, and differ where it lies outside; else, or of too few trials, it cannot be "
    "told. Intervals of shares are exact, those of medians of order statistics. Orientation, residuals and forces are "
    "of pairs that both converged: the median size of their differences is judged, of forces that of the contact that "
    "differs most."
)


@dataclass(frozen=True, slots=True)
class EngineRun:
    """What one of the runs did; ``command`` runs it again. time_step [s]; ``modes``: the peak [rad] and the share of
    each."""

    label: str
    run: str
    command: str
    world: str
    time_step: float
    solver_iterations: int
    asked: int
    finished: int
    converged: int
    share: float | None
    interval: Interval
    modes: tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True)
class Engines:
    """All of it; ``against``: every run but the first held against its measure."""

    name: str
    seed: int
    settings: tuple[str, ...]
    runs: tuple[EngineRun, ...]
    against: tuple[Against, ...]

    def title(self, found: Against) -> str:
        """Which run is held against which, by its label."""
        return f"{self.runs[found.run].label} against {self.runs[found.measure].label}"


def engines(variants: Sequence[Variant], runs: Sequence[Known], settings: Sequence[str] = ()) -> Engines:
    """What the runs of variants say together. ``settings``: those that all of them have."""
    first = runs[0][1]
    return Engines(
        *(first.name, first.seed, tuple(settings)),
        tuple(_run(variant, summary) for variant, (_, summary) in zip(variants, runs, strict=True)),
        tuple(against(runs, place, variant.measure) for place, variant in enumerate(variants) if place),
    )


def _run(variant: Variant, summary: Summary) -> EngineRun:
    return EngineRun(
        *(
            variant.label,
            summary.run,
            summary.command,
            variant.world,
            variant.effort.time_step,
            variant.effort.solver_iterations,
        ),
        *(summary.asked, summary.finished, summary.count(Outcome.CONVERGED)),
        *(summary.converged.share, summary.converged.interval),
        tuple((mode.centre, mode.share) for mode in summary.modes),
    )


def said_of(found: Engines) -> str:
    """How much agrees, differs and cannot be told, in a sentence."""
    verdicts = [judgement.verdict for pair in found.against for judgement in pair.judgements]
    agree, differ, untold = (verdicts.count(kind) for kind in (Verdict.AGREES, Verdict.DIFFERS, Verdict.UNTOLD))
    return f"{agree} of {len(verdicts)} points agree; differ: {differ}; cannot be told: {untold}."


_MODES = Format(lambda modes: ", ".join(f"{centre:.2f} rad: {percent(share)}" for centre, share in modes), words=True)


def runs_table(found: Engines) -> Table:
    """What each run did."""
    columns = (
        Column("run"),
        Column("time step", fixed(2, "ms", 1e3)),
        Column("iterations", COUNT),
        Column("trials", COUNT),
        Column("converged", TEXT),
        Column("modes", _MODES),
    )
    rows = tuple(
        (
            *(run.label, run.time_step, run.solver_iterations, run.finished),
            *(f"{percent(run.share)}, {percents(run.interval)}", run.modes),
        )
        for run in found.runs
    )
    return Table("Runs", columns, rows)


def agreement_tables(found: Engines) -> list[Table]:
    """For each run, how far it agrees with its measure."""
    columns = tuple(map(Column, ("quantity", "agrees if", "measured", "verdict")))
    return [
        Table(
            f"{found.title(pair)}: {counted(pair.outcome.pairs, 'pair', 'pairs')}, both converged in "
            f"{pair.outcome.converged[0]}",
            columns,
            tuple(map(_cells, rows_of(pair))),
        )
        for pair in found.against
    ]


def _cells(row: Row) -> tuple[str, ...]:
    what, bound, measured, judgement = row
    untold = judgement.verdict is Verdict.UNTOLD and judgement.needed
    return what, bound, measured, judgement.verdict.mark + (f": some {judgement.needed} can" if untold else "")


def outcomes_table(found: Engines) -> Table:
    """The pairs whose outcomes differ, and how many of both runs converged."""
    rows = []
    for pair in found.against:
        outcome = pair.outcome
        apart = "; ".join(f"{one} → {other} ({count})" for one, other, count in outcome.apart)
        shift = outcome.shift
        points = None
        if shift is not None and shift.interval is not None:
            low, high = shift.interval
            points = f"{100 * shift.value:+.0f} points, {100 * low:+.0f} to {100 * high:+.0f}"
        rows.append((found.runs[pair.run].label, *outcome.converged, points, apart or "none"))
    columns = (
        Column("run"),
        Column("both", COUNT),
        Column("measure only", COUNT),
        Column("run only", COUNT),
        Column("neither", COUNT),
        Column("difference", TEXT),
        Column("other outcomes, measure → run", WORDS),
    )
    return Table("Which of each pair converged, the run or its measure", columns, tuple(rows))
