"""Observations to start from: fingertips that press on a ball."""

from __future__ import annotations

import math

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.rotations import logarithm
from graspdsl.compiler.program import Program
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertip_motion import FINE, FingertipMotion
from graspdsl.spec.scene import GRAVITY
from graspdsl.worlds.protocol import Observation

FORCE = 1.0  # N, of each contact
MASS = 0.5  # kg, of a ball that is held
ROUNDS = 20  # of Newton's method


def example_of(program: Program) -> Observation:
    """Every contact on a ball about as large as the gradients assume, pressing along its normal.

    The fingers are closed as far as that takes, and up to four fingertips touch one ball; tips count as balls within
    them. The frame is that of the robot's root. A ball that is held is known by its centre and weight. Contacts without
    a hand are spread evenly, and no joint moves them.
    """
    robot, radius = program.robot, program.spec.control.curvature_radius
    count, known = len(robot.contacts), program.spec.scene.held
    if robot.has_model:
        joints, centre, points, orientations, jacobian, angular = _closed_on_a_ball(robot, radius)
    else:
        joints, centre, points = np.zeros(len(robot.joints)), np.zeros(3), radius * _spread(count)
        orientations, jacobian, angular = np.zeros((count, 3)), *np.zeros((2, count, 3, len(joints)))
    normals = centre - points
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    return Observation(
        time=0.0,
        points=points,
        normals=normals,
        forces=FORCE * normals,
        touching=np.ones(count, dtype=bool),
        joints=joints,
        jacobian=jacobian,
        angular_jacobian=angular,
        orientations=orientations,
        centre_of_mass=centre if known else np.full(3, np.nan),
        weight=np.array([0.0, 0.0, -MASS * GRAVITY]) if known else np.full(3, np.nan),
    )


def _closed_on_a_ball(robot: Robot, radius: float) -> tuple[Array, Array, Array, Array, Array, Array]:
    """The joints of a hand that is closed on a ball of nearly this radius [m], the ball's centre, and its contacts:
    points, orientations, linear and angular Jacobians."""
    motion, tips = FingertipMotion(robot), [np.array(contact.shape.centre) for contact in robot.hand.contacts.values()]
    best = math.inf
    for posture in motion.closing(FINE):
        links = motion.links(posture)
        centres = np.array([link.point(tip) for link, tip in zip(links, tips, strict=True)])
        centre, fitted = _ball_between(centres, motion.radii)
        if abs(fitted - radius) < best:
            best, joints, middle, at, between = abs(fitted - radius), posture, centre, links, centres
    inward = middle - between
    inward /= np.linalg.norm(inward, axis=-1, keepdims=True)
    points = between + motion.radii[:, None] * inward
    columns = [link.jacobians(link.rotation.T @ (point - link.origin)) for link, point in zip(at, points, strict=True)]
    orientations = logarithm(np.array([link.rotation for link in at]))
    linear, angular = (np.array(part) for part in zip(*columns, strict=True))
    return joints, middle, points, orientations, linear, angular


def _ball_between(centres: Array, radii: Array) -> tuple[Array, float]:
    """The centre (3,) and the radius [m] of the ball that touches balls about centres (k, 3) with radii (k,)."""
    middle = centres.mean(axis=0)
    if len(centres) == 1:
        middle = middle + np.array([0.0, 0.0, 0.05])
    for _ in range(ROUNDS):
        away = middle - centres
        distances = np.linalg.norm(away, axis=1)
        gaps = distances - radii
        slopes = np.column_stack([away / distances[:, None], -np.ones(len(centres))])
        middle = middle + np.linalg.lstsq(slopes, gaps.mean() - gaps, rcond=None)[0][:3]
    return middle, float(gaps.mean())


def _spread(count: int) -> Array:
    """Unit vectors (count, 3), spread evenly along a spiral."""
    places = np.arange(count) + 0.5
    turns, heights = math.pi * (1.0 + math.sqrt(5.0)) * places, 1.0 - 2.0 * places / count
    flat = np.sqrt(1.0 - heights**2)
    return np.column_stack([flat * np.cos(turns), flat * np.sin(turns), heights])
