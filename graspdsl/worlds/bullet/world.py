"""The bullet world: a hand that feels with its fingertips, an object on a table, physics by PyBullet."""

from __future__ import annotations

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.rotations import logarithm
from graspdsl.hands.descriptions import joint_limits
from graspdsl.worlds.bullet.engine import CONTROL_RATE, TIME_STEP, pybullet, silenced
from graspdsl.worlds.bullet.fingertips import BulletFingertips
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.pictures import camera_on_grasp, picture_of
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.settling import resting_pose
from graspdsl.worlds.bullet.start_postures import StartPostures
from graspdsl.worlds.camera import Picture
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
from graspdsl.worlds.start_pose import root_pose
from graspdsl.worlds.touch.fingertip_sensor import Clock
from graspdsl.worlds.touch.fingertips import Fingertips

PHYSICS_STEPS = round(1.0 / (CONTROL_RATE * TIME_STEP))  # a tick
SOLVER_ITERATIONS = 200  # at the engine's own 50, friction has not converged and what is held creeps in the hand
SETTLE_TICKS = 10
MOST_AHEAD = 0.05  # rad or m, of a target before its joint


class BulletWorld:
    """A world of rigid bodies under gravity; the fingertips are soft. Rebuilt at each reset, so a trial repeats.

    seen: whether pictures are taken of it.
    """

    def __init__(self, settings: WorldSettings, *, seen: bool = False) -> None:
        self.settings, self._seen = settings, seen
        robot = settings.robot
        lower, upper = (np.array(limits) for limits in joint_limits(robot))
        self.info = WorldInfo(
            CONTROL_RATE, robot.contacts, tuple(robot.joints), lower, upper, settings.sensing.tare_time
        )
        self._engine = pybullet()
        self._client = -1
        self._postures: StartPostures | None = None

    def reset(self, start: Start, seed: int) -> Observation:
        """Build the scene, put the hand at the start, its fingers about to touch, and tare."""
        self._end()
        engine, robot, body = self._engine, self.settings.robot, self.settings.body
        free = self.settings.anchor is Anchor.NONE
        pose = resting_pose(body, self.settings.table_friction, self.settings.gravity) if free else None
        if self._postures is None:
            self._postures = StartPostures(robot, body, self.settings.anchor, pose)
        posture = self._postures.find(start)
        with silenced():
            self._client = engine.connect(engine.DIRECT)
        client = self._client
        engine.setTimeStep(TIME_STEP, client)
        engine.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, numSolverIterations=SOLVER_ITERATIONS, physicsClientId=client
        )
        engine.setGravity(0, 0, -self.settings.gravity, client)
        self._scene = Scene(engine, client, body, self.settings.table_friction, self.settings.anchor, seen=self._seen)
        if pose is not None:
            self._scene.place(pose)
        self.hand = BulletHand(engine, client, robot, *root_pose(robot, start), self.settings.friction, seen=self._seen)
        self._target = posture
        self._stopped = np.zeros(len(self.info.joints), dtype=bool)
        self.hand.place(self._target)
        self.hand.drive(self._target)
        if self.settings.anchor is Anchor.HAND:
            self._scene.attach(self.hand)
        self._ticks = 0
        clock = Clock(CONTROL_RATE * PHYSICS_STEPS, CONTROL_RATE)
        self._felt = BulletFingertips(self.hand, self._scene)
        self._tips = Fingertips(self._felt, robot, self.settings.sensing, self.settings.gravity, clock, seed)
        for _ in range(SETTLE_TICKS):
            self._simulate()
        self.tare()
        self._scene.mark_rest()
        return self._observe()

    def step(self, command: Command) -> Observation:
        """Displace the joints' targets by the command, within their limits, and simulate one tick."""
        if command.space != "q":
            raise ValueError(f"the bullet world moves joints (q), not {command.space}")
        self._stopped[:] = False
        self._advance(command.displacement)
        return self._observe()

    def _advance(self, displacement: Array) -> None:
        """One tick with the joints' targets displaced by (n,) [m or rad], within their limits.

        A joint that something holds up is not driven ever further ahead of where it is.
        """
        now = self.hand.actuated(self.hand.all_joints())
        wanted = np.clip(self._target + displacement, now - MOST_AHEAD, now + MOST_AHEAD)
        before, self._target = self._target, np.clip(wanted, self.info.lower, self.info.upper)
        self._stopped |= wanted != self._target
        self._simulate(before)
        self.hand.press([float(forces.sum()) for _, forces in self._felt.presses()])
        self._ticks += 1

    def _simulate(self, before: Array | None = None) -> None:
        """One tick of physics, the motors' targets led from those ``before`` (n,) to the present ones.

        Targets that jump once a tick would shake an object loose in the hand.
        """
        self._scene.forget()
        for step in range(1, PHYSICS_STEPS + 1):
            if before is not None:
                self.hand.drive(before + (self._target - before) * (step / PHYSICS_STEPS))
            self._engine.stepSimulation(self._client)
            self._scene.note()
            self._tips.advance()

    def tare(self) -> None:
        """Rest for the time that the sensors take to tare, and take what they read then as their zero."""
        for _ in range(round(self.info.tare_s * CONTROL_RATE)):
            self._simulate()
            self._tips.note_rest()
        self._tips.tare()

    def _observe(self) -> Observation:
        reading = self._tips.read()
        joints = self.hand.all_joints()
        if not all(np.isfinite(joints)):
            raise WorldCrashError("a joint's position is not a number")
        pairs = [self.hand.jacobians(tip, p, joints) for tip, p in zip(self.hand.tips, reading.local, strict=True)]
        held = self.settings.anchor is Anchor.HAND
        unknown = np.full(3, np.nan)
        return Observation(
            time=self._ticks / CONTROL_RATE,
            points=reading.points,
            normals=reading.normals,
            forces=reading.forces,
            touching=reading.touching,
            joints=self.hand.actuated(joints),
            jacobian=np.array([linear for linear, _ in pairs]),
            angular_jacobian=np.array([angular for _, angular in pairs]),
            orientations=logarithm(reading.rotations),
            centre_of_mass=self._scene.object_pose()[0] if held else unknown,
            weight=np.array([0.0, 0.0, -self._scene.mass * self.settings.gravity]) if held else unknown,
        )

    def palm(self) -> Palm:
        """Where the palm is and how joints move it."""
        return self.hand.palm()

    def truth(self) -> Truth:
        """The simulator's own account of the present tick."""
        points, normals, forces = self._felt.contacts()
        position, rotation = self._scene.object_pose()
        return Truth(
            points=points,
            normals=normals,
            forces=forces,
            object_position=position,
            object_rotation=rotation,
            object_axis=rotation @ np.array(self.settings.body.major_axis),
            object_lean=self._scene.lean(),
            touching_links=self._scene.other_links(self.hand),
            table_links=self._scene.table_links(self.hand),
            stopped_joints=tuple(
                name for name, is_stopped in zip(self.info.joints, self._stopped, strict=True) if is_stopped
            ),
            loads=self._scene.loads(self.hand, self.settings.gravity),
        )

    def image(self, width: int = 640, height: int = 480) -> Picture:
        """A rendered (height, width, 3) picture of the scene, 0…255, with the software renderer."""
        contacts = range(len(self.hand.tips))
        camera = camera_on_grasp(self.hand, self._scene, contacts, width, height)
        return picture_of(self._engine, self._client, camera)

    @property
    def is_open(self) -> bool:
        """Whether a scene stands."""
        return self._client >= 0

    def close(self) -> None:
        """Shut the simulation down."""
        self._end()
        if self._postures is not None:
            self._postures.close()
            self._postures = None

    def _end(self) -> None:
        """End the scene that stands."""
        if self.is_open:
            self._engine.disconnect(self._client)
            self._client = -1
