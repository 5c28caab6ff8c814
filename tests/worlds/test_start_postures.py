"""Where the joints stand when a trial begins: found faster than by looking at every step, and found the same."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, robot
from graspdsl.objects.box import Box
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.worlds.bullet.hand import Tip
from graspdsl.worlds.bullet.settling import resting_pose
from graspdsl.worlds.bullet.start_postures import CLEARANCE, CLOSING_STEP, PRESHAPE, StartPostures
from graspdsl.worlds.kind import Anchor
from graspdsl.worlds.protocol import InfeasibleStartError, Start

from .scenes import ROBOT, ROLL, side_start

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
TRIO = robot("trio", "gantry")
MOST_ADDED = 20.0  # MB


class StepByStep(StartPostures):
    """Fingers closed as a person would say it: step by step, looking each time."""

    def _close_finger(self, posture: Array, motion: Array, joints: tuple[str, ...], tip: Tip, name: str) -> Array:
        links = self._hand.links_beyond(joints)
        ready = None
        for share in np.arange(0.0, 1.0, CLOSING_STEP / float(np.abs(motion).max())):
            candidate = posture + share * motion
            self._hand.place(candidate)
            distance = self._scene.distance_to_object(self._hand.body, tip.link, 1.0)
            if ready is not None and distance <= 0.0:
                return np.asarray(ready)
            if self._scene.clearance(self._hand.body, links - {tip.link}, 1.0) < CLEARANCE:
                ready = None
            elif distance >= PRESHAPE or (ready is None and distance >= CLEARANCE):
                ready = candidate
        raise InfeasibleStartError(name)


def found(postures: StartPostures, start: Start) -> Array | None:
    try:
        return postures.find(start)
    except InfeasibleStartError:
        return None


@pytest.fixture(
    params=[
        (ROBOT, ROLL),
        (TRIO, ROLL),
        (ROBOT, catalogue()["detergent-bottle"]),
        (ROBOT, Body("", Box(size=(0.08, 0.1, 0.2)), 0.2)),
    ],
    ids=["barrett-roll", "trio-roll", "barrett-bottle", "barrett-box"],
)
def scene(request: pytest.FixtureRequest) -> Iterator[tuple[Robot, Body, StartPostures, StartPostures]]:
    """A robot and an object, starts found fast and step by step."""
    robot, body = request.param
    resting = resting_pose(body, 0.5, 9.81)
    fast, slow = (kind(robot, body, Anchor.NONE, resting) for kind in (StartPostures, StepByStep))
    yield robot, body, fast, slow
    fast.close()
    slow.close()


def test_no_step_is_passed_over_that_matters(scene: tuple[Robot, Body, StartPostures, StartPostures]) -> None:
    _, body, fast, slow = scene
    random, feasible = np.random.default_rng(5), 0
    for _ in range(40):
        roll, height, standoff = random.uniform((-1.5, 0.02, 0.0), (1.5, 0.25, 0.15))
        start = side_start(body, roll=roll, height=height, standoff=standoff, tilt=random.normal(0.0, 0.3))
        expected, seen = found(slow, start), found(fast, start)
        assert (expected is None) == (seen is None)
        if expected is not None and seen is not None:
            feasible += 1
            assert np.array_equal(expected, seen)
    assert 0 < feasible < 40


def test_an_answer_does_not_depend_on_those_before_it() -> None:
    starts = [side_start(roll=roll, height=0.12, standoff=0.07) for roll in np.linspace(-1.2, 1.2, 9)]
    one = StartPostures(ROBOT, ROLL, Anchor.NONE, None)
    together = [found(one, start) for start in [*starts, *reversed(starts)]]
    one.close()
    for start, first, again in zip(starts, together, together[::-1], strict=False):
        alone = StartPostures(ROBOT, ROLL, Anchor.NONE, None)
        answer = found(alone, start)
        alone.close()
        assert all(np.array_equal(answer, other) for other in (first, again)) or (answer, first, again) == (None,) * 3
    assert any(answer is not None for answer in together)


@pytest.mark.parametrize(
    ("start", "reason"),
    [
        (side_start(height=1.2), "the object is farther away than the fingers are long"),
        (side_start(standoff=0.128), "without meeting the object"),
        (side_start(standoff=0.002), "another link"),
        (side_start(height=0.0, roll=math.pi / 2), "another link"),
        (replace(side_start(), posture={"base-1": 2.443}), "finger-1 starts closed"),
    ],
)
def test_why_a_start_cannot_be_taken_up(start: Start, reason: str) -> None:
    postures = StartPostures(ROBOT, ROLL, Anchor.NONE, None)
    with pytest.raises(InfeasibleStartError, match=reason):
        postures.find(start)
    postures.close()


RESETS = """
import sys
sys.path.insert(0, {tests!r})
from graspdsl.objects.shapes import catalogue
from graspdsl.worlds.bullet.world import BulletWorld
from worlds.scenes import settings, side_start

def resident():
    return int(open("/proc/self/statm").read().split()[1]) * 4096 / 1e6

body = catalogue()[{name!r}]
world = BulletWorld(settings(body=body), seen={seen})
for number in range({resets} + 10):
    world.reset(side_start(body, roll=0.3, height=0.1), number)
    world.close()
    if number == 9:
        before = resident()
print(resident() - before)
"""


def added(name: str, resets: int, *, seen: bool = False) -> float:
    """How much memory [MB] a process holds more after so many resets, ten of them before."""
    code = RESETS.format(tests=str(ROOT / "tests"), name=name, resets=resets, seen=seen)
    return float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the memory of a process is told by Linux")
@pytest.mark.parametrize(("name", "resets"), [("towel-roll", 300), ("squirt-bottle", 40)])
def test_resets_leave_nothing_behind(name: str, resets: int) -> None:
    assert added(name, resets) < MOST_ADDED * resets / 300 + 2.0


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the memory of a process is told by Linux")
def test_what_is_seen_does_and_that_would_be_noticed() -> None:
    """The engine keeps looks for good: this is what the test above would see, were they made."""
    assert added("towel-roll", 40, seen=True) > MOST_ADDED
