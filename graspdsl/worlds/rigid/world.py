"""A world of rigid bodies: a hand that feels with its fingertips, and an object on a table, in any engine."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.rotations import logarithm
from graspdsl.hands.descriptions import joint_limits
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import (
    Command,
    Observation,
    Palm,
    Start,
    Truth,
    WorldCrashError,
    WorldInfo,
)
from graspdsl.worlds.rigid.engine import CONTROL_RATE, Engine, EnginePose, Stage, StagedHand
from graspdsl.worlds.rigid.lean import Standing
from graspdsl.worlds.rigid.probing import Probe
from graspdsl.worlds.rigid.settling import resting_pose
from graspdsl.worlds.rigid.start_postures import StartPostures
from graspdsl.worlds.start_pose import root_pose
from graspdsl.worlds.touch.fingertip_sensor import Clock
from graspdsl.worlds.touch.fingertips import Fingertips

SETTLE_TICKS = 10
MOST_AHEAD = 0.05  # rad or m, of a target before its joint


class RigidWorld:
    """A world of rigid bodies under gravity; the fingertips are soft. Set up anew at each reset, so a trial repeats.

    Of a world that ``probes``, a displacement of the contacts, x, is one probe of many ticks; joint displacements, q,
    are carried out all the same, for the guarded close before the first probe.
    """

    def __init__(self, engine: Engine, settings: WorldSettings) -> None:
        self.settings = settings
        robot = settings.robot
        lower, upper = (np.array(limits) for limits in joint_limits(robot))
        self.info = WorldInfo(
            CONTROL_RATE, robot.contacts, tuple(robot.joints), lower, upper, settings.sensing.tare_time
        )
        self._engine, self._steps = engine, round(1.0 / (CONTROL_RATE * engine.time_step))
        self._stage: Stage | None = None
        self._resting: EnginePose | None = None
        self._postures: StartPostures | None = None

    @property
    def stage(self) -> Stage:
        """The scene that stands. Raises RuntimeError before the first reset."""
        if self._stage is None:
            raise RuntimeError("the world has not been reset")
        return self._stage

    @property
    def hand(self) -> StagedHand:
        """The hand of the scene that stands."""
        return self.stage.hand

    def reset(self, start: Start, seed: int) -> Observation:
        """Build the scene anew, put the hand at the start, its fingers about to touch, and tare."""
        self._end()
        robot, body, gravity = self.settings.robot, self.settings.body, self.settings.gravity
        if self._postures is None:
            if self.settings.anchor is Anchor.NONE:
                self._resting = resting_pose(self._engine, body, self.settings.table_friction, gravity)
            self._postures = StartPostures(self._engine, self.settings, self._resting)
        posture = self._postures.find(start)
        self._stage = stage = self._engine.stage(self.settings, *root_pose(robot, start))
        if self._resting is not None:
            stage.scene.place(self._resting)
        self._target = posture
        self._stopped = np.zeros(len(self.info.joints), dtype=bool)
        stage.hand.place(self._target)
        stage.soften()
        stage.hand.drive(self._target)
        if self.settings.anchor is Anchor.HAND:
            stage.attach()
        self._ticks = 0
        clock = Clock(CONTROL_RATE * self._steps, CONTROL_RATE)
        self._felt = stage.fingertips
        self._tips = Fingertips(self._felt, robot, self.settings.sensing, gravity, clock, seed)
        self._probe = Probe(stage.hand, self._tips, self._advance)
        for _ in range(SETTLE_TICKS):
            self._simulate()
        self.tare()
        topples = self.settings.anchor is not Anchor.AFLOAT
        self._standing = Standing.of(stage.scene.object_pose()[1], body.shape, topples)
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Displace the joints' targets by the command, within their limits, and simulate one tick."""
        self._stopped[:] = False
        if command.space == "q":
            self._advance(command.displacement)
        elif command.space == "x" and self.settings.probes:
            self._probe.displace(command.displacement)
        else:
            raise ValueError(f"a world of rigid bodies moves joints (q), or probes contacts (x), not {command.space}")
        return self._observe()

    def _advance(self, displacement: Array) -> None:
        """One tick with the joints' targets displaced by (n,) [m or rad], within their limits.

        A joint that something holds up is not driven ever further ahead of where it is.
        """
        now = self.hand.joints()
        wanted = np.clip(self._target + displacement, now - MOST_AHEAD, now + MOST_AHEAD)
        before, self._target = self._target, np.clip(wanted, self.info.lower, self.info.upper)
        self._stopped |= wanted != self._target
        self._simulate(before)
        self.stage.soften()
        self._ticks += 1

    def _simulate(self, before: Array | None = None) -> None:
        """One tick of physics, the motors' targets led from those ``before`` (n,) to the present ones.

        Targets that jump once a tick would shake an object loose in the hand.
        """
        stage, steps = self.stage, self._steps
        stage.forget()
        for step in range(1, steps + 1):
            if before is not None:
                stage.hand.drive(before + (self._target - before) * (step / steps))
            stage.step()
            self._tips.advance()

    def tare(self) -> None:
        """Rest for the time that the sensors take to tare, and take what they read then as their zero."""
        for _ in range(round(self.info.tare_s * CONTROL_RATE)):
            self._simulate()
            self._tips.note_rest()
        self._tips.tare()

    def _observe(self) -> Observation:
        reading, scene = self._tips.read(), self.stage.scene
        joints = self.hand.joints()
        if not np.isfinite(joints).all():
            raise WorldCrashError("a joint's position is not a number")
        linear, angular = self.hand.tip_jacobians(reading.local)
        held = self.settings.anchor is Anchor.HAND
        unknown = np.full(3, np.nan)
        return Observation(
            time=self._ticks / CONTROL_RATE,
            points=reading.points,
            normals=reading.normals,
            forces=reading.forces,
            touching=reading.touching,
            joints=joints,
            jacobian=linear,
            angular_jacobian=angular,
            orientations=logarithm(reading.rotations),
            centre_of_mass=scene.object_pose()[0] if held else unknown,
            weight=np.array([0.0, 0.0, -scene.mass * self.settings.gravity]) if held else unknown,
        )

    def palm(self) -> Palm:
        """Where the palm is and how joints move it."""
        return self.hand.palm()

    def truth(self) -> Truth:
        """The simulator's own account of the present tick."""
        points, normals, forces = self._felt.contacts()
        position, rotation = self.stage.scene.object_pose()
        return Truth(
            points=points,
            normals=normals,
            forces=forces,
            object_position=position,
            object_rotation=rotation,
            object_axis=rotation @ np.array(self.settings.body.major_axis),
            object_lean=self._standing.lean(rotation),
            touching_links=self.stage.other_links(),
            table_links=self.stage.table_links(),
            stopped_joints=tuple(
                name for name, is_stopped in zip(self.info.joints, self._stopped, strict=True) if is_stopped
            ),
            loads=self.stage.loads(),
        )

    @property
    def is_open(self) -> bool:
        """Whether a scene stands."""
        return self._stage is not None

    def close(self) -> None:
        """Shut the simulation down."""
        self._end()
        if self._postures is not None:
            self._postures.close()
            self._postures = None
        self._engine.close()

    def _end(self) -> None:
        """End the scene that stands."""
        if self._stage is not None:
            self._stage.close()
            self._stage = None
