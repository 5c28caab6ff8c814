"""The floating world: frictionless contacts on a known surface, no hand, no physics.

Contacts move by tangent steps and are put back on the surface; they sense their points and normals exactly.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from graspdsl.arrays import Array, Rows
from graspdsl.basis.algebra import along
from graspdsl.basis.spaces import GradientSpace
from graspdsl.objects.surfaces.compiled import compiled
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.kind import Ability, TrialStudio, View, WorldKind, WorldSettings
from graspdsl.worlds.protocol import PARTIES, Command, Names, Observation, Start, Time, Truth, WorldInfo

RATE = 50.0  # ticks a second, only to give steps a time


def slid(surface: Surface, points: Array, displacement: Array, normals: Array | None = None) -> Array:
    """Points (..., 3) on a surface after the tangential part of a displacement (..., 3) and a retraction.

    normals: (..., 3) there, outward or inward, where they are known.
    """
    across = along(displacement, surface.normals(points) if normals is None else normals)
    return surface.retract(points + (displacement - across))


def sensed(surface: Surface, points: Array, time: Time, weight: float, normals: Array | None = None) -> Observation:
    """What contacts at points (..., k, 3) of a surface sense; leading axes are a batch. time [s]: (...) of each trial;
    weight [N] of the object.

    normals: the inward ones (..., k, 3), where they are known.
    """
    batch, count = points.shape[:-2], points.shape[-2]
    nothing = np.zeros((*batch, count, 3, 0))
    return Observation(
        time=time,
        points=points,
        normals=-surface.normals(points) if normals is None else normals,
        forces=np.zeros_like(points),
        touching=np.ones(points.shape[:-1], dtype=bool),
        joints=np.zeros((*batch, 0)),
        jacobian=nothing,
        angular_jacobian=nothing,
        orientations=np.zeros_like(points),
        centre_of_mass=np.zeros((*batch, 3)),
        weight=np.broadcast_to(np.array([0.0, 0.0, -weight]), (*batch, 3)),
    )


class Floating(WorldKind):
    """Contacts on a surface, and nothing else."""

    name = "floating"
    about = "frictionless contacts on a known surface, no hand and no physics"
    rate = RATE
    sliding = probing = frozenset({GradientSpace.SURFACE, GradientSpace.CARTESIAN})
    at_once = True
    together = worth_a_worker = 256
    pace = "contacts float"
    contacts = "floating contacts"
    senses = ("exact",)
    approaches = ("surface",)
    knows_object = knows_surface = True
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
        body, surface = settings.body, compiled(settings.body.shape.surface(), settings.backend)
        return FloatingWorld(settings.robot.contacts, surface, settings.gravity * body.mass, body.major_axis)

    def studio(self, view: View) -> TrialStudio:
        """The surface and its contacts."""
        from graspdsl.worlds.mujoco.studio import SurfaceStudio

        return SurfaceStudio(view)


class FloatingWorld:
    """Contacts, by the names of a hand's, on a surface about the origin; the object stays put.

    Of one trial, or of many side by side. weight [N] of the object; axis (3,): its major axis.
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
        self._ticks: npt.NDArray[np.intp] = np.zeros(0, dtype=np.intp)
        self._on_surface = False  # to the last bit
        self.close()

    def reset(self, start: Start, seed: int) -> Observation:
        """Draw the contacts anew, evenly over the surface."""
        del start  # there is no hand to place
        self.close()
        self._points, self._ticks = self._drawn(seed), np.asarray(0)
        self._normals = -self.surface.normals(self._points)
        return self.observe()

    def join(self, start: Start, seed: int) -> None:
        """Draw the contacts of one more trial, which is beside the others from what is seen next on."""
        del start
        self._joining.append(self._drawn(seed)[None])

    def place(self, points: Array) -> None:
        """More trials, with contacts at points (n, k, 3) [m] of the surface."""
        self._joining.append(points)

    def keep(self, rows: Rows) -> None:
        """The other trials are over."""
        self._points, self._normals, self._ticks = self._points[rows], self._normals[rows], self._ticks[rows]

    def step(self, command: Command) -> Observation:
        """Move the contacts by a displacement (..., k, 3) [m], but for those of trials that have joined since."""
        if command.space != "x":
            raise ValueError(f"the floating world moves contacts (x), not {command.space}")
        self._slide(command.displacement)
        self._ticks = self._ticks + 1
        return self.observe()

    def _slide(self, displacement: Array) -> None:
        """Move the contacts from the first to the last that any trial moves: once on the surface to the last bit, the
        others stay as they are."""
        moved = np.flatnonzero(displacement.reshape(-1, *displacement.shape[-2:]).any(axis=0).any(axis=-1))
        if not self._on_surface:
            moved, self._on_surface = np.arange(displacement.shape[-2]), True
        if len(moved):
            part = (..., slice(moved[0], moved[-1] + 1), slice(None))
            points, normals = self._points.copy(), self._normals.copy()
            after = slid(self.surface, points[part], displacement[part], normals[part])
            points[part], normals[part] = after, -self.surface.normals(after)
            self._points, self._normals = points, normals

    def observe(self) -> Observation:
        """What the contacts sense."""
        self._admit()
        return sensed(self.surface, self._points, self._ticks / RATE, self._weight, self._normals)

    def tare(self) -> None:
        """Nothing to tare: floating contacts feel no forces."""

    def truth(self) -> Truth:
        """What is sensed is true here."""
        self._admit()
        batch = self._points.shape[:-2]
        nobody: Names = ((),) * len(self._points) if batch else ()
        return Truth(
            points=self._points,
            normals=self._normals,
            forces=np.zeros_like(self._points),
            object_position=np.zeros((*batch, 3)),
            object_rotation=np.broadcast_to(np.eye(3), (*batch, 3, 3)),
            object_axis=np.broadcast_to(self._axis, (*batch, 3)),
            object_lean=np.zeros(batch)[()],
            touching_links=nobody,
            table_links=nobody,
            stopped_joints=nobody,
            loads=np.broadcast_to(np.nan, (*batch, len(PARTIES), 6)),
        )

    def witness(self, row: int) -> FloatingWorld:
        """One of the trials alone."""
        alone = copy.copy(self)
        alone._points, alone._normals, alone._ticks = self._points[row], self._normals[row], self._ticks[row]
        return alone

    def close(self) -> None:
        """No trials any more."""
        self._ticks, self._joining = np.zeros(0, dtype=np.intp), list[Array]()
        self._points = self._normals = np.zeros((0, len(self.info.contacts), 3))
        self._on_surface = False

    def _admit(self) -> None:
        """Trials that have joined stand beside the others."""
        if self._joining:
            joining = np.concatenate(self._joining)
            self._joining.clear()
            self._on_surface = False
            self._points = np.concatenate([self._points, joining])
            self._normals = np.concatenate([self._normals, -self.surface.normals(joining)])
            self._ticks = np.concatenate([self._ticks, np.zeros(len(joining), dtype=np.intp)])

    def _drawn(self, seed: int) -> Array:
        return self.surface.sample(len(self.info.contacts), np.random.default_rng(seed))
