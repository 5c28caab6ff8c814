"""What a run's page says in sentences."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

from graspdsl.report.evidence import Evidence
from graspdsl.report.statistics import wilson
from graspdsl.report.wording import counted, feasible, percent, percents, repetition
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord

Numbers = Mapping[str, Any]


def verdict(numbers: Numbers) -> str:
    """Whether it worked, in a sentence with an interval."""
    finished, infeasible = numbers["trials"]["finished"], numbers["outcomes"].get(Outcome.INFEASIBLE_START.value, 0)
    if not finished:
        return "No trial has finished, so nothing is known."
    if infeasible == finished:
        return f"None of {counted(finished, 'trial', 'trials')} could begin: no start that was drawn was feasible."
    good = numbers["outcomes"].get(Outcome.CONVERGED.value, 0)
    conditional = f", {said}" if (said := feasible(numbers["starts"])) else ""
    return (
        f"{good} of {counted(finished, 'trial', 'trials')} converged: {percent(good / finished)} "
        f"(95 % interval {percents(wilson(good, finished))}){conditional}."
    )


def notes(evidence: Evidence, numbers: Numbers) -> list[str]:
    """What a reader must know to take the verdict for what it is."""
    asked, finished = numbers["trials"]["asked"], numbers["trials"]["finished"]
    infeasible = numbers["outcomes"].get(Outcome.INFEASIBLE_START.value, 0)
    good = numbers["outcomes"].get(Outcome.CONVERGED.value, 0)
    said = []
    if finished < asked:
        said.append(f"Only {finished} of {counted(asked, 'trial', 'trials')} are finished.")
    if repeated := repetition(numbers["trials"]):
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
