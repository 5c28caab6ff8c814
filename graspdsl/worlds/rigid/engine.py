"""What an engine of rigid bodies does for a world: it sets a stage, and steps it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple, Protocol, TypeVar

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shapes import Body
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import Names, Palm
from graspdsl.worlds.touch.fingertip_sensor import Fingertip, FingertipPhysics, TipFrames

CONTROL_RATE = 50.0  # Hz, of ticks
# The lever [m] of what a table resists rolling with, as of a can on wood, under what lies on its round side. Without it
# the rounding of an engine's numbers rolled a can 5 cm in 5 s; half as much kept it where it was.
ROLLING_RESISTANCE = 2e-4
OUT_OF_THE_WAY = 1.0  # m under its place, of a table that nothing stands on

# A position [m] and a quaternion, as the engine itself has them.
EnginePose = tuple[tuple[float, ...], tuple[float, ...]]


class StagedObject(Protocol):
    """A table whose top is z = 0, and one object on it, at the origin when it is put there."""

    mass: float

    def pose(self) -> EnginePose:
        """Where the object is."""
        ...

    def place(self, pose: EnginePose) -> None:
        """Put the object into a pose, at rest."""
        ...

    def object_pose(self) -> tuple[Array, Array]:
        """The object's centre of mass (3,) [m] and the rotation (3, 3) of its body frame."""
        ...

    def velocity(self) -> tuple[Array, Array]:
        """The velocity (3,) [m/s] of the object's centre of mass, and its angular one (3,) [rad/s]."""
        ...

    def move(self, velocity: Array, rate: Array) -> None:
        """Give the object a velocity (3,) [m/s] and an angular one (3,) [rad/s]."""
        ...

    def object_corners(self) -> Array:
        """The corners (8, 3) [m] of a box along the axes of the world that the object is in."""
        ...


class StagedHand(Protocol):
    """A hand on its mount. Joint vectors of length n are in command order, mount first.

    Links have numbers from 0, the root -1.
    """

    robot: Robot
    coupling: Array

    @property
    def parents(self) -> Sequence[int]:
        """The link before each."""
        ...

    @property
    def slides(self) -> Sequence[bool]:
        """Whether a slide moves each link."""
        ...

    @property
    def movable(self) -> Sequence[int]:
        """The links that joints move, coupled ones too; where all these are is ``coupling`` @ (n,)."""
        ...

    @property
    def tip_links(self) -> tuple[int, ...]:
        """The links of the fingertips."""
        ...

    @property
    def tips(self) -> Sequence[Fingertip]:
        """The fingertips, in the order of the robot's contacts."""
        ...

    def move_root(self, position: Array, quaternion: Array) -> None:
        """Put the root's frame at a position (3,) [m] and quaternion (4,), x first, the joints as they are."""
        ...

    def place(self, joints: Array) -> None:
        """Put the joints (n,) where they are told, at rest, without simulating."""
        ...

    def joints(self) -> Array:
        """Where the joints (n,) are [m or rad]."""
        ...

    def face_frame(self) -> tuple[Array, Array]:
        """Origin (3,) and rotation (3, 3) of the mounting face, in the world."""
        ...

    def palm(self) -> Palm:
        """The palm at the origin of its link."""
        ...

    def press(self, presses: Sequence[float]) -> None:
        """Give the fingertips the stiffness that belongs to the normal forces [N] they press with."""
        ...

    def links_beyond(self, joints: Sequence[str]) -> set[int]:
        """The links that these joints move."""
        ...

    def link_origins(self) -> list[Array]:
        """Where the frame of each link is (3,) [m]."""
        ...

    def link_sizes(self, links: Sequence[int]) -> list[float]:
        """How far [m] links reach from the origins of their frames, at the most."""
        ...


