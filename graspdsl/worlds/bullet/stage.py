"""A stage of PyBullet: hand, object and table in a world of their own."""

from __future__ import annotations

import math
from collections.abc import Callable

from graspdsl.arrays import Array
from graspdsl.objects.shapes import Body
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.fingertips import BulletFingertips
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.kind import Anchor, Effort, WorldSettings
from graspdsl.worlds.rigid.engine import stretches


class BulletStage:
    """A world of the engine; without a hand until one is put there."""

    hand: BulletHand

    def __init__(self, effort: Effort, body: Body, table_friction: float, gravity: float, anchor: Anchor) -> None:
        self.engine, self.gravity, self.time_step = pybullet(), gravity, effort.time_step
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
        """Simulate one time step."""
        self.engine.stepSimulation(self.client)

    def simulate(self, targets: Array, sense: Callable[[int], int]) -> None:
        """Simulate a tick."""
        self.scene.forget()
        for ahead in stretches(len(targets), sense):
            for target in targets[ahead]:
                self.hand.drive(target)
                self.step()
                self.scene.note()

    def attach(self) -> None:
        """Fix the object to the palm where it is."""
        self.scene.attach(self.hand)

    def clearance(self, links: set[int] | None, within: float) -> float:
        """The least distance [m] of links from table and object."""
        return self.scene.clearance(self.hand.body, links, within)

    def distance(self, link: int, within: float) -> float:
        """The distance [m] of a link from the object."""
        return min((pair[8] for pair in self.scene.closest(self.hand.body, link, within)), default=math.inf)

    def close(self) -> None:
        """Give the engine's world back."""
        self.engine.disconnect(self.client)
