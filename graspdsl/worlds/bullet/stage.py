"""PyBullet as an engine of rigid bodies: hand, object and table on a stage of its own."""

from __future__ import annotations

import math

from graspdsl.arrays import Array
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.engine import EFFORT, pybullet, silenced
from graspdsl.worlds.bullet.fingertips import BulletFingertips
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.kind import Anchor, Effort, WorldSettings


class BulletEngine:
    """PyBullet."""

    def __init__(self, effort: Effort = EFFORT) -> None:
        self._effort = effort

    @property
    def time_step(self) -> float:
        """Of a step [s]."""
        return self._effort.time_step

    def stage(self, settings: WorldSettings, position: Array, quaternion: Array) -> BulletStage:
        """Object, table and robot."""
        stage = BulletStage(self._effort, settings.body, settings.table_friction, settings.gravity, settings.anchor)
        stage.put_hand(settings, position, quaternion)
        return stage

    def table(self, body: Body, table_friction: float, gravity: float) -> BulletStage:
        """An object on the table."""
        return BulletStage(self._effort, body, table_friction, gravity, Anchor.NONE)

    def close(self) -> None:
        """Nothing is kept: the engine's own reset would not give the same numbers again."""


class BulletStage:
    """A world of the engine; without a hand until one is put there."""

    hand: BulletHand

    def __init__(self, effort: Effort, body: Body, table_friction: float, gravity: float, anchor: Anchor) -> None:
        self.engine, self._gravity, self._time_step = pybullet(), gravity, effort.time_step
        with silenced():
            self.client: int = self.engine.connect(self.engine.DIRECT)
        self.engine.setTimeStep(effort.time_step, self.client)
        self.engine.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, numSolverIterations=effort.solver_iterations, physicsClientId=self.client
        )
        self.engine.setGravity(0, 0, -gravity, self.client)
        self.scene = Scene(self.engine, self.client, body, table_friction, anchor)

    def put_hand(self, settings: WorldSettings, position: Array, quaternion: Array) -> None:
        """Put the robot's root at a position (3,) [m] and quaternion (4,)."""
        self.hand = BulletHand(self.engine, self.client, settings.robot, position, quaternion, settings.friction)
        if settings.anchor is Anchor.MOUNT:
            self.scene.stand_on(self.hand)
        self.fingertips = BulletFingertips(self.hand, self.scene)

    def step(self) -> None:
        """Simulate one time step, and note what acts on the object."""
        self.engine.stepSimulation(self.client)
        self.scene.note(self._time_step)

    def soften(self) -> None:
        """Give the fingertips the stiffness that belongs to how they press now."""
        self.hand.press([float(forces.sum()) for _, forces in self.fingertips.presses()])

    def attach(self) -> None:
        """Fix the object to the palm where it is."""
        self.scene.attach(self.hand)

    def clearance(self, links: set[int] | None, within: float) -> float:
        """The least distance [m] of links from table and object."""
        return self.scene.clearance(self.hand.body, links, within)

    def distance(self, link: int, within: float) -> float:
        """The distance [m] of a link from the object."""
        return min((pair[8] for pair in self.scene.closest(self.hand.body, link, within)), default=math.inf)

    def other_links(self) -> tuple[str, ...]:
        """Links that press on the object."""
        return self.scene.other_links(self.hand)

    def table_links(self) -> tuple[str, ...]:
        """Links that press on the table."""
        return self.scene.table_links(self.hand)

    def forget(self) -> None:
        """Forget what has acted on the object."""
        self.scene.forget()

    def loads(self) -> Array:
        """What PARTIES put on the object, but for the engine's own damping."""
        return self.scene.loads(self.hand, self._gravity)

    def close(self) -> None:
        """Give the engine's world back."""
        self.engine.disconnect(self.client)