class Stage(Protocol):
    """A scene that stands: an object and what else there is. To be closed."""

    @property
    def hand(self) -> StagedHand:
        """The robot; there is none on a stage for the object alone."""
        ...

    @property
    def scene(self) -> StagedObject:
        """The object on its table."""
        ...

    @property
    def fingertips(self) -> FingertipPhysics:
        """What tactile sensors are told of the fingertips."""
        ...

    def step(self) -> None:
        """Simulate one time step. Raises WorldCrashError."""
        ...

    def simulate(self, targets: Array, sense: Callable[[int], int]) -> None:
        """Simulate a tick, the joints' motors driven to targets (s, n) in turn, one a time step. What acts on the
        object is noted, what acted before forgotten.

        sense: is told how many steps have been made since it was called last, and tells after how many more it is to be
        called again. Raises WorldCrashError.
        """
        ...

    def attach(self) -> None:
        """Fix the object to the hand's palm where it is."""
        ...

    def clearance(self, links: set[int] | None, within: float) -> float:
        """The least distance [m] between these links of the hand (None: all) and the table or the object.

        Distances above ``within`` count as infinite.
        """
        ...

    def distance(self, link: int, within: float) -> float:
        """The distance [m] between a link of the hand and the object; infinite above ``within``."""
        ...

    def close(self) -> None:
        """Give back what the engine holds."""
        ...


class Touched(NamedTuple):
    """What touches what on N stages, with k fingertips each.

    points, normals, forces: (N, k, 3), those of the true contacts of tips with objects, normals into these and forces
    on them; NaN where none touches. presses: (N, k), the normal forces [N] of all contacts of each tip. other_links:
    what else of each robot presses on its object, table_links: what of it presses on the table, by name.
    """

    points: Array
    normals: Array
    forces: Array
    presses: Array
    other_links: Names
    table_links: Names


class Stages(Protocol):
    """Alike stages side by side, N of them, each as it is alone."""

    _stages: Sequence[Stage]

    def joints(self) -> Array:
        """Where the joints (N, n) are [m or rad]."""
        return np.array([stage.hand.joints() for stage in self._stages])

    def tip_frames(self) -> TipFrames:
        """The frames of the fingertips' links, in the world."""
        ...

    def tip_jacobians(self, frames: TipFrames, places: Array) -> Array:
        """Linear and angular Jacobians (2, N, k, 3, n) of points (N, k, 3) in the frames of the fingertips' links,
        which are at present those that are given."""
        ...

    def object_poses(self) -> tuple[Array, Array]:
        """The objects' centres of mass (N, 3) [m] and the rotations (N, 3, 3) of their body frames."""
        places, rotations = zip(*(stage.scene.object_pose() for stage in self._stages), strict=True)
        return np.array(places), np.array(rotations)

    def touched(self) -> Touched:
        """What touches what."""
        ...

    def loads(self) -> Array:
        """What PARTIES put on the objects (N, 4, 6): force [N], then moment [N·m] about the centre of mass.

        Means over the steps of the last tick: over these they add up to the change of an object's momentum.
        """
        ...


Staged = TypeVar("Staged", bound=Stage)


class Engine(Protocol[Staged]):
    """An engine of rigid bodies; one of its settings serves one world, its stages one after another or side by side."""

    @property
    def time_step(self) -> float:
        """Of a step [s]."""
        ...

    def stage(self, settings: WorldSettings, position: Array, quaternion: Array) -> Staged:
        """Object, table and robot, whose root is at a position (3,) [m] and quaternion (4,), x first, all its joints at
        zero."""
        ...

    def side_by_side(self, stages: Sequence[Staged]) -> Stages:
        """Stages of the same settings."""
        ...

    def table(self, body: Body, table_friction: float, gravity: float) -> Staged:
        """An object upright on the table; there is no robot."""
        ...

    def close(self) -> None:
        """Give back what was kept from one stage to the next."""
        ...


def stands_free(anchor: Anchor) -> bool:
    """Whether the table is under the object."""
    return anchor not in (Anchor.HAND, Anchor.AFLOAT, Anchor.MOUNT)


def stands_still(anchor: Anchor) -> bool:
    """Whether the object is fixed in the world."""
    return anchor in (Anchor.WORLD, Anchor.MOUNT)


def stretches(steps: int, sense: Callable[[int], int]) -> Iterator[slice]:
    """A tick of so many steps in stretches between which nothing senses; after each something does, as
    :meth:`Stage.simulate` has it."""
    done, until = 0, sense(0)
    while done < steps:
        ahead = slice(done, min(done + until, steps))
        yield ahead
        until, done = sense(ahead.stop - done), ahead.stop
