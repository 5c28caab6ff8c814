"""The bullet world: a hand that feels with its fingertips, an object on a table, physics by PyBullet."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.basis.rotations import logarithm
from graspdsl.hands.descriptions import Robot, joint_limits
from graspdsl.objects.shapes import Body
from graspdsl.spec.sensing import LoadCell, TactileSensor
from graspdsl.worlds.bullet.camera import Picture, taken
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.framing import camera_on_grasp
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.reach import ArmReach
from graspdsl.worlds.bullet.scene import Anchor, Scene
from graspdsl.worlds.bullet.settling import TIME_STEP, resting_pose
from graspdsl.worlds.bullet.touch import Clock, Fingertips
from graspdsl.worlds.protocol import (
    GRAVITY,
    Command,
    InfeasibleStartError,
    Observation,
    Palm,
    Start,
    Truth,
    WorldCrashError,
    WorldInfo,
)

CONTROL_RATE = 50.0  # Hz
PHYSICS_STEPS = round(1.0 / (CONTROL_RATE * TIME_STEP))  # a tick
SOLVER_ITERATIONS = 200  # at the engine's own 50, friction has not converged and what is held creeps in the hand
SETTLE_TICKS = 10
TABLE_FRICTION = 0.5
CLEARANCE = 0.004  # m that a start keeps between the hand and everything else
CLOSING_STEP = 0.02  # rad
MOST_AHEAD = 0.05  # rad or m, of a target before its joint
PRESHAPE = 0.012  # m between a tip and the object when a trial begins


@dataclass(frozen=True, slots=True)
class BulletSettings:
    """What of a spec's scene the bullet world needs. friction: coefficient between fingertips and object."""

    robot: Robot
    body: Body
    friction: float
    sensing: TactileSensor = field(default_factory=LoadCell)
    anchor: Anchor = Anchor.NONE
    gravity: float = GRAVITY
    table_friction: float = TABLE_FRICTION


def root_pose(robot: Robot, start: Start) -> tuple[Array, Array]:
    """Position (3,) [m] and quaternion (4,) of the robot's root: where its arm stands, else at the start pose."""
    base = robot.mount.base
    if base is None:
        return start.position, Rotation.from_matrix(start.rotation).as_quat()
    return np.array(base.position), Rotation.from_euler("xyz", base.rpy).as_quat()


