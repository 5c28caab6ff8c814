"""What a world offers: the one interface between controllers and whatever they act on.

An Observation holds what a real hand could sense. The truth stands behind a protocol of its own that only monitors,
graders and tests may read.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar, runtime_checkable

from graspdsl.arrays import Array, Flags, Rows

TABLE_SIZE = (1.6, 1.6, 0.05)  # m
PARTIES = ("contacts", "links", "table", "gravity")
"""What acts on the object: fingertips, what else of the robot touches it, the table, its weight."""

Found = TypeVar("Found")
Time = Any  # [s], a number; of many trials, an array of one for each
Names = tuple[Any, ...]  # of links or joints; of many trials, a tuple of names for each


class InfeasibleStartError(Exception):
    """A start that the world cannot take up (the hand would stand in the table or the object)."""


class UnstableObjectError(Exception):
    """An object that does not stand by itself where a trial begins."""


class NoWindowError(Exception):
    """A window that cannot be opened, for what the system says."""


class UnreachableStartError(InfeasibleStartError):
    """A start that the arm cannot reach, whatever stands about."""


class WorldCrashError(Exception):
    """The simulation left the realm of numbers (not-a-number states) or its engine gave up.

    ``crashed``: of many trials those that it happened to, by their rows, each with what is said of it; all trials where
    none is named.
    """

    def __init__(self, message: str, crashed: Mapping[int, str] | None = None) -> None:
        super().__init__(message)
        self.crashed = crashed or {}


@dataclass(frozen=True, slots=True)
class WorldInfo:
    """What the world is: the rate of its control ticks [Hz], its contacts and actuated joints in order.

    lower, upper: (n,) limits of the joints [m or rad]. tare_s: the time [s] that a reset takes to tare the sensors;
    it lies before the first observation, whose time is zero.
    """

    rate: float
    contacts: tuple[str, ...]
    joints: tuple[str, ...]
    lower: Array
    upper: Array
    tare_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Observation:
    """One tick's sensing of k contacts and n joints, in the world frame, at a time [s] from the trial's beginning on.

    points: (k, 3) contact points [m]; a contact that does not touch reports its fingertip's centre.
    normals: (k, 3) unit normals into the object; when it does not touch, that of the surface ahead where the sensor
    knows it, else the last sensed one, or where the finger closes to. forces: (k, 3) forces on the object [N], zero
    when it does not touch. touching: (k,).
    joints: (n,) joint positions [m or rad]. jacobian: (k, 3, n) of the contact points; angular_jacobian: (k, 3, n) of
    the fingertips' rotations; orientations: (k, 3) of the fingertips, exponential coordinates [rad].
    centre_of_mass: (3,) of the object [m] and weight: (3,) [N], known for an object that is held; else NaN.
    """

    time: Time
    points: Array
    normals: Array
    forces: Array
    touching: Flags
    joints: Array
    jacobian: Array
    angular_jacobian: Array
    orientations: Array
    centre_of_mass: Array
    weight: Array

    def row(self, row: int) -> Observation:
        """That of one of many trials."""
        return Observation(**{part.name: getattr(self, part.name)[row] for part in dataclasses.fields(self)})


@dataclass(frozen=True, slots=True)
class Command:
    """One tick's displacement: "q", (n,) of the joints [m or rad], or "x", (k, 3) of the contacts [m]."""

    space: str
    displacement: Array


@dataclass(frozen=True, slots=True)
class Truth:
    """The simulator's own account of one tick, for monitors, graders and tests.

    points, normals (into the object), forces (on the object): (k, 3), NaN where a contact does not touch.
    object_position: (3,) centre of mass [m]; object_rotation: (3, 3) of its body frame; object_axis: (3,) the body's
    major axis; object_lean [rad]: how far it has tilted from its start. touching_links: what else than fingertips
    presses on the object, by link name. table_links: what of the robot presses on the table, by link name.
    stopped_joints: names of the joints that the last step would have sent beyond their limits. loads: (4, 6), the net
    force [N] of each of PARTIES on the object and its moment [N·m] about the centre of mass, means over the tick; NaN
    where it is not known. They make up the change of the object's momentum in it, but for what it is fixed to.
    """

    points: Array
    normals: Array
    forces: Array
    object_position: Array
    object_rotation: Array
    object_axis: Array
    object_lean: float | Array
    touching_links: Names
    table_links: Names
    stopped_joints: Names
    loads: Array

    def row(self, row: int) -> Truth:
        """That of one of many trials."""
        return Truth(**{part.name: getattr(self, part.name)[row] for part in dataclasses.fields(self)})


@dataclass(frozen=True, slots=True)
class Start:
    """Where a trial begins: the pose of the hand's mounting face; what was drawn stands in ``drawn``.

    position: (3,) [m]; rotation: (3, 3), its z column points out of the palm. posture: joints of the hand [rad or m]
    that are not where its open posture has them.
    """

    position: Array
    rotation: Array
    drawn: Mapping[str, float]
    posture: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Palm:
    """The palm of a hand: position (3,) [m] of a point fixed in it, rotation (3, 3), and its Jacobian (6, n), linear
    then angular, of all actuated joints; world frame."""

    position: Array
    rotation: Array
    jacobian: Array


Shown = tuple[Observation, Truth]
Test = Generator[Command, Shown, Found]
"""What is done with a trial's hand after its end, a tick at a time: it gives commands, is shown what comes of each, and
finds something. A WorldCrashError is thrown where a command could not be carried out."""


class Witness(Protocol):
    """The truth behind a world; controllers never see it."""

    def truth(self) -> Truth:
        """The simulator's own account of the present tick."""
        ...


class World(Protocol):
    """Anything a controller can run on."""

    info: WorldInfo

    def reset(self, start: Start, seed: int) -> Observation:
        """Build the scene anew and take up the start. Raises InfeasibleStartError."""
        ...

    def step(self, command: Command) -> Observation:
        """Carry out one tick. Raises WorldCrashError."""
        ...

    def tare(self) -> None:
        """Take what the sensors read at rest as zero (nothing may touch)."""
        ...

    def close(self) -> None:
        """Give back what the world holds; it can be reset again afterwards."""
        ...


class WitnessedWorld(World, Witness, Protocol):
    """A world whose truth can be asked."""


@runtime_checkable
class ManyWorld(Witness, Protocol):
    """A world that runs many trials side by side, a tick of all at a time, whenever each has begun.

    Observations, commands and truths of N trials have a leading axis (N,); of the names in a truth there is a tuple for
    each trial.
    """

    info: WorldInfo

    def join(self, start: Start, seed: int) -> None:
        """One more trial takes up its start, behind those that have. Raises InfeasibleStartError."""
        ...

    def observe(self) -> Observation:
        """What all trials sense now."""
        ...

    def step(self, command: Command) -> Observation:
        """Carry out one tick of those that the command is for, the first M of all. The others have joined since: they
        are observed where they begin. Raises WorldCrashError; where that names those that crashed, the others have gone
        on, and can be observed once they alone are kept."""
        ...

    def witness(self, row: int) -> Witness:
        """Who knows the truth of one of the trials; a world of it alone, where it can be put to tests."""
        ...

    def keep(self, rows: Rows) -> None:
        """Go on with these of the trials alone."""
        ...

    def close(self) -> None:
        """Give back what the world holds; others may join afterwards."""
        ...


@runtime_checkable
class PalmWorld(World, Witness, Protocol):
    """A world with a hand whose palm can be led about, to test a grasp."""

    def palm(self) -> Palm:
        """Where the palm is and how joints move it."""
        ...
