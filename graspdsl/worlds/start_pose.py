"""Where the hand stands when a trial begins: a pose out of the numbers of a start."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shapes import Body
from graspdsl.worlds.protocol import Start

UP = np.array([0.0, 0.0, 1.0])


def pose(approach: str, drawn: Mapping[str, float], body: Body, palm_surface: float) -> Start:
    """The start pose of drawn values.

    From the side the palm faces the object's axis, the standoff before where the shape reaches towards the palm; or it
    faces the object from above. Its x axis lies along the object's axis (side) or level (top) until it is rolled about
    the palm's normal.
    """
    heading = np.array([math.cos(drawn["yaw"]), math.sin(drawn["yaw"]), 0.0])
    sin, cos = math.sin(drawn["tilt"]), math.cos(drawn["tilt"])
    if approach == "side":
        normal, level, depth = cos * heading - sin * UP, UP, body.shape.support(-heading)
        aim = drawn["height"] * UP
    else:
        normal, level, depth = sin * heading - cos * UP, heading, 0.0
        aim = body.shape.extent[2] * UP
    first = level - (level @ normal) * normal
    first /= np.linalg.norm(first)
    second = np.cross(normal, first)
    x = math.cos(drawn["roll"]) * first + math.sin(drawn["roll"]) * second
    rotation: Array = np.column_stack([x, np.cross(normal, x), normal])
    position = aim + drawn["offset"] * second - (palm_surface + drawn["standoff"] + depth) * normal
    return Start(position, rotation, drawn)


def root_pose(robot: Robot, start: Start) -> tuple[Array, Array]:
    """Position (3,) [m] and quaternion (4,) of the robot's root: where its arm stands, else at the start pose."""
    from scipy.spatial.transform import Rotation  # which takes its time to import, and checks need no root

    base = robot.mount.base
    if base is None:
        return start.position, Rotation.from_matrix(start.rotation).as_quat()
    return np.array(base.position), Rotation.from_euler("xyz", base.rpy).as_quat()
