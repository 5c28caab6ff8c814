"""Worlds to look at: bodies stand where they are put, and nothing is simulated."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Self

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shapes import Body
from graspdsl.objects.surfaces.surface import Surface
from graspdsl.worlds.bullet.engine import pybullet, silenced
from graspdsl.worlds.bullet.hand import BulletHand
from graspdsl.worlds.bullet.pictures import camera_on_grasp, picture_of
from graspdsl.worlds.bullet.scene import Scene
from graspdsl.worlds.bullet.settling import resting_pose
from graspdsl.worlds.bullet.solids import visual_of
from graspdsl.worlds.camera import HEIGHT, OVERSAMPLING, WIDTH, Camera, Picture, box_corners, camera_on
from graspdsl.worlds.kind import Anchor, WorldSettings
from graspdsl.worlds.protocol import Start
from graspdsl.worlds.start_pose import root_pose

ASIDE = np.array([0.55, -0.75, 0.42])  # from where what has no palm is seen
BALL = 0.0035  # m, radius
CONTACT = (0.13, 0.42, 0.62, 1.0)


class Studio:
    """An engine's world without physics, offscreen or in a window. To be closed, or used in a ``with``."""

    def __init__(self, *, window: bool = False) -> None:
        self.engine = pybullet()
        with silenced():
            self.client: int = self.engine.connect(self.engine.GUI if window else self.engine.DIRECT)

    def picture(self, camera: Camera, oversampling: int = OVERSAMPLING) -> Picture:
        """What a camera sees now."""
        return picture_of(self.engine, self.client, camera, oversampling)

    @property
    def is_open(self) -> bool:
        """Whether the world, or its window, is still there."""
        return bool(self.client >= 0 and self.engine.isConnected(self.client))

    def close(self) -> None:
        """Give the world back."""
        if self.is_open:
            self.engine.disconnect(self.client)
        self.client = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


class GraspStudio(Studio):
    """The hand and the object of a bullet world, the robot's root standing as at a start.

    grasp: the contacts, by number, that a camera must show.
    """

    def __init__(self, settings: WorldSettings, start: Start, grasp: Sequence[int], *, window: bool = False) -> None:
        super().__init__(window=window)
        self._grasp = grasp
        self.scene = Scene(self.engine, self.client, settings.body, settings.table_friction, settings.anchor, seen=True)
        root = root_pose(settings.robot, start)
        self.hand = BulletHand(self.engine, self.client, settings.robot, *root, settings.friction, seen=True)

    def show(self, at: Mapping[str, Array]) -> None:
        """Put the joints (n,) [m or rad], and the object's centre of mass (3,) [m] and rotation (3, 3)."""
        self.hand.place(at["joints"])
        self.scene.put(at["object_position"], at["object_rotation"])

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows the grasp as it stands."""
        return camera_on_grasp(self.hand, self.scene, self._grasp, width, height)


class SurfaceStudio(Studio):
    """A surface about the origin and contacts that float on it, by number, drawn as small balls."""

    def __init__(self, surface: Surface, contacts: Sequence[int], *, window: bool = False) -> None:
        super().__init__(window=window)
        self._contacts = list(contacts)
        engine, client = self.engine, self.client
        mesh = surface.mesh(48)
        visual = visual_of(engine, client, [Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces)])
        engine.createMultiBody(0.0, -1, visual, physicsClientId=client)
        self._half = np.array(surface.extent) / 2
        ball = engine.createVisualShape(engine.GEOM_SPHERE, radius=BALL, rgbaColor=CONTACT, physicsClientId=client)
        self._balls = [engine.createMultiBody(0.0, -1, ball, physicsClientId=client) for _ in contacts]

    def show(self, at: Mapping[str, Array]) -> None:
        """Put the contacts at their points [m]."""
        for ball, point in zip(self._balls, at["points"][self._contacts], strict=True):
            self.engine.resetBasePositionAndOrientation(ball, point.tolist(), (0, 0, 0, 1), self.client)

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows all of the surface."""
        return camera_on(1.25 * box_corners(-self._half, self._half), ASIDE, width, height)


class ObjectStudio(Studio):
    """An object alone, standing on the table as it comes to rest there. Raises UnstableObjectError."""

    def __init__(self, body: Body, table_friction: float, gravity: float, *, window: bool = False) -> None:
        pose = resting_pose(body, table_friction, gravity)
        super().__init__(window=window)
        self.scene = Scene(self.engine, self.client, body, table_friction, Anchor.NONE, seen=True)
        self.scene.place(pose)

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows all of the object."""
        return camera_on(self.scene.object_corners(), ASIDE, width, height)


class HandStudio(Studio):
    """A robot alone, nothing about it."""

    def __init__(self, robot: Robot, *, window: bool = False) -> None:
        super().__init__(window=window)
        start = Start(np.zeros(3), np.eye(3), {})
        self.hand = BulletHand(self.engine, self.client, robot, *root_pose(robot, start), 0.0, seen=True)

    def show(self, joints: Array) -> None:
        """Put the joints (n,) [m or rad]."""
        self.hand.place(joints)

    def tips(self) -> Array:
        """The middles (k, 3) [m] of the fingertips as they stand, in the order of the robot's contacts."""
        frames = zip(self.hand.tips, self.hand.tip_frames(), strict=True)
        return np.array([origin + rotation @ tip.centre for tip, (origin, rotation) in frames])

    def camera(self, postures: Sequence[Array], width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows the hand in each of these postures (n,)."""
        corners = []
        for posture in postures:
            self.hand.place(posture)
            for link in self.hand.hand_links():
                box = self.engine.getAABB(self.hand.body, self.hand.link_index[link], self.client)
                corners.append(box_corners(*map(np.array, box)))
        return camera_on(np.concatenate(corners), ASIDE, width, height)
