"""The arm: its kinematics against the published table, its inverse kinematics, its limits while it slides."""

from __future__ import annotations

import math

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.hands.arm_reach import ArmReach
from graspdsl.hands.descriptions import joint_limits, robot
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.protocol import InfeasibleStartError
from graspdsl.worlds.rigid.world import RigidWorld
from graspdsl.worlds.start_pose import pose

from .scenes import LEVEL, ROLL, bullet_world, main_program, opened, settings

pytestmark = pytest.mark.slow

ARM = robot("barrett", "wam")
LOWER, UPPER = (np.array(limits) for limits in joint_limits(ARM))
ARM_JOINTS = len(ARM.mount.joints)
# a [m], α [rad], d [m]: standard Denavit-Hartenberg, the first origin 0.346 m above the base
TABLE = [
    (0.0, -math.pi / 2, 0.0),
    (0.0, math.pi / 2, 0.0),
    (0.045, -math.pi / 2, 0.55),
    (-0.045, math.pi / 2, 0.0),
    (0.0, -math.pi / 2, 0.3),
    (0.0, math.pi / 2, 0.0),
    (0.0, 0.0, 0.06),
]
LIMITS = [(-2.6, 2.6), (-2.0, 2.0), (-2.8, 2.8), (-0.9, 3.1), (-4.76, 1.24), (-1.6, 1.6), (-3.0, 3.0)]


def face_by_the_table(joints: Array) -> Array:
    """The (4, 4) pose of the mounting face in the world, by the table alone."""
    assert ARM.mount.base is not None
    whole = np.eye(4)
    whole[:3, 3] = np.add(ARM.mount.base.position, [0.0, 0.0, 0.346])
    for (a, alpha, d), angle in zip(TABLE, joints, strict=True):
        c, s, ca, sa = math.cos(angle), math.sin(angle), math.cos(alpha), math.sin(alpha)
        whole = whole @ np.array(
            [[c, -s * ca, s * sa, a * c], [s, c * ca, -c * sa, a * s], [0, sa, ca, d], [0, 0, 0, 1]]
        )
    return whole


@pytest.fixture(scope="module")
def world() -> RigidWorld:
    """The arm before the towel roll."""
    made = bullet_world(settings(robot=ARM))
    made.reset(pose("side", LEVEL, ROLL, ARM.hand.palm_surface), 0)
    return made


def test_limits_are_the_published_ones() -> None:
    np.testing.assert_array_equal(np.column_stack([LOWER, UPPER])[:ARM_JOINTS], LIMITS)


@pytest.mark.parametrize("seed", range(8))
def test_kinematics_follow_the_table(world: RigidWorld, seed: int) -> None:
    joints = np.random.default_rng(seed).uniform(LOWER, UPPER)
    world.hand.place(joints)
    position, rotation = world.hand.face_frame()
    expected = face_by_the_table(joints[:ARM_JOINTS])
    np.testing.assert_allclose(position, expected[:3, 3], atol=1e-5)
    np.testing.assert_allclose(rotation, expected[:3, :3], atol=1e-5)


@pytest.mark.parametrize("approach", ["side", "top"])
@pytest.mark.parametrize("roll", [-1.5, -0.6, 0.0, 0.8, 1.4])
def test_inverse_kinematics_reaches_within_the_limits(approach: str, roll: float) -> None:
    start = pose(approach, {**LEVEL, "roll": roll, "height": 0.12, "standoff": 0.06}, ROLL, ARM.hand.palm_surface)
    reach = ArmReach(ARM)
    found = reach.postures(start.position, start.rotation)
    assert len(found)
    for joints in found:
        assert ((joints >= LOWER[:ARM_JOINTS]) & (joints <= UPPER[:ARM_JOINTS])).all()
        reached = face_by_the_table(joints)
        np.testing.assert_allclose(reached[:3, 3], start.position, atol=1e-6)
        np.testing.assert_allclose(reached[:3, :3], start.rotation, atol=1e-6)
    assert reach.dexterity(found)[0] > 0.05


def test_a_singular_arm_or_one_at_a_limit_has_no_dexterity() -> None:
    stretched = np.zeros(ARM_JOINTS)
    at_limit = np.where(np.arange(ARM_JOINTS) == 3, UPPER[:ARM_JOINTS], 0.4)
    np.testing.assert_allclose(ArmReach(ARM).dexterity(np.stack([stretched, at_limit])), 0.0, atol=1e-6)


def test_the_hand_stands_where_the_start_says() -> None:
    start = pose("side", LEVEL, ROLL, ARM.hand.palm_surface)
    with opened(bullet_world(settings(robot=ARM))) as fresh:
        fresh.reset(start, 0)
        position, rotation = fresh.hand.face_frame()
    np.testing.assert_allclose(position, start.position, atol=5e-4)  # the motors give way under the arm's weight
    np.testing.assert_allclose(rotation, start.rotation, atol=2e-3)


def test_what_is_out_of_reach_is_infeasible() -> None:
    far = pose("side", {**LEVEL, "yaw": math.pi}, ROLL, ARM.hand.palm_surface)
    high = pose("side", {**LEVEL, "height": 1.5}, ROLL, ARM.hand.palm_surface)
    with opened(bullet_world(settings(robot=ARM))) as world:
        for start, reason in ((far, "cannot reach"), (high, "farther away than the fingers are long")):
            with pytest.raises(InfeasibleStartError, match=reason):
                world.reset(start, 0)


def test_unreachable_starts_are_drawn_again_and_counted() -> None:
    program = main_program("scene.mount=wam", "trials.start.yaw={choice: [0.0, 3.1415]}", "program.1.limit=1.0")
    records = [trial_loop(program).run(number, 3).record for number in range(3)]
    assert all(record.start["yaw"] == 0.0 for record in records)
    assert sum(len(record.rejected) for record in records) > 0


def test_no_joint_leaves_its_limits() -> None:
    program = main_program("scene.mount=wam", "program.1.limit=6.0")
    loop = trial_loop(program)
    for number in range(3):
        joints = loop.run(number, 17).trajectory["joints"]
        assert np.maximum(LOWER - joints, joints - UPPER).max() < 0.01
