"""What the compiler must know besides the formula."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, joint_limits
from graspdsl.spec.models import Spec
from graspdsl.spec.program import Control
from graspdsl.worlds.kinds import WORLDS

SLIDING_STEP, SLIDING_CAP = 0.01, 0.015  # curvature radii a tick
PROBING_STEP, PROBING_CAP = 0.5, 0.15  # curvature radii a probe; over Σw² of the resources


@dataclass(frozen=True, slots=True)
class Target:
    """What a pipeline drives and how: a robot in a world with a tick rate [Hz], under the spec's control settings.

    ``probing``: one gradient step is one probe, or the contacts float. ``held``: the object is fixed to the hand, and
    turns with the contacts. ``floats``: the contacts have no hand.
    """

    robot: Robot
    rate: float
    control: Control
    probing: bool = False
    held: bool = False
    floats: bool = False

    @property
    def probes(self) -> bool:
        """Whether a displacement of the contacts is one probe, and not one tick."""
        return self.probing and not self.floats

    @property
    def each(self) -> str:
        """What one step of a displacement of contacts is."""
        return "probe" if self.probes else "tick"

    def step(self, squared_weights: float) -> float:
        """The displacement [m] of a contact for a unit net force, over resources with this sum of squared weights."""
        if self.control.step is not None:
            return self.control.step
        return self.control.curvature_radius * (PROBING_STEP / squared_weights if self.probing else SLIDING_STEP)

    @property
    def cap(self) -> float:
        """The largest displacement [m] of a contact."""
        if self.control.cap is not None:
            return self.control.cap
        return self.control.curvature_radius * (PROBING_CAP if self.probing else SLIDING_CAP)

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits (n,) of the joints [m or rad]."""
        lower, upper = joint_limits(self.robot)
        return np.array(lower), np.array(upper)

    @property
    def turning_joints(self) -> tuple[bool, ...]:
        """Which joints may turn contacts: the fingers that hold an object keep still, the mount turns all."""
        return tuple(not self.held or name in self.robot.mount.joints for name in self.robot.joints)


def target_of(spec: Spec, robot: Robot) -> Target:
    """What the pipelines of a spec drive."""
    world = WORLDS[spec.scene.world]
    probing = world.floats or spec.control.displacement == "probing"
    return Target(robot, world.rate, spec.control, probing, spec.scene.held, world.floats)
