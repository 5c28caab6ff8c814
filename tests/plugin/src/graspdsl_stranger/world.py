"""A world of a stranger's: contacts that glide over a known surface as position-controlled fingers do, not at once."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.spaces import GradientSpace
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.floating import sensed, slid
from graspdsl.worlds.kind import Ability, TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import PARTIES, Command, Observation, Start, Truth, WorldInfo

RATE = 50.0  # Hz
LAG = 0.05  # s: the time constant with which a contact follows
FASTEST = 0.10  # m/s


class Gliding(WorldKind):
    """Contacts that glide over a surface."""

    name = "gliding"
    about = "frictionless contacts that follow their commands with a lag, at 10 cm/s at most"
    rate = RATE
    sliding = probing = frozenset({GradientSpace.SURFACE, GradientSpace.CARTESIAN})
    at_once = True  # none of its contacts is probed
    pace = "contacts glide"
    contacts = "gliding contacts"
    senses = ("exact",)
    approaches = ("surface",)
    knows_object = True
    lacks: ClassVar[Mapping[Ability, str]] = {
        "hand": "gliding contacts have no hand",
        "forces": "gliding contacts feel no forces",
        "friction": "gliding contacts have none",
        "weight": "gliding contacts feel no weight",
        "motion": "the object that contacts glide on stays put",
        "parting": "gliding contacts never leave the surface",
        "holding": "an object that contacts glide on stays put: nothing holds it",
        "lifting": "gliding contacts have no hand and their object no weight",
        "edges": "contacts cannot glide",
    }

    def make(self, settings: WorldSettings) -> GlidingWorld:
        """Contacts on the surface of the object, by the names that the hand gives them."""
        return GlidingWorld(settings)

    def studio(self, view: View) -> TrialStudio:
        """The surface and its contacts. What draws them is loaded here, not with this file."""
        from graspdsl.worlds.mujoco.studio import SurfaceStudio

        return SurfaceStudio(view)


class GlidingWorld:
    """k contacts on a surface about the origin; each follows a target that commands move."""

    def __init__(self, settings: WorldSettings) -> None:
        body, none = settings.body, np.zeros(0)
        self.info = WorldInfo(RATE, settings.robot.contacts, (), none, none)  # no joints
        self._surface: Surface = body.shape.surface()
        self._weight, self._axis = settings.gravity * body.mass, np.array(body.major_axis)

    def reset(self, start: Start, seed: int) -> Observation:
        """The contacts anew, evenly over the surface; all that is random comes from the seed."""
        del start  # there is no hand to place
        self._ticks = 0
        self._points = self._surface.sample(len(self.info.contacts), np.random.default_rng(seed))
        self._targets = self._points
        return self._observed()

    def step(self, command: Command) -> Observation:
        """Move the targets by a displacement (k, 3) [m], and the contacts towards them for one tick."""
        if command.space != "x":
            raise ValueError(f"the gliding world moves contacts (x), not {command.space}")
        self._targets = slid(self._surface, self._targets, command.displacement)
        behind = self._targets - self._points
        step = -math.expm1(-1.0 / (RATE * LAG)) * behind
        length = np.linalg.norm(step, axis=1, keepdims=True)
        self._points = slid(self._surface, self._points, step * np.minimum(1.0, _shorter(FASTEST / RATE, length)))
        self._ticks += 1
        return self._observed()

    def tare(self) -> None:
        """Nothing to tare: nothing is felt."""

    def truth(self) -> Truth:
        """What is sensed is true here; the object never moves."""
        return Truth(
            points=self._points,
            normals=-self._surface.normals(self._points),
            forces=np.zeros_like(self._points),
            object_position=np.zeros(3),
            object_rotation=np.eye(3),
            object_axis=self._axis,
            object_lean=0.0,
            touching_links=(),
            table_links=(),
            stopped_joints=(),
            loads=np.full((len(PARTIES), 6), np.nan),  # nothing here has a force
        )

    def close(self) -> None:
        """Nothing to give back; it can be reset again."""

    def _observed(self) -> Observation:
        return sensed(self._surface, self._points, self._ticks / RATE, self._weight)


def _shorter(most: float, lengths: Array) -> Array:
    """By what to shorten steps of these lengths to the longest there may be."""
    return np.divide(most, lengths, out=np.ones_like(lengths), where=lengths > most)
