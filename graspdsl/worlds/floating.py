"""The floating world: frictionless contacts on a known surface, no hand, no physics.

Contacts move by tangent steps and are put back on the surface; they sense their points and normals exactly.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import along
from graspdsl.basis.spaces import GradientSpace
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.kind import Ability, TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import Command, Observation, Start, Truth, WorldInfo

RATE = 50.0  # ticks a second, only to give steps a time


def slid(surface: Surface, points: Array, displacement: Array) -> Array:
    """Points (..., 3) on a surface after the tangential part of a displacement (..., 3) and a retraction."""
    tangent = displacement - along(displacement, surface.normals(points))
    return surface.retract(points + tangent)


def sensed(surface: Surface, points: Array, time: float, weight: float) -> Observation:
    """What contacts at points (..., k, 3) of a surface sense; leading axes are a batch. weight [N] of the object."""
    count = points.shape[-2]
    nothing = np.zeros((count, 3, 0))
    return Observation(
        time=time,
        points=points,
        normals=-surface.normals(points),
        forces=np.zeros_like(points),
        touching=np.ones(points.shape[:-1], dtype=bool),
        joints=np.zeros(0),
        jacobian=nothing,
        angular_jacobian=nothing,
        orientations=np.zeros_like(points),
        centre_of_mass=np.zeros(3),
        weight=np.array([0.0, 0.0, -weight]),
    )


class Floating(WorldKind):
    """Contacts on a surface, and nothing else."""

    name = "floating"
    about = "frictionless contacts on a known surface, no hand and no physics"
    rate = RATE
    sliding = probing = frozenset({GradientSpace.SURFACE, GradientSpace.CARTESIAN})
    at_once = True
    pace = "contacts float"
    contacts = "floating contacts"
    senses = ("exact",)
    approaches = ("surface",)
    knows_object = True
    lacks: ClassVar[Mapping[Ability, str]] = {
        "hand": "floating contacts have no hand",
        "forces": "floating contacts feel no forces",
        "friction": "floating contacts have none",
        "weight": "floating contacts feel no weight",
        "motion": "the object that contacts float on stays put",
        "parting": "floating contacts never leave the surface",
        "holding": "an object that contacts float on stays put: nothing holds it",
        "lifting": "floating contacts have no hand and their object no weight",
        "edges": "contacts cannot float",
    }

    def make(self, settings: WorldSettings) -> FloatingWorld:
        """Contacts on the surface of the object."""
        body = settings.body
        return FloatingWorld(
            settings.robot.contacts, body.shape.surface(), settings.gravity * body.mass, body.major_axis
        )

    def studio(self, view: View) -> TrialStudio:
        """The surface and its contacts."""
        from graspdsl.worlds.bullet.replay import SurfaceStudio

        return SurfaceStudio(self.make(view.settings).surface, view.contacts, window=view.window)


class FloatingWorld:
    """Contacts, by the names of a hand's, on a surface about the origin; the object stays put.

    weight [N] of the object; axis (3,): its major axis.
    """

    def __init__(
        self,
        contacts: tuple[str, ...],
        surface: Surface,
        weight: float,
        axis: tuple[float, float, float] = (0.0, 0.0, 1.0),
    ) -> None:
        none = np.zeros(0)
        self.info = WorldInfo(RATE, contacts, (), none, none)
        self.surface, self._weight, self._axis = surface, weight, np.array(axis)
        self._ticks = 0
        self._points = np.zeros((len(contacts), 3))

    def reset(self, start: Start, seed: int) -> Observation:
        """Draw the contacts anew, evenly over the surface."""
        del start  # there is no hand to place
        self._ticks = 0
        self._points = self.surface.sample(len(self.info.contacts), np.random.default_rng(seed))
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Move the contacts by a displacement (k, 3) [m]."""
        if command.space != "x":
            raise ValueError(f"the floating world moves contacts (x), not {command.space}")
        self._points = slid(self.surface, self._points, command.displacement)
        self._ticks += 1
        return self._observe()

    def _observe(self) -> Observation:
        return sensed(self.surface, self._points, self._ticks / RATE, self._weight)

    def tare(self) -> None:
        """Nothing to tare: floating contacts feel no forces."""

    def truth(self) -> Truth:
        """What is sensed is true here."""
        return Truth(
            points=self._points,
            normals=-self.surface.normals(self._points),
            forces=np.zeros_like(self._points),
            object_position=np.zeros(3),
            object_rotation=np.eye(3),
            object_axis=self._axis,
            object_lean=0.0,
            touching_links=(),
            table_links=(),
            stopped_joints=(),
        )

    def close(self) -> None:
        """Nothing to give back."""
