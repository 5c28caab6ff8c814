"""What became of the levels that others are subject to: which was disturbed, how far, when and by what."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from graspdsl.compiler.known import protection, summed_plainly
from graspdsl.compiler.pipeline import Priority
from graspdsl.report.evidence import Evidence
from graspdsl.report.statistics import median
from graspdsl.report.tables import COUNT, Column, Format, Table, Value, fixed, scaled
from graspdsl.trials.priorities import Largest, level_names

ROUNDING = 1e-9  # of any unit


def scale_of(unit: str) -> tuple[str, float]:
    """The unit that disturbances in another are told in, and how many of it are in one of those."""
    return {"m": ("mm", 1e3), "m²": ("mm²", 1e6), "1": ("", 1.0)}.get(unit, (unit, 1.0))


@dataclass(frozen=True, slots=True)
class Worst:
    """The largest disturbance in one tick or probe over all trials, in the level's ``unit``; of which ``trial``, after
    what time, and its largest cause; ``median``: over trials, of the largest of each."""

    largest: Annotated[float, "its unit"]
    unit: str
    trial: int
    tick: int
    time: Annotated[float, "s"]
    cause: str
    median: Annotated[float, "its unit"]

    @property
    def format(self) -> Format:
        """How its numbers are written."""
        return scaled(".2g", *scale_of(self.unit))

    def written(self, size: float) -> str:
        """A disturbance with its unit."""
        return self.format.written(size, with_unit=True)


@dataclass(frozen=True, slots=True)
class LevelSummary:
    """What became of a level of a stage in ``trials`` trials, beyond what the level alone would have done: by its
    Jacobian and the command (``predicted``), and as the next tick showed it (``observed``).

    ``place``: of the level among those of its stage, highest first, as in trajectories;
    ``protects``: what of it is kept from what is below; ``plain_sum``: whether nothing is, as ◁ is a plain sum;
    ``rank``: the least of the null space below. ``stiffness`` [N/m]: the median of those seen, of forces.
    ``in_several``: whether another stage has a level of this symbol.
    """

    stage: int
    place: int
    level: str
    about: str
    protects: str
    plain_sum: bool
    rank: int
    trials: int
    predicted: Worst
    observed: Worst
    stiffness: Annotated[float | None, "N/m"]
    in_several: bool = False

    @property
    def name(self) -> str:
        """What it is called: by its stage, as others are counted, where another has a level of its symbol."""
        return f"{self.level} in stage {self.stage + 1}" if self.in_several else self.level

    def said(self, each: str) -> str:
        """In a sentence; ``each``: what a step is, a tick or a probe."""
        if self.plain_sum:
            return f"{self.name}: ◁ is a plain sum here, which projects nothing, so that there is nothing to certify."
        seen, told = self.observed, self.predicted
        most = f"{self.name} ({self.about}) was disturbed by up to {seen.written(seen.largest)} in one {each}"
        when = f"in trial {seen.trial} after {seen.time:.1f} s, by {seen.cause}"
        usual = f"in the median trial by up to {seen.written(seen.median)}"
        if told.largest <= ROUNDING:
            return f"{most}, {when}; {usual}. By its Jacobian the command disturbs it by nothing."
        pressing = " of pressing" if told.unit != seen.unit else ""
        command = f"up to {told.written(told.largest)}{pressing}, mostly by {told.cause}"
        return f"{most}, {when}; {usual}. By its Jacobian the command disturbs it by {command}."


@dataclass(frozen=True, slots=True)
class Priorities:
    """The levels of a run that others are subject to and that any tick has shown, in the order of stages."""

    levels: tuple[LevelSummary, ...]

    @property
    def certified(self) -> tuple[LevelSummary, ...]:
        """Those that something is to be kept from."""
        return tuple(level for level in self.levels if not level.plain_sum)


def priorities(evidence: Evidence) -> Priorities:
    """What became of the priorities of a run."""
    program = evidence.program
    graphs = [graph for phase in program.phases for graph in phase.executed(program.target)]
    pipelines = [pipeline for stages in program.pipelines() for pipeline in stages]
    found = []
    for stage, (graph, pipeline) in enumerate(zip(graphs, pipelines, strict=True)):
        sums = summed_plainly(graph, program.spec.control)
        named = zip(pipeline.priorities, level_names(pipeline.priorities), strict=True)
        for place, (priority, name) in enumerate(named):
            found.append(_summed_up(evidence, stage, place, priority, name, plain=priority.controller in sums))
    levels = [level for level in found if level is not None]
    stages = Counter(level.level for level in levels)
    return Priorities(tuple(replace(level, in_several=stages[level.level] > 1) for level in levels))


def _summed_up(
    evidence: Evidence, stage: int, place: int, priority: Priority, name: str, *, plain: bool
) -> LevelSummary | None:
    ones = [
        (record.number, one)
        for record in evidence.records
        for one in record.priorities
        if (one.stage, one.level) == (stage, name)
    ]
    if not ones:
        return None
    stiff = [one.stiffness for _, one in ones if one.stiffness is not None]
    return LevelSummary(
        stage=stage,
        place=place,
        level=name,
        about=priority.controller.potential.space.name,
        protects=protection(evidence.program.spec.control),
        plain_sum=plain,
        rank=min(one.rank for _, one in ones),
        trials=len(ones),
        predicted=_worst([(number, one.predicted) for number, one in ones], priority.effect_unit),
        observed=_worst([(number, one.observed) for number, one in ones], priority.unit),
        stiffness=median(stiff),
    )


def _worst(ones: Sequence[tuple[int, Largest]], unit: str) -> Worst:
    number, most = max(ones, key=lambda one: one[1].size)
    usual = float(np.median([one.size for _, one in ones]))
    return Worst(most.size, unit, number, most.tick, most.time, most.cause, usual)


def priorities_table(found: Priorities) -> Table:
    """The levels one by one."""
    rows = tuple(
        (
            level.name,
            kind,
            *(Value(size, worst.format) for size in (worst.median, worst.largest)),
            worst.format.unit,
            worst.trial,
            worst.time,
            worst.cause,
            level.rank,
        )
        for level in found.certified
        for kind, worst in (
            ("of the command, by its Jacobian", level.predicted),
            ("seen in the next tick", level.observed),
        )
    )
    numbers = ("median trial", "largest")
    columns = (
        Column("level"),
        Column("disturbance"),
        *(Column(name, scaled(".2g")) for name in numbers),
        Column("unit"),
        Column("in trial", COUNT),
        Column("after", fixed(1, "s")),
        Column("mostly by"),
        Column("null space, rank", COUNT),
    )
    return Table("Disturbance of higher priorities", columns, rows)
