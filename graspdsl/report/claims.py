"""The chapter's experiments as claims, each held against what a run of the experiment measured (Sec. 4.5).

A claim agrees where the 95 % interval of what was measured lies within its bound, differs where it lies outside, and
else, or where too few trials ended for an interval, cannot be told. What a run could not have shown otherwise is no
evidence, and not judged.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from graspdsl.report.evidence import Evidence
from graspdsl.report.experiment_runs import FIXED_TIME, ExperimentRun
from graspdsl.report.experiment_setups import departure
from graspdsl.report.judgements import Judgement, Verdict
from graspdsl.report.points import EXPERIMENTS, Point
from graspdsl.report.questions import Found
from graspdsl.report.statistics import FEWEST
from graspdsl.report.wording import NOTHING, counted

NOT_FIXED = (
    "trials of this run end as soon as residuals are as low as the spec asks for, or before "
    f"{FIXED_TIME:g} s: what they are then follows from that. With full_time: true and a limit of {FIXED_TIME:g} s or "
    "more it is judged"
)


@dataclass(frozen=True, slots=True)
class Claim:
    """One point of the chapter, and what a run says of it.

    ``says``: what the chapter says, in ``source``. over: which trials what was ``measured`` is of. ``bound``: what has
    to hold for it to agree, ``derived``: where that comes from. ``could_fail``: what a run would have shown otherwise;
    nothing where none could. needed: about how many trials would tell, where it cannot be told from those there are;
    None also where no number would. ``why`` it does not agree.
    """

    experiment: str
    says: str
    source: str
    over: str
    bound: str
    derived: str
    measured: str
    verdict: Verdict
    needed: int | None
    why: str
    could_fail: str


def claims_of(evidence: Evidence) -> list[Claim]:
    """The claims of the experiment that a run is of; none for a run of something else, whatever its name."""
    name = evidence.program.spec.name
    return [] if name not in EXPERIMENTS or departure(evidence.program) else list(held_against(name, evidence))


def held_against(experiment: str, evidence: Evidence) -> Iterator[Claim]:
    """The points of an experiment held against a run, whatever it is of."""
    run = ExperimentRun(evidence)
    return (claim(experiment, point, run) for point in EXPERIMENTS[experiment])


def claim(experiment: str, point: Point, run: ExperimentRun) -> Claim:
    """A point of the chapter, and what a run says of it."""
    found = point.held(run)
    if point.fixed and not run.lasts:
        found = Found(NOTHING, NOTHING, found.measured, Judgement(Verdict.NO_EVIDENCE, 0), NOT_FIXED)
    verdict, why = found.judgement.verdict, found.why
    if verdict is Verdict.DIFFERS:
        why = why or point.why
    elif verdict is Verdict.UNTOLD:
        why = why or _why_untold(found.judgement, len(run.evidence.records))
    return Claim(
        experiment,
        point.says,
        point.source,
        point.over,
        found.bound,
        found.derived,
        found.measured,
        verdict,
        found.judgement.needed,
        why,
        "" if verdict is Verdict.NO_EVIDENCE else point.could_fail,
    )


def _why_untold(judgement: Judgement, whole: int) -> str:
    """How many trials a verdict would be of and how many it takes, and in a run of how many; of ``whole`` so far."""
    if not judgement.trials:
        return "there is no such trial" + (f": at least {judgement.needed} can tell" if judgement.needed else "")
    there = f"{counted(judgement.trials, 'such trial', 'such trials')} cannot tell"
    if judgement.needed is None:
        return f"{there}, nor would more like them"
    about = "at least" if judgement.trials < FEWEST else "about"
    if judgement.trials == whole:
        return f"{there}: {about} {judgement.needed} can"
    run = math.ceil(judgement.needed * whole / judgement.trials)
    return f"{there}: {about} {judgement.needed} can, in a run of {run}"
