"""A world of rigid bodies: a hand that feels with its fingertips, and an object on a table, in any engine."""

from __future__ import annotations

import copy
from contextlib import ExitStack
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Rows
from graspdsl.basis.rotations import logarithm
from graspdsl.hands.descriptions import joint_limits
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import Command, Observation, Palm, Start, Truth, WorldCrashError, WorldInfo
from graspdsl.worlds.rigid.advancing import advance
from graspdsl.worlds.rigid.engine import CONTROL_RATE, Engine, EnginePose, Stage, StagedHand, Touched
from graspdsl.worlds.rigid.feeling import felt
from graspdsl.worlds.rigid.probing import Probe
from graspdsl.worlds.rigid.settling import resting_pose
from graspdsl.worlds.rigid.start_postures import StartPostures
from graspdsl.worlds.rigid.trial import RigidTrial
from graspdsl.worlds.start_pose import root_pose


class RigidWorld:
    """A world of rigid bodies under gravity; the fingertips are soft. Set up anew for each trial, so that it repeats.

    Of one trial, or of many side by side, each on a stage of its own. Of a world that ``probes``, a displacement of the
    contacts, x, is one probe of many ticks, of one trial alone; joint displacements, q, are carried out all the same,
    for the guarded close before the first probe.
    """

    def __init__(self, engine: Engine[Any], settings: WorldSettings) -> None:
        self.settings = settings
        robot = settings.robot
        lower, upper = (np.array(limits) for limits in joint_limits(robot))
        self.info = WorldInfo(
            CONTROL_RATE, robot.contacts, tuple(robot.joints), lower, upper, settings.sensing.tare_time
        )
        self._engine, self._steps = engine, round(1.0 / (CONTROL_RATE * engine.time_step))
        self._hold([])
        self._is_one = False
        self._resting: EnginePose | None = None
        self._postures: StartPostures | None = None

    def _hold(self, trials: list[RigidTrial]) -> None:
        """Go on with these."""
        self._trials = trials
        self._stages = self._engine.side_by_side([trial.stage for trial in trials])
        self._touched: Touched | None = None

    @property
    def _trial(self) -> RigidTrial:
        """The one that stands. Raises RuntimeError before the first reset."""
        if not self._trials:
            raise RuntimeError("the world has not been reset")
        return self._trials[0]

    @property
    def stage(self) -> Stage:
        """The scene that stands. Raises RuntimeError before the first reset."""
        return self._trial.stage

    @property
    def hand(self) -> StagedHand:
        """The hand of the scene that stands."""
        return self.stage.hand

    def reset(self, start: Start, seed: int) -> Observation:
        """Build the scene anew, put the hand at the start, its fingers about to touch, and tare."""
        self.keep(np.zeros(0, dtype=np.intp))
        self.join(start, seed)
        self._is_one = True
        return self.observe()

    def join(self, start: Start, seed: int) -> None:
        """The same of one more trial, beside those that have begun."""
        robot, body, gravity = self.settings.robot, self.settings.body, self.settings.gravity
        if self._postures is None:
            if self.settings.anchor is Anchor.NONE:
                self._resting = resting_pose(self._engine, body, self.settings.table_friction, gravity)
            self._postures = StartPostures(self._engine, self.settings, self._resting)
        posture = self._postures.find(start)
        stage = self._engine.stage(self.settings, *root_pose(robot, start))
        with ExitStack() as unless_it_begins:
            unless_it_begins.callback(stage.close)
            if self._resting is not None:
                stage.scene.place(self._resting)
            trial = RigidTrial(stage, self.settings, self.info, posture, self._steps, seed)
            unless_it_begins.pop_all()
        self._hold([*self._trials, trial])
        self._is_one = False

    def keep(self, rows: Rows) -> None:
        """End the other trials."""
        kept = [self._trials[row] for row in rows]
        for trial in self._trials:
            if trial not in kept:
                trial.stage.close()
        self._hold(kept)

    def step(self, command: Command) -> Observation:
        """Displace the joints' targets by the command, within their limits, and simulate one tick, but not of trials
        that have joined since."""
        displacement = command.displacement[None] if self._is_one else command.displacement
        for trial in self._trials:
            trial.stopped = np.zeros(len(self.info.joints), dtype=bool)
        if command.space == "q":
            self._advance(displacement)
        elif command.space == "x" and self.settings.probes:
            Probe(self.settings.robot, self._stages, self._trial.tips, self._advance).displace(displacement[0])
        else:
            raise ValueError(f"a world of rigid bodies moves joints (q), or probes contacts (x), not {command.space}")
        return self.observe()

    def _advance(self, displacement: Array) -> None:
        self._touched, crashed = advance(self._trials, self._stages, self.info, displacement)
        if crashed:
            raise WorldCrashError(next(iter(crashed.values())), crashed)

    def tare(self) -> None:
        """Rest for the time that the sensors take to tare, and take what they read then as their zero."""
        for trial in self._trials:
            trial.tare()
        self._touched = None

    def observe(self) -> Observation:
        """What the hands of all trials sense now."""
        stages, trials = self._stages, self._trials
        frames = stages.tip_frames()
        tips = felt(stages, frames, [trial.tips for trial in trials])
        linear, angular = stages.tip_jacobians(frames, tips.local)
        centres, weights = np.full((2, len(trials), 3), np.nan)
        if self.settings.anchor is Anchor.HAND:
            centres, _ = stages.object_poses()
            weights[:] = 0.0, 0.0, -trials[0].stage.scene.mass * self.settings.gravity
        seen = Observation(
            time=np.array([trial.ticks for trial in trials]) / CONTROL_RATE,
            points=tips.points,
            normals=tips.normals,
            forces=tips.forces,
            touching=tips.touching,
            joints=stages.joints(),
            jacobian=linear,
            angular_jacobian=angular,
            orientations=logarithm(tips.rotations),
            centre_of_mass=centres,
            weight=weights,
        )
        return seen.row(0) if self._is_one else seen

    def palm(self) -> Palm:
        """Where the palm is and how joints move it."""
        return self.hand.palm()

    def truth(self) -> Truth:
        """The simulator's own account of the present tick."""
        touched = self._stages.touched() if self._touched is None else self._touched
        positions, rotations = self._stages.object_poses()
        leans = [trial.standing.lean(rotation) for trial, rotation in zip(self._trials, rotations, strict=True)]
        true = Truth(
            points=touched.points,
            normals=touched.normals,
            forces=touched.forces,
            object_position=positions,
            object_rotation=rotations,
            object_axis=np.matvec(rotations, np.array(self.settings.body.major_axis)),
            object_lean=np.array(leans),
            touching_links=touched.other_links,
            table_links=touched.table_links,
            stopped_joints=tuple(trial.stopped_joints for trial in self._trials),
            loads=self._stages.loads(),
        )
        return true.row(0) if self._is_one else true

    def witness(self, row: int) -> RigidWorld:
        """One of the trials alone."""
        alone = copy.copy(self)
        alone._hold([self._trials[row]])
        alone._is_one = True
        return alone

    @property
    def is_open(self) -> bool:
        """Whether a scene stands."""
        return bool(self._trials)

    def close(self) -> None:
        """Shut the simulation down."""
        self.keep(np.zeros(0, dtype=np.intp))
        if self._postures is not None:
            self._postures.close()
            self._postures = None
        self._engine.close()
