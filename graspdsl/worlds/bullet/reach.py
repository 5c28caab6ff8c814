"""Inverse kinematics of an arm: the joints at which its mounting face stands at a pose."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import least_squares

from graspdsl.arrays import Array
from graspdsl.basis.algebra import skew
from graspdsl.basis.rotations import logarithm
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.protocol import InfeasibleStartError

REACHED = 1e-4  # m or rad
PRECISION = 1e-9  # the engine tells link poses in single precision
MOST_EVALUATIONS = 60


class ArmReach:
    """The joints (n,) that bring the mounting face to a pose, within the limits (n,).

    position: (3,) [m], rotation: (3, 3). The search is begun from each of the mount's postures.
    """

    def __init__(self, hand: BulletHand, position: Array, rotation: Array, lower: Array, upper: Array) -> None:
        self._hand, self._position, self._rotation = hand, position, rotation
        self._lower, self._upper = lower, upper
        self._names = list(hand.robot.joints)
        self._mount = np.array([name in hand.robot.mount.joints for name in self._names])

    def any_posture(self, joints: Array) -> Array:
        """Joints that reach the pose, the fingers as in ``joints`` (n,). Raises InfeasibleStartError."""
        for posture in self._found(joints):
            return posture
        raise InfeasibleStartError("the arm cannot reach the start pose")

    def postures(self, joints: Array) -> list[Array]:
        """All joints found that reach the pose, farthest from a limit of the arm first."""
        return sorted(self._found(joints), key=self._margin, reverse=True)

    def _found(self, joints: Array) -> Iterator[Array]:
        lower, upper = self._lower[self._mount], self._upper[self._mount]
        for posture in self._hand.robot.mount.postures.values():
            first = [posture.get(name, 0.0) for name, moved in zip(self._names, self._mount, strict=True) if moved]
            search = _Search(self._hand, joints, self._mount, self._position, self._rotation)
            solution = least_squares(
                search.error,
                np.clip(first, lower, upper),
                search.jacobian,
                bounds=(lower, upper),
                xtol=PRECISION,
                ftol=PRECISION,
                gtol=PRECISION,
                max_nfev=MOST_EVALUATIONS,
            )
            if np.abs(solution.fun).max() < REACHED:
                yield search.whole(solution.x)

    def _margin(self, joints: Array) -> float:
        return float(np.minimum(joints - self._lower, self._upper - joints)[self._mount].min())


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
