"""A program on a hand of one's own: what a trial is in a world, for whoever has observations."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.pipeline import Tick, Ticks
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import listed
from graspdsl.hands.descriptions import joint_limits
from graspdsl.plugins.answering import answered_for
from graspdsl.spec.monitors import MONITORS
from graspdsl.spec.watching import OFF
from graspdsl.trials.batches import led
from graspdsl.trials.course import Course
from graspdsl.trials.outcomes import Ending
from graspdsl.trials.stages import stages_of
from graspdsl.worlds.protocol import PARTIES, Command, Observation, Truth, WorldInfo


@dataclass(frozen=True, slots=True)
class Turn:
    """What a loop says at one tick: the ``command`` to carry out; ``tick``, what the controller made of the
    observation; the number of the ``phase``; and the ``ending``, None while the program goes on."""

    command: Command
    tick: Tick
    phase: int
    ending: Ending | None


class ControlLoop:
    """A program on a hand of one's own, once: its phases, end conditions, monitors and time limits are those of a
    trial. After its ending, every command is to hold still.

    Times are those of the observations. These need not come evenly: where some are lost, the hand is slower, no more.

    Gains and caps of a spec are those of a tick of its world, ``program.world.rate`` of which make a second. ``rate``
    [Hz] is that of this loop, by default the same. A faster loop displaces joints by so much less a tick that they are
    as fast; a slower one by no more, for the share of an error that is taken off in a tick must not grow: it moves the
    hand more slowly. To displace contacts takes as long as it takes.
    """

    def __init__(self, program: Program, rate: float | None = None) -> None:
        if not isinstance(program, Program):
            raise TypeError(
                f"a ControlLoop runs a program, not a {type(program).__name__}: graspdsl.load reads a spec file"
            )
        self.program = program
        self._stages = stages_of(program)
        usual = program.world.rate
        self._share = 1.0 if rate is None else min(1.0, usual / rate)
        robot, has_joints = program.robot, program.world.has("hand")
        lower, upper = joint_limits(robot) if has_joints else ((), ())
        joints = tuple(robot.joints) if has_joints else ()
        self._info = WorldInfo(rate or usual, robot.contacts, joints, np.array(lower), np.array(upper))
        steps = [step for stage in self._stages for step in stage.pipeline.steps]
        self._read = {"points", "normals", "joints", *(step.reading for step in steps if step.reading is not None)}
        self._course: Course | None = None
        self._time = -np.inf
        self._ending: Ending | None = None

    @property
    def monitors(self) -> tuple[str, ...]:
        """The monitors that act on what a hand senses, by their keys in a spec."""
        return tuple(key for key in self._in_effect if not MONITORS[key].of_the_truth)

    @property
    def silent_monitors(self) -> tuple[str, ...]:
        """Those that are in effect, but say nothing without a truth: of other links than fingertips, of the table, and
        of how the object moves and leans."""
        return tuple(key for key in self._in_effect if MONITORS[key].of_the_truth)

    @property
    def _in_effect(self) -> list[str]:
        return [key for key in MONITORS if getattr(self.program.monitors, key) != OFF]

    def tick(self, observation: Observation, truth: Truth | None = None) -> Turn:
        """What to do now. truth: what else is known, by a camera, say; by default :func:`sensed_truth`, all that a hand
        senses, of which the ``silent_monitors`` see nothing.

        Raises ValueError, and it is no tick, where the observation is not of the program's contacts and joints, holds
        what is no number where one is read, or is not later than the one before.
        """
        self._check(observation)
        with answered_for(self.program.plugins):
            return self._ticked(observation, truth)

    def _ticked(self, observation: Observation, truth: Truth | None) -> Turn:
        seen = led(observation)
        true = led(sensed_truth(observation) if truth is None else truth)
        if self._course is None:
            self._course = Course(self.program, self._stages, self._info, 1, trajectories=False)
            self._course.begin(np.zeros(1, dtype=np.intp))
        self._time = observation.time
        if self._ending is not None:
            stage = self._course.stage(0)
            return self._turn(stage.phase, stage.pipeline.evaluate(observation))
        turns = self._course.tick(seen, true)
        self._ending = turns.endings.get(0)
        _, ticks = turns.made[-1]
        return self._turn(self._course.stage(0).phase, _first(ticks).alone(turns.command.space))

    def _turn(self, phase: int, tick: Tick) -> Turn:
        space = tick.command.space
        share = 0.0 if self._ending is not None else self._share if space == GradientSpace.JOINTS.value else 1.0
        return Turn(Command(space, share * tick.command.displacement), tick, phase, self._ending)

    def _check(self, observation: Observation) -> None:
        contacts, joints = len(self._info.contacts), len(self._info.joints)
        per_contact = dict.fromkeys(("points", "normals", "forces", "orientations"), (contacts, 3))
        turning = dict.fromkeys(("jacobian", "angular_jacobian"), (contacts, 3, joints))
        free = dict.fromkeys(("centre_of_mass", "weight"), (3,))
        shapes = {**per_contact, **turning, **free, "touching": (contacts,), "joints": (joints,)}
        for name, shape in shapes.items():
            if (found := np.shape(getattr(observation, name))) != shape:
                raise ValueError(f"{name} of an observation must be {shape}, not {found}")
        unread = [name for name in shapes if name in self._read and not np.isfinite(getattr(observation, name)).all()]
        if unread:
            raise ValueError(f"{listed(unread)} of the observation hold what is no number")
        if not self._time < observation.time < np.inf:
            raise ValueError(f"an observation of {observation.time:g} s comes after one of {self._time:g} s")


def sensed_truth(observation: Observation) -> Truth:
    """What a hand knows of the truth: the contacts that it feels, and where an object is that it holds.

    No other link touches anything, no object leans, none moves that is not held. Who knows better may replace fields.
    """
    felt = observation.touching[:, None]
    held = np.isfinite(observation.centre_of_mass)
    return Truth(
        points=np.where(felt, observation.points, np.nan),
        normals=np.where(felt, observation.normals, np.nan),
        forces=np.where(felt, observation.forces, np.nan),
        object_position=np.where(held, observation.centre_of_mass, 0.0),
        object_rotation=np.eye(3),
        object_axis=np.array([0.0, 0.0, 1.0]),
        object_lean=0.0,
        touching_links=(),
        table_links=(),
        stopped_joints=(),
        loads=np.full((len(PARTIES), 6), np.nan),
    )


def _first(ticks: Ticks) -> Ticks:
    """The first of many."""
    return Ticks(**{field.name: getattr(ticks, field.name)[0] for field in dataclasses.fields(ticks)})
