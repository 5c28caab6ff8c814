"""What lies on its round side: it stays where it is put, rolls when it is pushed, and does not lean as it rolls."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.shapes import Body
from graspdsl.objects.turned import Angles, posed
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.mujoco.effort import EFFORT
from graspdsl.worlds.mujoco.stages import MujocoEngine
from graspdsl.worlds.rigid.engine import Engine, Stage
from graspdsl.worlds.rigid.lean import Standing
from graspdsl.worlds.rigid.settling import resting_pose

pytestmark = pytest.mark.slow

CAN = Cylinder(diameter=0.08, height=0.2)
# As a user writes a quarter turn: a few millionths off, on which a can without friction rolled away.
LYING = Body("can", posed(CAN, Angles(rpy=(1.5708, 0.0, 0.0))), 0.4)


@pytest.fixture(params=["bullet", "mujoco"])
def engine(request: pytest.FixtureRequest) -> Engine:
    return BulletEngine() if request.param == "bullet" else MujocoEngine(EFFORT)


@pytest.fixture
def stage(engine: Engine) -> Iterator[Stage]:
    made = engine.table(LYING, 0.5, 9.81)
    made.scene.place(resting_pose(engine, LYING, 0.5, 9.81))
    yield made
    made.close()


def _wait(stage: Stage, engine: Engine, seconds: float) -> None:
    for _ in range(round(seconds / engine.time_step)):
        stage.step()


def test_it_stays_where_it_lies(stage: Stage, engine: Engine) -> None:
    before, rotation = stage.scene.object_pose()
    standing = Standing.of(rotation, LYING.shape)
    _wait(stage, engine, 5.0)
    after, rotation = stage.scene.object_pose()
    assert before[2] == pytest.approx(0.04, abs=1e-3)
    assert np.linalg.norm(after - before) < 1e-3
    assert standing.lean(rotation) < 0.01


def test_it_rolls_a_way_and_does_not_lean(stage: Stage, engine: Engine) -> None:
    before, rotation = stage.scene.object_pose()
    standing = Standing.of(rotation, LYING.shape)
    stage.scene.move(np.array([0.2, 0.0, 0.0]), np.array([0.0, 0.2 / 0.04, 0.0]))
    _wait(stage, engine, 1.0)
    after, rotation = stage.scene.object_pose()
    rolled = after[0] - before[0]
    assert 0.05 < rolled < 0.2
    up = rotation @ standing.up
    assert math.acos(up[2]) > 0.5  # what was up is not any more
    assert standing.lean(rotation) < 0.02


def test_it_leans_as_its_axis_does() -> None:
    standing = Standing.of(np.eye(3), LYING.shape)
    for angle in (0.3, -0.3):
        c, s = math.cos(angle), math.sin(angle)
        about_x = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
        about_y = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
        assert standing.lean(about_x) == pytest.approx(0.3, abs=1e-5)  # its axis is y: it stands up
        assert standing.lean(about_y) == pytest.approx(0.0, abs=1e-5)  # it rolls
        assert Standing.of(np.eye(3), CAN).lean(about_y) == pytest.approx(0.3)
