"""Inverse kinematics of an arm: the joints at which its mounting face stands at a pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import least_squares

from graspdsl.arrays import Array
from graspdsl.basis.algebra import skew
from graspdsl.basis.rotations import logarithm
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.protocol import UnreachableStartError

REACHED = 1e-4  # m or rad
PRECISION = 1e-9  # the engine tells link poses in single precision
MOST_EVALUATIONS = 40
BEGINNINGS = 16
GRASP_DEPTH = 0.05  # m ahead of the palm
NEAR_LIMIT = 0.3  # rad


class ArmReach:
    """The joints (n,) that bring the mounting face to a pose, within the limits (n,).

    position: (3,) [m], rotation: (3, 3). The search is begun from the same places over the joints' ranges each time.
    """

    def __init__(self, hand: BulletHand, position: Array, rotation: Array, lower: Array, upper: Array) -> None:
        self._hand, self._position, self._rotation = hand, position, rotation
        self._mount = np.array([name in hand.robot.mount.joints for name in hand.robot.joints])
        self._lower, self._upper = lower[self._mount], upper[self._mount]
        random = np.random.default_rng(0)
        self._beginnings = random.uniform(self._lower, self._upper, size=(BEGINNINGS, len(self._lower)))

    def any_posture(self, joints: Array) -> Array:
        """Joints that reach the pose, the fingers as in ``joints`` (n,). Raises UnreachableStartError."""
        for posture in self._found(joints):
            return posture
        raise UnreachableStartError("the arm cannot reach the start pose")

    def postures(self, joints: Array) -> list[Array]:
        """All joints found that reach the pose, the most dexterous first."""
        return sorted(self._found(joints), key=self.dexterity, reverse=True)

    def dexterity(self, joints: Array) -> float:
        """How freely the arm can move the hand from a posture (n,): 0 at a singularity or a limit.

        The least singular value of the Jacobian of a grasp ahead of the mounting face, in scaled joint coordinates and
        with rotations over the distance to it, less where a joint comes near to a limit.
        """
        self._hand.place(joints)
        linear, angular = self._hand.face_jacobian()
        ahead = (self._hand.robot.hand.palm_surface + GRASP_DEPTH) * self._hand.face_frame()[1][:, 2]
        reach = float(np.linalg.norm(ahead))
        both = np.vstack([linear - skew(ahead) @ angular, reach * angular])
        scaled = (both * np.array(self._hand.robot.weights))[:, self._mount]
        moved = joints[self._mount]
        margin = float(np.minimum(moved - self._lower, self._upper - moved).min())
        return float(np.linalg.svd(scaled, compute_uv=False)[-1]) * min(1.0, max(0.0, margin / NEAR_LIMIT))

    def _found(self, joints: Array) -> Iterator[Array]:
        search = _Search(self._hand, joints, self._mount, self._position, self._rotation)
        for first in self._beginnings:
            solution = least_squares(
                search.error,
                first,
                search.jacobian,
                bounds=(self._lower, self._upper),
                xtol=PRECISION,
                ftol=PRECISION,
                gtol=PRECISION,
                max_nfev=MOST_EVALUATIONS,
            )
            if np.abs(solution.fun).max() < REACHED:
                yield search.whole(solution.x)


class _Search:
    """The error of the face's pose over the mount's joints, and its Jacobian."""

    def __init__(self, hand: BulletHand, joints: Array, mount: Array, position: Array, rotation: Array) -> None:
        self._hand, self._joints, self._mount = hand, joints, mount
        self._position, self._rotation = position, rotation

    def whole(self, moved: Array) -> Array:
        """All joints (n,), those of the mount where the search has them."""
        joints = self._joints.copy()
        joints[self._mount] = moved
        return joints

    def error(self, moved: Array) -> Array:
        """(6,): position [m] and rotation [rad], the latter in the frame of the wanted pose."""
        self._hand.place(self.whole(moved))
        origin, rotation = self._hand.face_frame()
        return np.concatenate([origin - self._position, logarithm(self._rotation.T @ rotation)])

    def jacobian(self, moved: Array) -> Array:
        """(6, m), with the derivative of the logarithm, Φ̇ = J_l⁻¹(Φ) R*ᵀ ω."""
        turn = self.error(moved)[3:]
        linear, angular = self._hand.face_jacobian()
        turning = _left_jacobian_inverse(turn) @ self._rotation.T @ angular
        return np.vstack([linear, turning])[:, self._mount]


def _left_jacobian_inverse(vector: Array) -> Array:
    """(3, 3): from an angular velocity in fixed axes to the rate of exponential coordinates (3,) [rad]."""
    angle = float(np.linalg.norm(vector))
    cross = skew(vector)
    second = 1.0 / 12.0 if angle < 1e-4 else (1.0 - 0.5 * angle / np.tan(0.5 * angle)) / angle**2
    result: Array = np.eye(3) - 0.5 * cross + second * (cross @ cross)
    return result
