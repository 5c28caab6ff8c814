"""A robot in a world of rigid bodies: whether it takes up a start, and keeps still there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from itertools import product

import numpy as np

from graspdsl.arrays import Flags
from graspdsl.contracts.rule import Breach
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.mount_check import taken_names
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.shapes import Body
from graspdsl.spec.sensing import Exact
from graspdsl.worlds.kind import WorldSettings, fixed_to
from graspdsl.worlds.kinds import rigid_bodies
from graspdsl.worlds.protocol import Command, InfeasibleStartError, Start
from graspdsl.worlds.start_pose import pose

WIDTHS = (0.6, 0.8)  # of the object, of how far the hand opens
WIDEST, NARROWEST, HEIGHT = 0.15, 0.01, 0.20  # m
YAWS = (0.0, -0.5 * np.pi, 0.5 * np.pi, np.pi)  # rad, sides of the object
ROLLS = (0.0, 0.5 * np.pi, 0.25 * np.pi, np.pi)  # rad
STANDOFFS = np.arange(0.01, 0.12, 0.01)  # m
TICKS, STILL = 50, 0.02  # m or rad, that joints may give way


def taken_up(robot: Robot) -> Iterator[Breach]:
    """Before one of some cylinders it takes up one of some starts from the side, and keeps still there for a second."""
    if any(taken_names(robot)):
        return  # it is no robot, as the rule of names says
    refused = Counter[str]()
    widest = min(WIDEST, max(NARROWEST, float(FingertipMotion(robot).openings()[:, 0].max(initial=0.0))))
    for width in WIDTHS:
        body = Body("cylinder", Cylinder(diameter=width * widest, height=HEIGHT), 0.3)
        world = rigid_bodies().make(WorldSettings(robot, body, 0.4, Exact(), fixed_to(robot)))
        for yaw, roll, standoff in product(YAWS, ROLLS, STANDOFFS):
            try:
                seen = world.reset(_start(robot, body, yaw, roll, float(standoff)), 0)
            except InfeasibleStartError as error:
                refused[str(error)] += 1
                continue
            for _ in range(TICKS):
                later = world.step(Command("q", np.zeros(len(robot.joints))))
            world.close()
            first = np.where(_at_zero(robot), 0.0, seen.joints)
            gone = np.abs(later.joints - first)
            worst = list(robot.joints)[int(gone.argmax())]
            if not gone.max() <= STILL:
                yield f"told to keep still, {worst} goes by {gone.max():.3g} rad or m", "mend its effort and masses"
            return
        world.close()
    [(reason, _)] = refused.most_common(1)
    yield f"it takes up no start before a cylinder from the side: {reason}", "see it with graspdsl view --hand"


def _at_zero(robot: Robot) -> Flags:
    """Which joints (n,) are told to be at zero when a trial starts: those of a mount without a base."""
    return np.array([robot.mount.base is None and name in robot.mount.joints for name in robot.joints])


def _start(robot: Robot, body: Body, yaw: float, roll: float, standoff: float) -> Start:
    drawn = {"roll": roll, "yaw": yaw, "tilt": 0.0, "height": 0.6 * HEIGHT, "standoff": standoff, "offset": 0.0}
    return pose("side", drawn, body, robot.hand.palm_surface)