class BulletWorld:
    """A world of rigid bodies under gravity; the fingertips are soft. Rebuilt at each reset, so a trial repeats."""

    def __init__(self, settings: BulletSettings) -> None:
        self.settings = settings
        robot = settings.robot
        lower, upper = (np.array(limits) for limits in joint_limits(robot))
        self.info = WorldInfo(
            CONTROL_RATE, robot.contacts, tuple(robot.joints), lower, upper, settings.sensing.tare_time
        )
        self._engine = pybullet()
        self._client = -1

    def reset(self, start: Start, seed: int) -> Observation:
        """Build the scene, put the hand at the start, its fingers about to touch, and tare."""
        self.close()
        engine = self._engine
        with silenced():
            self._client = engine.connect(engine.DIRECT)
        client = self._client
        engine.setTimeStep(TIME_STEP, client)
        engine.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, numSolverIterations=SOLVER_ITERATIONS, physicsClientId=client
        )
        engine.setGravity(0, 0, -self.settings.gravity, client)
        self._scene = Scene(engine, client, self.settings.body, self.settings.table_friction, self.settings.anchor)
        if self.settings.anchor is Anchor.NONE:
            pose = resting_pose(self.settings.body, self.settings.table_friction, self.settings.gravity)
            self._scene.place(pose)
        robot = self.settings.robot
        self.hand = BulletHand(engine, client, robot, *root_pose(robot, start), self.settings.friction)
        self._target = self._start_posture(start)
        self._stopped = np.zeros(len(self.info.joints), dtype=bool)
        self.hand.place(self._target)
        self.hand.drive(self._target)
        if self.settings.anchor is Anchor.HAND:
            self._scene.attach(self.hand)
        self._ticks = 0
        clock = Clock(CONTROL_RATE * PHYSICS_STEPS, CONTROL_RATE)
        self._tips = Fingertips(self.hand, self._scene, self.settings.sensing, self.settings.gravity, clock, seed)
        for _ in range(SETTLE_TICKS):
            self._simulate()
        self.tare()
        self._scene.mark_rest()
        return self._observe()

    def _start_posture(self, start: Start) -> Array:
        """The joints (n,) at the start, each finger closed until its tip is about to touch the object.

        A start is infeasible when the arm cannot reach it, or a finger has no free place, or meets the object with
        another link, or not at all.
        """
        robot = self.settings.robot
        known = {**robot.hand.postures["open"], **start.posture}
        opened = np.array([known.get(name, 0.0) for name in robot.joints])
        if robot.mount.base is None:
            return self._standing_free([self._preshape(opened)])
        reaching = ArmReach(self.hand, start.position, start.rotation, self.info.lower, self.info.upper)
        first = reaching.any_posture(opened)
        # How the fingers close does not depend on how the arm holds the hand.
        return self._standing_free(reaching.postures(self._preshape(first)))

    def _standing_free(self, postures: Sequence[Array]) -> Array:
        """The first of some postures that keeps clear of the table and the object."""
        for posture in postures:
            self.hand.place(posture)
            if self._scene.clearance(self.hand.body, None, CLEARANCE) >= CLEARANCE:
                return posture
        raise InfeasibleStartError("the robot would stand in the table or the object")

    def _preshape(self, posture: Array) -> Array:
        """A posture (n,) with each finger closed until its tip is about to touch the object."""
        robot = self.settings.robot
        names = list(robot.joints)
        closed = np.array([robot.hand.postures["closed"].get(name, 0.0) for name in names])
        for (name, contact), tip in zip(robot.hand.contacts.items(), self.hand.tips, strict=True):
            mine = np.isin(names, contact.finger)
            posture = self._close_finger(posture, np.where(mine, closed - posture, 0.0), contact.finger, tip.link, name)
        return posture

    def _close_finger(self, posture: Array, motion: Array, joints: tuple[str, ...], tip: int, name: str) -> Array:
        """Close one finger in small steps until its tip touches the object; the posture shortly before that."""
        links = self._links_beyond(joints)
        ready: Array | None = None
        for share in np.arange(0.0, 1.0, CLOSING_STEP / float(np.abs(motion).max())):
            candidate = posture + share * motion
            self.hand.place(candidate)
            distance = self._scene.distance_to_object(self.hand.body, tip, PRESHAPE)
            if ready is not None and distance <= 0.0:
                return ready
            if self._scene.clearance(self.hand.body, links - {tip}, CLEARANCE) < CLEARANCE:
                ready = None
            elif distance >= PRESHAPE or (ready is None and distance >= CLEARANCE):
                ready = candidate
        raise InfeasibleStartError(f"{name} cannot close on the object with its tip")

    def _links_beyond(self, joints: tuple[str, ...]) -> set[int]:
        moved = {self.hand.joint_index[name] for name in joints}
        for index, parent in enumerate(self.hand.parents):
            if parent in moved:
                moved.add(index)
        return moved

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
        self.hand.press([float(forces.sum()) for _, forces in self._scene.tip_presses(self.hand)])
        self._ticks += 1

    def _simulate(self, before: Array | None = None) -> None:
        """One tick of physics, the motors' targets led from those ``before`` (n,) to the present ones.

        Targets that jump once a tick would shake an object loose in the hand.
        """
        for step in range(1, PHYSICS_STEPS + 1):
            if before is not None:
                self.hand.drive(before + (self._target - before) * (step / PHYSICS_STEPS))
            self._engine.stepSimulation(self._client)
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
        points, normals, forces = self._scene.tip_contacts(self.hand)
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
        )

    def image(self, width: int = 640, height: int = 480) -> Picture:
        """A rendered (height, width, 3) picture of the scene, 0…255, with the software renderer."""
        contacts = range(len(self.hand.tips))
        camera = camera_on_grasp(self.hand, self._scene, contacts, width, height)
        return taken(self._engine, self._client, camera)

    @property
    def is_open(self) -> bool:
        """Whether a scene stands."""
        return self._client >= 0

    def close(self) -> None:
        """Shut the simulation down."""
        if self.is_open:
            self._engine.disconnect(self._client)
            self._client = -1
