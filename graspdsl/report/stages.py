"""The stages of 'a then b': in which of them trials ended, how long they were in each, and what it handed on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.known import written
from graspdsl.report.evidence import Evidence
from graspdsl.report.statistics import median
from graspdsl.spec.keeping import ALL
from graspdsl.trials.stages import Stage, stages_of


@dataclass(frozen=True, slots=True)
class StageSummary:
    """A stage: its number, from 0 over all phases, as in trajectories; its ``name`` in messages; its controller; how
    many trials were in it and ``ended`` in it; how often one before it was begun anew from it; the median of the
    ticks that a trial was in it, all visits together; and the medians of ‖ρ_f‖ (1) and ‖ρ_m‖ [m], by the simulator's
    truth, where it handed over to the next."""

    stage: int
    name: str
    controller: str
    trials: int
    ended: int
    went_back: int
    ticks: Annotated[float | None, "ticks or probes"]
    force_residual: Annotated[float | None, "1"]
    moment_residual: Annotated[float | None, "m"]


@dataclass(frozen=True, slots=True)
class _Visit:
    """Ticks that a trial was in a stage without a break; the stage after it, None where the trial ended; the residuals
    at the tick at which that took over."""

    stage: int
    ticks: int
    after: int | None
    force: float
    moment: float


def stage_summaries(evidence: Evidence) -> tuple[StageSummary, ...]:
    """What there is to say of each stage; nothing of a program none of whose phases has more than one, nor where not
    every tick is kept."""
    program = evidence.program
    controllers = [written(graph) for phase in program.phases for graph in phase.stages]
    if len(controllers) == len(program.phases) or program.spec.trials.keep != ALL:
        return ()
    visits = [list(_visits(evidence, record.number)) for record in evidence.records]
    names = [_named(stage, len(program.phases)) for stage in stages_of(program)]
    return tuple(
        _summary(number, name, controller, visits)
        for number, (name, controller) in enumerate(zip(names, controllers, strict=True))
    )


def _named(stage: Stage, phases: int) -> str:
    parts = [f"phase {stage.phase + 1}"] if phases > 1 else []
    return ", ".join([*parts, *filter(None, [stage.name])])


def _summary(number: int, name: str, controller: str, visits: Sequence[Sequence[_Visit]]) -> StageSummary:
    of_trial = [[visit for visit in trial if visit.stage == number] for trial in visits]
    inside = [found for found in of_trial if found]
    handed = [visit for found in inside for visit in found if visit.after is not None and visit.after > number]
    every = [visit for found in inside for visit in found]
    return StageSummary(
        stage=number,
        name=name,
        controller=controller,
        trials=len(inside),
        ended=sum(visit.after is None for visit in every),
        went_back=sum(visit.after is not None and visit.after < number for visit in every),
        ticks=median(float(sum(visit.ticks for visit in found)) for found in inside),
        force_residual=median(visit.force for visit in handed),
        moment_residual=median(visit.moment for visit in handed),
    )


def _visits(evidence: Evidence, number: int) -> Iterator[_Visit]:
    rows = evidence.trajectory(number)
    if not rows:
        return
    stage: Array = rows["stage"].astype(np.float64)
    begins = [0, *(np.flatnonzero(np.diff(stage)) + 1).tolist()]
    for begin, end in zip(begins, [*begins[1:], None], strict=True):
        last = end is None
        yield _Visit(
            stage=int(stage[begin]),
            ticks=(len(stage) if end is None else end) - begin,
            after=None if end is None else int(stage[end]),
            force=np.nan if last else float(rows["force_residual"][end]),
            moment=np.nan if last else float(rows["moment_residual"][end]),
        )
