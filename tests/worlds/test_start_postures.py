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
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.protocol import InfeasibleStartError, Start
from graspdsl.worlds.rigid.settling import resting_pose
from graspdsl.worlds.rigid.start_postures import CLEARANCE, PRESHAPE, StartPostures

from .scenes import ROBOT, ROLL, settings, side_start

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
TRIO = robot("trio", "gantry")
MOST_ADDED = 20.0  # MB


class StepByStep(StartPostures):
    """Fingers closed as a person would say it: step by step, looking each time."""

    def _close_finger(
        self, posture: Array, motion: Array, joints: tuple[str, ...], tips: tuple[int, ...], name: str
    ) -> Array:
        links = self._hand.links_beyond(joints)
        ready = None
        for share in np.arange(0.0, 1.0, 1.0 / float((np.abs(motion) / self._steps).max())):
            candidate = posture + share * motion
            self._hand.place(candidate)
            distance = min(self._stage.distance(tip, 1.0) for tip in tips)
            if ready is not None and distance <= 0.0:
                return np.asarray(ready)
            if self._stage.clearance(links - {*tips}, 1.0) < CLEARANCE:
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
    resting = resting_pose(BulletEngine(), body, 0.5, 9.81)
    fast, slow = (
        kind(BulletEngine(), settings(robot=robot, body=body), resting) for kind in (StartPostures, StepByStep)
    )
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
    one = StartPostures(BulletEngine(), settings(), None)
    together = [found(one, start) for start in [*starts, *reversed(starts)]]
    one.close()
    for start, first, again in zip(starts, together, together[::-1], strict=False):
        alone = StartPostures(BulletEngine(), settings(), None)
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
    postures = StartPostures(BulletEngine(), settings(), None)
    with pytest.raises(InfeasibleStartError, match=reason):
        postures.find(start)
    postures.close()


RESETS = """
import ctypes, sys
sys.path.insert(0, {tests!r})
from graspdsl.objects.shapes import catalogue
from worlds.scenes import bullet_world, settings, side_start

def resident():
    # Without pages of files, which come and go as the system likes, nor freed memory that malloc has not given back.
    ctypes.CDLL(None).malloc_trim(0)
    said = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return int(said["RssAnon"].split()[0]) * 1024 / 1e6

body = catalogue()[{name!r}]
kept = []
for number in range({resets} + 10):
    if not number or {each}:
        world = bullet_world(settings(body=body))
        kept.append(world)
    world.reset(side_start(body, roll=0.3, height=0.1), number)
    if not {each}:
        world.close()
    if number == 9:
        before = resident()
print(resident() - before)
"""


def added(name: str, resets: int, *, each: bool = False) -> float:
    """How much memory [MB] a process holds more after so many resets, ten of them before; with a world for ``each``,
    none of which is closed."""
    code = RESETS.format(tests=str(ROOT / "tests"), name=name, resets=resets, each=each)
    return float(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout)


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the memory of a process is told by Linux")
@pytest.mark.parametrize(("name", "resets"), [("towel-roll", 300), ("squirt-bottle", 40)])
def test_resets_leave_nothing_behind(name: str, resets: int) -> None:
    assert added(name, resets) < MOST_ADDED * resets / 300 + 2.0


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the memory of a process is told by Linux")
def test_what_is_not_closed_does_and_that_would_be_noticed() -> None:
    assert added("towel-roll", 20, each=True) > MOST_ADDED
