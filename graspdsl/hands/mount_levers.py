"""How a mount's joints are scaled in gradient space where its file does not say: by their levers at a grasp."""

from __future__ import annotations

import numpy as np

from graspdsl.hands.descriptions import Joint, Mount, Robot, hands, joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion

BARE = "points"  # the hand without a model
GRASP = np.array([0.0, 0.0, 0.15])  # m, ahead of the face: where the contacts of a hand are, more or less
POSTURES = 64
SHARE = 0.7  # of one over the lever: an arm moves before the fingers fold
SHORTEST = 0.2  # m: a wrist turns no faster, though its lever is shorter
SLIDE = 0.5  # m per m


def weighed(mount: Mount) -> dict[str, Joint]:
    """The joints of a mount, their weights SHARE over their levers [rad/m], of a slide SLIDE.

    A lever is the mean distance, over postures, that a radian moves a grasp by.
    """
    robot = Robot(hand=hands()[BARE], mount=mount)
    lower, upper = (np.array(limits) for limits in joint_limits(robot))
    postures = np.random.default_rng(0).uniform(lower, upper, size=(POSTURES, len(lower)))
    motion = FingertipMotion(robot).face(postures)
    linear, angular = motion.jacobians(GRASP)
    levers = np.linalg.norm(linear, axis=-2).mean(axis=0)
    turns = np.linalg.norm(angular, axis=-2).any(axis=0)
    weights = np.where(turns, SHARE / np.maximum(levers, SHORTEST), SLIDE)
    return {
        name: Joint(weight=float(f"{weight:.2g}"), closes=0) for name, weight in zip(mount.joints, weights, strict=True)
    }
