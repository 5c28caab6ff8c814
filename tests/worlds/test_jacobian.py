"""Contact Jacobians against central differences in the simulator."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import robot
from graspdsl.worlds.bullet.hand import BulletHand

from .scenes import bullet_world, grasped, lone_hand, main_program, opened, settings, side_start, with_uneven_tips

STEP = 0.05  # rad or m
CLOSE = 1e-5


def differences(
    place: Callable[[Array], None], hand: BulletHand, tip: int, point: Array, count: int
) -> tuple[Array, Array]:
    """Linear and angular central differences of a material point of a tip, given in the tip's frame.

    The engine tells positions in single precision, so steps are large and the difference is of fourth order. About a
    fixed axis, a rotation is as good as its differential.
    """
    linear, angular = np.zeros((3, count)), np.zeros((3, count))

    def frame(change: Array) -> tuple[Array, Array]:
        place(change)
        origin, rotation = hand.tip_frames()[tip]
        return origin + rotation @ point, rotation

    for joint, axis in enumerate(STEP * np.eye(count)):
        (far_behind, _), (behind, back), (ahead, forth), (far_ahead, _) = (frame(n * axis) for n in (-2, -1, 1, 2))
        linear[:, joint] = (8.0 * (ahead - behind) - (far_ahead - far_behind)) / (12.0 * STEP)
        angular[:, joint] = Rotation.from_matrix(forth @ back.T).as_rotvec() / (2.0 * STEP)
    place(np.zeros(count))
    return linear, angular


@pytest.mark.parametrize("seed", range(4))
def test_jacobians_of_any_point_at_any_joints(seed: int) -> None:
    random = np.random.default_rng(seed)
    base = Rotation.random(random_state=seed).as_matrix()
    with lone_hand(random.uniform(-1, 1, 3), base) as (_, _, hand):
        joints = np.concatenate([random.uniform(-0.3, 0.3, 6), random.uniform(0.1, 1.8, 4)])
        hand.place(joints)
        for index, tip in enumerate(hand.tips):
            point = tip.centre + random.normal(0.0, 0.01, 3)
            linear, angular = differences(lambda change: hand.place(joints + change), hand, index, point, len(joints))
            found = hand.jacobians(tip, point, hand.all_joints())
            assert np.abs(found[0] - linear).max() < CLOSE
            assert np.abs(found[1] - angular).max() < CLOSE
            assert np.abs(linear).max() > 0.1  # something moves


def test_jacobians_of_tips_with_uneven_masses(tmp_path: Path) -> None:
    with lone_hand(robot=with_uneven_tips(tmp_path)) as (_, _, hand):
        joints = np.concatenate([np.zeros(6), [0.3, 0.9, 1.1, 1.3]])
        hand.place(joints)
        for index, tip in enumerate(hand.tips):
            point = tip.centre + np.array([0.0, 0.0115, 0.0])
            linear, angular = differences(lambda change: hand.place(joints + change), hand, index, point, len(joints))
            found = hand.jacobians(tip, point, hand.all_joints())
            assert np.abs(found[0] - linear).max() < CLOSE
            assert np.abs(found[1] - angular).max() < CLOSE


@pytest.mark.parametrize("mount", ["gantry", "wam"])
def test_the_jacobian_of_the_palm(mount: str) -> None:
    with lone_hand(robot=robot("barrett", mount)) as (_, _, hand):
        joints = np.full(len(hand.robot.joints), 0.4)
        linear = np.zeros((3, len(joints)))
        for joint, axis in enumerate(1e-2 * np.eye(len(joints))):
            ends = []
            for side in (-2, -1, 1, 2):
                hand.place(joints + side * axis)
                ends.append(hand.palm().position)
            linear[:, joint] = (8.0 * (ends[2] - ends[1]) - (ends[3] - ends[0])) / 0.12
        hand.place(joints)
        assert np.abs(hand.palm().jacobian[:3] - linear).max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("start", [{"roll": 0.6}, {"tilt": 0.4, "yaw": 1.0, "height": 0.14}])
def test_jacobians_that_are_observed(start: dict[str, float]) -> None:
    """A second hand, set to the joints of the simulated one, moves its contacts as the observation says."""
    place = side_start(**start)
    with opened(bullet_world(settings())) as world, lone_hand(place.position, place.rotation) as (engine, client, twin):
        seen = grasped(world, place, main_program())
        positions = np.array(world.hand.all_joints())

        def set_joints(change: Array) -> None:
            for joint, angle in zip(twin.movable, positions + twin.coupling @ change, strict=True):
                engine.resetJointState(twin.body, joint, float(angle), 0.0, client)

        set_joints(np.zeros(len(seen.joints)))
        for contact, (origin, rotation) in enumerate(twin.tip_frames()):
            point = rotation.T @ (seen.points[contact] - origin)
            assert np.linalg.norm(point - twin.tips[contact].centre) == pytest.approx(0.0115, abs=1e-4)
            linear, angular = differences(set_joints, twin, contact, point, len(seen.joints))
            assert np.abs(seen.jacobian[contact] - linear).max() < CLOSE
            assert np.abs(seen.angular_jacobian[contact] - angular).max() < CLOSE
