"""What is kept of a trial whose process ended before it did."""

from __future__ import annotations

from graspdsl.compiler.program import Program
from graspdsl.quality.grade import CRASHED
from graspdsl.trials.evaluation import Evaluation
from graspdsl.trials.loop import NOTHING
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord


def crashed(program: Program, number: int, identity: str, cause: str) -> Trial:
    """A trial of which nothing is known but what ended its process."""
    record = TrialRecord(
        number=number,
        identity=identity,
        outcome=Outcome.CRASHED,
        detail=cause,
        start={},
        rejected=(),
        ticks_to_converge=None,
        wall_s=0.0,
        quality=Evaluation(program).of_nothing(CRASHED),
        **NOTHING.numbers(0),
    )
    return Trial(record, {})
