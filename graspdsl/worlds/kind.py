"""What a kind of world is: what it can do, said without starting it, what it is made from, and how it is seen again."""

from __future__ import annotations

import enum
import importlib.util
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, Literal, Protocol

from graspdsl.arrays import Array
from graspdsl.backends import NUMPY, Backend
from graspdsl.basis.spaces import GradientSpace
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shapes import Body
from graspdsl.spec.scene import GRAVITY, Physics
from graspdsl.spec.sensing import LoadCell, Sensing, TactileSensor, sensor_of
from graspdsl.worlds.camera import HEIGHT, OVERSAMPLING, WIDTH, Camera, Picture
from graspdsl.worlds.protocol import Start, WitnessedWorld

TABLE_FRICTION = 0.5
WHOLE = 1e-4  # of a tick: that a time step with five digits may be off

Ability = Literal["hand", "forces", "friction", "weight", "motion", "parting", "holding", "lifting", "edges"]
"""What a world may lack: a hand that carries the contacts; forces that they feel; friction; weight of the object; an
object that moves; contacts that part from it; objects that a hand holds; grasps tried by lifting and shaking; objects
with edges."""


@dataclass(frozen=True, slots=True)
class Effort:
    """How finely physics is worked out: its time step [s], and the most iterations of its solver in a step."""

    time_step: float
    solver_iterations: int

    def steps(self, rate: float) -> int:
        """How many steps of physics a tick has, at so many ticks a second [Hz]."""
        return round(1.0 / (rate * self.time_step))

    def whole(self, rate: float) -> Effort:
        """The same with the time step of which a tick is a whole number, to the last digit."""
        return replace(self, time_step=1.0 / (rate * self.steps(rate)))

    def divides(self, rate: float) -> bool:
        """Whether a tick is a whole number of steps."""
        steps = 1.0 / (rate * self.time_step)
        return steps > 0.5 and abs(steps - round(steps)) < WHOLE * steps


class Anchor(enum.Enum):
    """What the object is fixed to when a trial starts."""

    NONE = "free, standing on the table"
    AFLOAT = "free and without weight, the table out of the way"
    HAND = "held by the hand, the table out of the way"
    WORLD = "fixed to the world"
    MOUNT = "held by another hand of the mount, which keeps still, the table out of the way"


def fixed_to(robot: Robot) -> Anchor:
    """What an object that is fixed is fixed to: the hand of the mount that holds objects, or else the world."""
    return Anchor.MOUNT if robot.mount.holds else Anchor.WORLD


@dataclass(frozen=True, slots=True)
class WorldSettings:
    """What of a program a world is made from.

    friction: coefficient between fingertips and object; gravity [m/s²]. probes: a displacement of the contacts is one
    probe of many ticks. effort: None where there is no physics, or it is as is usual. backend: what moves contacts
    where there is none.
    """

    robot: Robot
    body: Body
    friction: float
    sensing: TactileSensor = field(default_factory=LoadCell)
    anchor: Anchor = Anchor.NONE
    probes: bool = False
    gravity: float = GRAVITY
    table_friction: float = TABLE_FRICTION
    effort: Effort | None = None
    backend: Backend = NUMPY


@dataclass(frozen=True, slots=True)
class View:
    """What of a stored trial is looked at: the contacts that are drawn and, among them, those of the grasp, by number.

    start: where the hand began, None in a world without one; window: on the screen.
    """

    settings: WorldSettings
    start: Start | None
    contacts: Sequence[int]
    grasp: Sequence[int]
    window: bool = False


class TrialStudio(Protocol):
    """A world to look at: things stand where they are put, and nothing is simulated. To be closed."""

    @property
    def is_open(self) -> bool:
        """Whether the world, or its window, is still there."""
        ...

    def show(self, at: Mapping[str, Array]) -> None:
        """Put everything where a row of a trajectory has it."""
        ...

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows all of it as it stands."""
        ...

    def picture(self, camera: Camera, oversampling: int = OVERSAMPLING) -> Picture:
        """What a camera sees now."""
        ...

    def close(self) -> None:
        """Give the world back."""
        ...


class WorldKind(ABC):
    """A kind of world, by its name in a spec.

    ``rate``: of its ticks [Hz]. ``sliding``, ``probing``: the gradient spaces that it can carry out, by the way in
    which contacts are displaced. ``at_once``: a contact gets to another place within a tick, however far, so that it
    need not be probed. ``together``: how many trials it runs side by side; ``worth_a_worker``: how many make it worth
    another process. ``pace``: how contacts move where they are
    not probed; ``contacts``: what they are called. ``approaches``: the starts that it has. ``knows_object``: where the
    object is, is known though nothing holds it; ``knows_surface``: it stays at the origin, and how it curves is known,
    too. ``lacks``: what it has not, each with the reason as messages give it. ``effort``: the usual one of its physics,
    None where none can be chosen. ``libraries``: distributions that it needs and its numbers depend on, imported by the
    same names, each with how it is installed.
    """

    name: ClassVar[str]
    about: ClassVar[str]
    rate: ClassVar[float]
    sliding: ClassVar[frozenset[GradientSpace]]
    probing: ClassVar[frozenset[GradientSpace]]
    at_once: ClassVar[bool] = False
    together: ClassVar[int] = 1
    worth_a_worker: ClassVar[int] = 4
    pace: ClassVar[str] = "contacts slide"
    contacts: ClassVar[str] = "contacts"
    approaches: ClassVar[tuple[str, ...]] = ("side", "top")
    knows_object: ClassVar[bool] = False
    knows_surface: ClassVar[bool] = False
    lacks: ClassVar[Mapping[Ability, str]] = {}
    effort: ClassVar[Effort | None] = None
    libraries: ClassVar[Mapping[str, str]] = {}

    @property
    @abstractmethod
    def senses(self) -> tuple[str, ...]:
        """The names of the tactile sensors that it has, the usual one first."""

    @abstractmethod
    def make(self, settings: WorldSettings) -> WitnessedWorld:
        """A world to run trials in."""

    @abstractmethod
    def studio(self, view: View) -> TrialStudio:
        """A world in which a stored trial is looked at."""

    @property
    def missing(self) -> tuple[str, ...]:
        """Those of its libraries that are not installed."""
        return tuple(name for name in self.libraries if importlib.util.find_spec(name) is None)

    def effort_in(self, physics: Physics | None) -> Effort | None:
        """How finely a spec's scene has physics worked out here, None where that cannot be chosen."""
        if physics is None or self.effort is None:
            return self.effort
        return Effort(
            self.effort.time_step if physics.time_step is None else physics.time_step,
            self.effort.solver_iterations if physics.solver_iterations is None else physics.solver_iterations,
        )

    def has(self, ability: Ability) -> bool:
        """Whether it has what a world may lack."""
        return ability not in self.lacks

    def spaces(self, displacement: str) -> frozenset[GradientSpace]:
        """The gradient spaces of a way to displace contacts, ``sliding`` or ``probing``."""
        return self.probing if displacement == "probing" else self.sliding

    def probes(self, displacement: str) -> bool:
        """Whether a displacement of the contacts is one probe of many ticks."""
        return displacement == "probing" and not self.at_once

    def sensor(self, choice: str | Sensing | None) -> TactileSensor:
        """What contacts feel through: what a spec's scene names or describes, or what is usual here."""
        return sensor_of(choice or self.senses[0])
