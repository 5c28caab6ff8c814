"""What an engine of rigid bodies does for a world: it sets a stage, and steps it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shapes import Body
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import Palm
from graspdsl.worlds.touch.fingertip_sensor import Fingertip, FingertipPhysics

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

    def drive(self, joints: Array) -> None:
        """Set the position targets (n,) of the joint motors, the coupled joints with them."""
        ...

    def joints(self) -> Array:
        """Where the joints (n,) are [m or rad]."""
        ...

    def tip_frames(self) -> list[tuple[Array, Array]]:
        """Origin (3,) and rotation (3, 3) of each fingertip link's frame, in the world."""
        ...

    def tip_jacobians(self, places: Sequence[Array]) -> tuple[Array, Array]:
        """Linear and angular Jacobians (k, 3, n) of a point (3,) fixed in the frame of each fingertip's link."""
        ...

    def face_frame(self) -> tuple[Array, Array]:
        """Origin (3,) and rotation (3, 3) of the mounting face, in the world."""
        ...

    def palm(self) -> Palm:
        """The palm at the origin of its link."""
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
        """Simulate one time step."""
        ...

    def soften(self) -> None:
        """Give the fingertips the stiffness that belongs to how they press now."""
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

    def other_links(self) -> tuple[str, ...]:
        """Names of the hand's links other than fingertips that press on the object."""
        ...

    def table_links(self) -> tuple[str, ...]:
        """Names of the robot's links that press on the table; its base stands still and is none of them."""
        ...

    def forget(self) -> None:
        """Forget what has acted on the object."""
        ...

    def loads(self) -> Array:
        """What PARTIES put on the object (4, 6): force [N], then moment [N·m] about its centre of mass.

        Means over the steps since all was forgotten: over these they add up to the change of the object's momentum.
        """
        ...

    def close(self) -> None:
        """Give back what the engine holds."""
        ...


class Engine(Protocol):
    """An engine of rigid bodies; one of its settings serves one world, a stage after another."""

    @property
    def time_step(self) -> float:
        """Of a step [s]."""
        ...

    def stage(self, settings: WorldSettings, position: Array, quaternion: Array) -> Stage:
        """Object, table and robot, whose root is at a position (3,) [m] and quaternion (4,), x first, all its joints at
        zero."""
        ...

    def table(self, body: Body, table_friction: float, gravity: float) -> Stage:
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
