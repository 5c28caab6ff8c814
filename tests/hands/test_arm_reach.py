"""Inverse kinematics of arms from their descriptions, against the forward kinematics of both engines."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import mujoco
import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.hands.arm_reach import ArmReach
from graspdsl.hands.descriptions import Mount, Pose, Robot, base_pose, hands, joint_limits, mounts
from graspdsl.hands.mount_files import mounts_in
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.protocol import Start
from graspdsl.worlds.start_pose import root_pose

from .arms import FILE, INERTIAL, arm, urdf, written

Forward = Callable[[Array], tuple[Array, Array]]


@pytest.fixture(params=["wam", "dexter", "stranger"])
def whole(request: pytest.FixtureRequest, tmp_path: Path) -> Robot:
    """A hand on an arm of seven joints, on one of two arms, on one of six joints with a gripper in its model."""
    if request.param == "stranger":
        mount = mounts_in(written(tmp_path, FILE, urdf(arm())))["arm"]
    else:
        mount = mounts()[request.param]
    turned = Pose(position=(-0.4, 0.2, 0.1), rpy=(0.3, -0.2, 1.0))
    return Robot(hand=hands()["barrett"], mount=mount.model_copy(update={"base": turned}))


@pytest.fixture
def bullet(whole: Robot) -> Iterator[Forward]:
    """The face as one engine has it."""
    engine = pybullet()
    with silenced():
        client = engine.connect(engine.DIRECT)
    hand = BulletHand(engine, client, whole, *root_pose(whole, Start(np.zeros(3), np.eye(3), {})), 0.4)

    def forward(joints: Array) -> tuple[Array, Array]:
        hand.place(np.concatenate([joints, np.zeros(len(whole.joints) - len(joints))]))
        return hand.face_frame()

    yield forward
    engine.disconnect(client)


def in_mujoco(mount: Mount) -> Forward:
    """The face as the other engine has it, which reads the mount's model alone."""
    spec = mujoco.MjSpec.from_string(mount.model)
    spec.compiler.fusestatic = False
    model = spec.compile()
    data = mujoco.MjData(model)
    position, rotation = base_pose(mount)

    def forward(joints: Array) -> tuple[Array, Array]:
        for name, place in zip(mount.joints, joints, strict=True):
            data.qpos[model.jnt_qposadr[model.joint(name).id]] = place
        mujoco.mj_kinematics(model, data)
        face = data.body(mount.face)
        return position + rotation @ face.xpos, rotation @ face.xmat.reshape(3, 3)

    return forward


def test_all_ways_to_a_pose_lead_there(whole: Robot, bullet: Forward) -> None:
    reach, forward = ArmReach(whole), in_mujoco(whole.mount)
    lower, upper = (np.array(ends)[: len(whole.mount.joints)] for ends in joint_limits(whole))
    for seed in range(4):
        joints = np.random.default_rng(seed).uniform(np.maximum(lower, -3.0), np.minimum(upper, 3.0))
        position, rotation = forward(joints)
        found = reach.postures(position, rotation)
        assert len(found) > 1
        for posture in found[:6]:
            assert ((posture >= lower) & (posture <= upper)).all()
            for known, precision in ((forward, 1e-6), (bullet, 1e-5)):  # the second has single precision
                reached = known(posture)
                np.testing.assert_allclose(reached[0], position, rtol=0.0, atol=precision)
                np.testing.assert_allclose(reached[1], rotation, rtol=0.0, atol=precision)
        freedom = reach.dexterity(found)
        assert (np.diff(freedom) <= 0.0).all()
        np.testing.assert_array_equal(reach.postures(position, rotation), found)


def test_what_is_out_of_reach_has_no_posture(whole: Robot) -> None:
    assert len(ArmReach(whole).postures(np.array([3.0, 0.0, 0.0]), np.eye(3))) == 0


SLIDES = """<robot name="slides"><link name="foot"/>{}</robot>"""
SLIDE = (
    '<link name="{0}-slide">{1}</link><joint name="{0}" type="prismatic"><parent link="{2}"/><child link="{0}-slide"/>'
    '<axis xyz="{3}"/><limit lower="-0.5" upper="0.5" effort="100" velocity="1"/></joint>'
)


def test_slides_alone_reach_what_needs_no_turn(tmp_path: Path) -> None:
    inertial = INERTIAL.format(mass=1)
    rows = (("x", "foot", "1 0 0"), ("y", "x-slide", "0 1 0"), ("z", "y-slide", "0 0 1"))
    model = SLIDES.format("".join(SLIDE.format(name, inertial, parent, axis) for name, parent, axis in rows))
    joints = ", ".join(f"{name}: {{weight: 1.0}}" for name, *_ in rows)
    text = "mount: arm\nabout: slides\nurdf: arm.urdf\nface: z-slide\nbase: {position: [0.1, 0, 0]}\n"
    mount = mounts_in(written(tmp_path, f"{text}joints: {{{joints}}}\n", model))["arm"]
    reach = ArmReach(Robot(hand=hands()["barrett"], mount=mount))
    [found] = reach.postures(np.array([0.3, -0.2, 0.1]), np.eye(3))
    np.testing.assert_allclose(found, [0.2, -0.2, 0.1], atol=1e-6)
    assert len(reach.postures(np.array([0.3, -0.2, 0.1]), np.diag([1.0, -1.0, -1.0]))) == 0
