"""Inverse kinematics of an arm, from its description alone: the joints at which its mounting face stands at a pose."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.basis.algebra import skew
from graspdsl.basis.rotations import logarithm
from graspdsl.hands.descriptions import Robot, base_pose, joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion

REACHED = 1e-8  # m or rad
BEGINNINGS = 64
MOST_STEPS = 60
LEAST_DAMPING = 1e-9  # of the normal equations, which keeps them soluble at a singularity
STALLED = 1e10  # damping at which no step lowers the error
TURN = 0.3  # m that a radian counts as
ALIKE = 1e-3  # rad or m by which two postures differ at the least
GRASP_DEPTH = 0.05  # m ahead of the palm
NEAR_LIMIT = 0.3  # rad


class ArmReach:
    """How an arm of m joints, which stands on its base, brings its mounting face to a pose, within its limits.

    Levenberg and Marquardt's least squares from the same places over the joints' ranges each time, all side by side.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot, self._motion = robot, FingertipMotion(robot)
        self._moved = len(robot.mount.joints)
        self._lower, self._upper = (np.array(limits)[: self._moved] for limits in joint_limits(robot))
        # No joint need turn by more than half a turn either way; a farther limit only doubles what is found.
        low, high = np.maximum(self._lower, -np.pi), np.minimum(self._upper, np.pi)
        self._beginnings = np.random.default_rng(0).uniform(low, high, size=(BEGINNINGS, self._moved))
        self._position, self._rotation = base_pose(robot.mount)

    def postures(self, position: Array, rotation: Array) -> Array:
        """The arm's joints (p, m) with which its face is at a position (3,) [m] and a rotation (3, 3) of the world, the
        most dexterous first: one row for each way that was found, none where the pose is out of reach."""
        if not self._moved:  # nothing that stands still reaches
            return self._beginnings[:0]
        goal = self._rotation.T @ (position - self._position), self._rotation.T @ rotation
        joints, damping = self._beginnings.copy(), np.full(BEGINNINGS, 1e-3)
        error, columns = self._error(joints, *goal)
        for _ in range(MOST_STEPS):
            tried = self._stepped(joints, error, columns, damping)
            new_error, new_columns = self._error(tried, *goal)
            better = (new_error**2).sum(axis=-1) < (error**2).sum(axis=-1)
            joints = np.where(better[:, None], tried, joints)
            error = np.where(better[:, None], new_error, error)
            columns = np.where(better[:, None, None], new_columns, columns)
            damping = np.maximum(np.where(better, damping / 10.0, damping * 4.0), LEAST_DAMPING)
            arrived = np.abs(error).max(axis=-1) < REACHED
            if (arrived | (damping > STALLED)).all():
                break
        found = joints[arrived]
        found = found[np.argsort(-self.dexterity(found), kind="stable")]
        return np.asarray(found[self._different(found)])

    def dexterity(self, joints: Array) -> Array:
        """How freely the arm can move the hand from postures (..., m): (...), 0 at a singularity or a limit.

        The least singular value of the Jacobian of a grasp ahead of the mounting face, in scaled joint coordinates and
        with rotations over the distance to it, less where a joint comes near to a limit.
        """
        face = self._motion.face(self._whole(joints))
        ahead = self._robot.hand.palm_surface + GRASP_DEPTH
        linear, angular = face.jacobians(np.array([0.0, 0.0, ahead]))
        both = np.concatenate([linear, ahead * angular], axis=-2)
        scaled = (both * np.array(self._robot.weights))[..., : self._moved]
        margin = np.minimum(joints - self._lower, self._upper - joints).min(axis=-1)
        return np.asarray(np.linalg.svd(scaled, compute_uv=False)[..., -1] * np.clip(margin / NEAR_LIMIT, 0.0, 1.0))

    def _whole(self, joints: Array) -> Array:
        """All joints (..., n) of the robot, those of the hand at zero."""
        rest = np.zeros((*joints.shape[:-1], len(self._robot.joints) - self._moved))
        return np.concatenate([joints, rest], axis=-1)

    def _error(self, joints: Array, position: Array, rotation: Array) -> tuple[Array, Array]:
        """How far off the face is with joints (b, m), (b, 6): position [m] and rotation [rad], the latter in the frame
        of the wanted pose; and the Jacobians (b, 6, m) of that."""
        face = self._motion.face(self._whole(joints))
        turn = logarithm(rotation.T @ face.rotation)
        linear, angular = (part[..., : self._moved] for part in face.jacobians(np.zeros(3)))
        turning = _left_jacobian_inverse(turn) @ (rotation.T @ angular)
        return (
            np.concatenate([face.origin - position, TURN * turn], axis=-1),
            np.concatenate([linear, TURN * turning], axis=-2),
        )

    def _stepped(self, joints: Array, error: Array, columns: Array, damping: Array) -> Array:
        """Joints (b, m) after one step each, within their limits; one at a limit that the gradient pushes on stays."""
        gradient = (error[:, None, :] @ columns)[:, 0]
        held = ((joints <= self._lower) & (gradient > 0.0)) | ((joints >= self._upper) & (gradient < 0.0))
        free = np.where(held[:, None, :], 0.0, columns)
        normal = free @ np.swapaxes(free, -1, -2) + damping[:, None, None] * np.eye(6)
        step = -(np.swapaxes(free, -1, -2) @ np.linalg.solve(normal, error[..., None]))[..., 0]
        return np.asarray(np.clip(joints + step, self._lower, self._upper))

    def _different(self, joints: Array) -> Flags:
        """Which of some postures (p, m) are none of those before them."""
        kept = np.ones(len(joints), dtype=bool)
        for row in range(len(joints)):
            kept[row] = not (np.abs(joints[:row][kept[:row]] - joints[row]).max(axis=-1) < ALIKE).any()
        return kept


def _left_jacobian_inverse(vectors: Array) -> Array:
    """(..., 3, 3): from an angular velocity in fixed axes to the rate of exponential coordinates (..., 3) [rad]."""
    angles = np.linalg.norm(vectors, axis=-1)[..., None, None]
    small = angles < 1e-4
    safe = np.where(small, 1.0, angles)
    second = np.where(small, 1.0 / 12.0, (1.0 - 0.5 * safe / np.tan(0.5 * safe)) / safe**2)
    cross = skew(vectors)
    return np.asarray(np.eye(3) - 0.5 * cross + second * (cross @ cross))
