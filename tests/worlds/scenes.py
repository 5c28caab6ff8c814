"""Scenes of the bullet world for the tests: hands alone, starts, closed grasps, and what the engine knows of them."""

from __future__ import annotations

import contextlib
import hashlib
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program, program_of
from graspdsl.hands.descriptions import HERE, Robot, robot
from graspdsl.objects.shapes import Body, catalogue
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.stages import BulletEngine
from graspdsl.worlds.kind import WorldSettings
from graspdsl.worlds.protocol import Command, Observation, Start
from graspdsl.worlds.rigid.world import RigidWorld
from graspdsl.worlds.start_pose import pose

ROBOT = robot("barrett", "gantry")
JOINTS = tuple(ROBOT.joints)
ROLL = catalogue()["towel-roll"]
MAIN = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
LEVEL = {"roll": 0.0, "height": 0.10, "standoff": 0.047, "yaw": 0.0, "offset": 0.0, "tilt": 0.0}


def side_start(body: Body = ROLL, /, **drawn: float) -> Start:
    """A start from the side; what is not given is level, 47 mm before the middle of a towel roll."""
    return pose("side", {**LEVEL, **drawn}, body, ROBOT.hand.palm_surface)


def settings(**changes: Any) -> WorldSettings:
    """The towel roll before the Barrett hand, with changes."""
    return WorldSettings(**{"robot": ROBOT, "body": ROLL, "friction": 0.4, **changes})


def bullet_world(settings: WorldSettings) -> RigidWorld:
    """A world by PyBullet."""
    return RigidWorld(BulletEngine(), settings)


def main_program(*overrides: str) -> Program:
    """The sliding experiment on the towel roll, with overrides."""
    return program_of(MAIN.read_text("utf-8"), MAIN.name, overrides)


def with_uneven_tips(folder: Path) -> Robot:
    """The Barrett hand with tips whose centres of mass are elsewhere and whose axes of inertia are turned."""
    tree = ET.parse(HERE / ROBOT.hand.urdf)
    for link in tree.getroot().iter("link"):
        if link.get("name", "").startswith("tip-"):
            for origin in link.findall("inertial/origin"):
                origin.attrib.update(xyz="0.004 0.003 -0.002", rpy="0.3 -0.5 0.7")
    tree.write(folder / "uneven.urdf")
    return Robot(hand=ROBOT.hand.model_copy(update={"urdf": str(folder / "uneven.urdf")}), mount=ROBOT.mount)


@contextlib.contextmanager
def opened(world: RigidWorld) -> Iterator[RigidWorld]:
    """A world that is closed at the end."""
    try:
        yield world
    finally:
        world.close()


@contextlib.contextmanager
def lone_hand(
    position: Array | None = None, rotation: Array | None = None, robot: Robot = ROBOT
) -> Iterator[tuple[Any, int, BulletHand]]:
    """The engine, its client and a hand on its mount with nothing about it."""
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    quaternion = Rotation.from_matrix(np.eye(3) if rotation is None else rotation).as_quat()
    try:
        yield (
            engine,
            client,
            BulletHand(engine, client, robot, np.zeros(3) if position is None else position, quaternion, 0.4),
        )
    finally:
        engine.disconnect(client)


def moved(**joints: float) -> Command:
    """A command that displaces joints, by names with underscores for hyphens."""
    displacement = np.zeros(len(JOINTS))
    for name, value in joints.items():
        displacement[JOINTS.index(name.replace("_", "-"))] = value
    return Command("q", displacement)


def still() -> Command:
    """A command that moves nothing."""
    return moved()


def run_phase(world: RigidWorld, program: Program, phase: int, ticks: int, seen: Observation) -> list[Observation]:
    """What the world shows while the controller of a phase runs for some ticks."""
    pipeline = program.pipelines()[phase][0]
    shown = []
    for _ in range(ticks):
        seen = world.step(pipeline.evaluate(seen).command)
        shown.append(seen)
    return shown


def grasped(world: RigidWorld, start: Start, program: Program, ticks: int = 200) -> Observation:
    """Reset, and close the fingers until they press with the program's force."""
    seen = run_phase(world, program, 0, ticks, world.reset(start, 0))[-1]
    assert seen.touching.all()
    return seen


def numbers(seen: Observation) -> bytes:
    """Every bit of an observation."""
    fields = (getattr(seen, name) for name in seen.__slots__)
    return b"".join(np.asarray(value).tobytes() for value in fields)


def digest(commands: Array) -> str:
    """A hash of all that a new world shows while commands (t, n) are carried out."""
    with opened(bullet_world(settings())) as world:
        shown = [numbers(world.reset(side_start(roll=0.4), 0))]
        shown += [numbers(world.step(Command("q", row))) for row in commands]
    return hashlib.sha256(b"".join(shown)).hexdigest()


def pose_of_palm(world: RigidWorld) -> tuple[Array, Rotation]:
    """Where the palm is."""
    engine, hand = pybullet(), world.hand
    state = engine.getLinkState(hand.body, hand.link_index["palm"], physicsClientId=world.stage.client)
    return np.array(state[4]), Rotation.from_quat(state[5])


def pose_of_object(world: RigidWorld) -> tuple[Array, Rotation]:
    """Where the object is."""
    position, quaternion = pybullet().getBasePositionAndOrientation(world.stage.scene.object, world.stage.client)
    return np.array(position), Rotation.from_quat(quaternion)


def force_of_table(world: RigidWorld) -> Array:
    """The force (3,) [N] with which the table bears the object."""
    scene = world.stage.scene
    total = np.zeros(3)
    for contact in pybullet().getContactPoints(scene.object, scene.table, physicsClientId=world.stage.client):
        # The normal points from the table to the object; friction is told as it acts on the table.
        total += contact[9] * np.array(contact[7])
        total -= contact[10] * np.array(contact[11]) + contact[12] * np.array(contact[13])
    return total
