"""The watch over many residuals against the monitor of one."""

from __future__ import annotations

import numpy as np

from graspdsl.basis.resources import ContactResource, ContactSet
from graspdsl.spec.monitors import MonitorBounds
from graspdsl.trials.measures import GraspMeasure
from graspdsl.trials.monitors import Monitors
from graspdsl.trials.stalling import StallWatch
from graspdsl.worlds.protocol import WorldInfo

GRASP = ContactSet("Γ", (ContactResource("γ1", ((0, 1.0),)),), 1)
RADIUS, WINDOW, STEPS = 0.05, 8, 60
BOUNDS = MonitorBounds()
INFO = WorldInfo(50.0, ("point-1",), (), np.zeros(0), np.zeros(0))


def test_many_are_watched_as_one_is() -> None:
    """Random residuals that fall for a while: the same step of giving up, whenever a row's stage began."""
    random = np.random.default_rng(3)
    falling = np.exp(-np.arange(STEPS)[:, None] * random.uniform(0.0, 0.02, 20))
    force = falling * random.uniform(0.9, 1.0, (STEPS, 20))
    moment = RADIUS * falling * random.uniform(0.9, 1.0, (STEPS, 20))
    anew = random.integers(0, 20, 20)
    watch = StallWatch(20, WINDOW, RADIUS, BOUNDS.progress.least)
    given_up = np.full(20, -1)
    for step in range(STEPS):
        watch.begin_anew(np.flatnonzero(anew == step))
        rows = np.flatnonzero(given_up < 0)
        given_up[rows[watch.watch(step, rows, force[step, rows], moment[step, rows])]] = step
    for row in range(20):
        monitors = Monitors(BOUNDS, GRASP, INFO, "palm", RADIUS, WINDOW, np.zeros(0))
        stalls = (
            monitors.has_stalled(GraspMeasure(force[step, row], moment[step, row], 0.0))
            for step in range(anew[row], STEPS)
        )
        alone = next((step for step, stalled in enumerate(stalls, anew[row]) if stalled), -1)
        assert given_up[row] == alone
    assert -1 in given_up
    assert len(set(given_up)) > 3
