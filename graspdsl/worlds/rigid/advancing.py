"""One tick of trials side by side in a world of rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from graspdsl.arrays import Array
from graspdsl.worlds.protocol import WorldCrashError, WorldInfo
from graspdsl.worlds.rigid.engine import Stages, Touched
from graspdsl.worlds.rigid.trial import RigidTrial

MOST_AHEAD = 0.05  # rad or m, of a target before its joint


def advance(
    trials: Sequence[RigidTrial], stages: Stages, info: WorldInfo, displacement: Array
) -> tuple[Touched, Mapping[int, str]]:
    """One tick of the first M of N trials on their stages, with the targets of their joints displaced by (M, n) [m or
    rad], within their limits; then the fingertips get the stiffness that belongs to how they press. Returns what
    touches what on all stages, and what is said of those that crashed, by their numbers.

    A joint that something holds up is not driven ever further ahead of where it is. The targets are led to where they
    are to be: such as jump once a tick would shake an object loose in the hand.
    """
    moving = trials[: len(displacement)]
    now, before = stages.joints()[: len(moving)], np.array([trial.target for trial in moving])
    wanted = np.clip(before + displacement, now - MOST_AHEAD, now + MOST_AHEAD)
    targets = np.clip(wanted, info.lower, info.upper)
    stopped = wanted != targets
    ramp = trials[0].ramp
    ways = before[:, None] + (targets - before)[:, None] * ramp
    crashed = dict[int, str]()
    for row, trial in enumerate(moving):
        trial.target, trial.ticks = targets[row], trial.ticks + 1
        trial.stopped = trial.stopped | stopped[row]
        try:
            trial.stage.simulate(ways[row], trial.tips.advance)
        except WorldCrashError as error:
            crashed[row] = str(error)
    for row in np.flatnonzero(~np.isfinite(stages.joints()).all(axis=-1)).tolist():
        crashed.setdefault(row, "a joint's position is not a number")
    touched = stages.touched()
    for trial, presses in zip(moving, touched.presses.tolist(), strict=False):
        trial.stage.hand.press(presses)
    return touched, crashed
