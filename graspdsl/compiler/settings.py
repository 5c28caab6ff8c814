"""What the compiler must know besides the formula."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.backends import BACKENDS, Backend
from graspdsl.hands.descriptions import Robot, joint_limits
from graspdsl.objects.shapes import Body
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.spec.models import Spec
from graspdsl.spec.program import Control
from graspdsl.worlds.kind import WorldKind
from graspdsl.worlds.kinds import WORLDS

SLIDING_STEP, SLIDING_CAP = 0.01, 0.015  # curvature radii a tick
PROBING_STEP, PROBING_CAP = 0.5, 0.15  # curvature radii a probe; over Σw² of the resources


@dataclass(frozen=True, slots=True)
class Target:
    """What a pipeline drives and how: a robot in a world, under the spec's control settings.

    ``held``: the object is fixed to the hand, and turns with the contacts. ``surface``: that of the object, where it is
    known and stays in place.
    """

    robot: Robot
    world: WorldKind
    control: Control
    held: bool = False
    surface: Surface | None = None

    @property
    def rate(self) -> float:
        """Ticks a second."""
        return self.world.rate

    @property
    def backend(self) -> Backend:
        """What evaluates the pipelines."""
        return BACKENDS[self.control.backend]

    @property
    def probes(self) -> bool:
        """Whether a displacement of the contacts is one probe, and not one tick."""
        return self.world.probes(self.control.displacement)

    @property
    def each(self) -> str:
        """What one step of a displacement of contacts is."""
        return "probe" if self.probes else "tick"

    @property
    def _strides(self) -> bool:
        """Whether one step of a displacement may be long: the contacts need not slide there."""
        return self.probes or self.world.at_once

    def step(self, squared_weights: float) -> float:
        """The displacement [m] of a contact for a unit net force, over resources with this sum of squared weights."""
        if self.control.step is not None:
            return self.control.step
        return self.control.curvature_radius * (PROBING_STEP / squared_weights if self._strides else SLIDING_STEP)

    @property
    def cap(self) -> float:
        """The largest displacement [m] of a contact."""
        if self.control.cap is not None:
            return self.control.cap
        return self.control.curvature_radius * (PROBING_CAP if self._strides else SLIDING_CAP)

    @property
    def limits(self) -> tuple[Array, Array]:
        """Lower and upper limits (n,) of the joints [m or rad]."""
        lower, upper = joint_limits(self.robot)
        return np.array(lower), np.array(upper)

    @property
    def turning_joints(self) -> tuple[bool, ...]:
        """Which joints may turn contacts: the fingers that hold an object keep still, the mount turns all."""
        return tuple(not self.held or name in self.robot.mount.joints for name in self.robot.joints)


def target_of(spec: Spec, robot: Robot, body: Body | None) -> Target:
    """What the pipelines of a spec drive. ``body``: the object, None where it is not known."""
    world = WORLDS[spec.scene.world]
    known = body is not None and world.knows_surface and not body.shape.edged
    surface = body.shape.surface() if body is not None and known else None
    return Target(robot, world, spec.control, spec.scene.held, surface)


def different_trials(spec: Spec) -> float:
    """How many of a spec's trials can differ from one another, inf for any number; all others repeat them."""
    world = WORLDS[spec.scene.world]
    drawn = not world.has("hand") or world.sensor(spec.scene.sensing).is_random  # anew for each trial
    return math.inf if drawn else spec.trials.different
