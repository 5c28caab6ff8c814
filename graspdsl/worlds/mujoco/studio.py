"""Worlds to look at, whatever world ran: things stand where they are put, and nothing is simulated."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from types import TracebackType
from typing import Any, Self

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, coupling_of
from graspdsl.objects.shading import Shaded
from graspdsl.objects.shape import shaded
from graspdsl.objects.shapes import Body
from graspdsl.worlds.camera import HEIGHT, OVERSAMPLING, WIDTH, Camera, Picture, box_corners, camera_on, grasp_direction
from graspdsl.worlds.kind import View
from graspdsl.worlds.mujoco.effort import EFFORT
from graspdsl.worlds.mujoco.looks import put_contacts, put_object, put_table, robot_looks
from graspdsl.worlds.mujoco.model import OBJECT, quaternion_of
from graspdsl.worlds.mujoco.pictures import Painter
from graspdsl.worlds.mujoco.stages import MujocoEngine
from graspdsl.worlds.protocol import NoWindowError, Start
from graspdsl.worlds.rigid.engine import OUT_OF_THE_WAY, stands_free
from graspdsl.worlds.rigid.settling import resting_pose
from graspdsl.worlds.start_pose import root_pose

FACETS = 48  # half around, of a surface that contacts float on
MIDDLE, REACH = [0.0, 0.0, 0.1], 0.4  # m, of what a window shows at first
ASIDE = np.array([0.55, -0.75, 0.42])  # from where what has no palm is seen


class Studio:
    """A model that is only seen, offscreen or in a window. To be closed, or used in a ``with``.

    Raises NoWindowError when a window cannot be opened.
    """

    def __init__(self, spec: mujoco.MjSpec, *, window: bool) -> None:
        spec.stat.center, spec.stat.extent = MIDDLE, REACH
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self._painter = Painter(self.model, self.data)
        self._is_open, self._window = True, _window(self.model, self.data) if window else None
        self.moved()

    def put(self, position: Array, quaternion: Array) -> None:
        """Put the object's frame at a position (3,) [m] and quaternion (4,), w first; ``moved`` moves it."""
        self.data.joint(OBJECT).qpos[:] = [*position, *quaternion]

    def moved(self) -> None:
        """Move all that was put elsewhere."""
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)
        mujoco.mj_camlight(self.model, self.data)
        if self._window is not None:
            self._window.sync()

    def corners(self, body: str) -> Array:
        """The corners (c, 3) [m] of boxes along the axes of the world about all that is drawn of a body and of those
        that hang from it."""
        model, found = self.model, []
        first = model.body(body).id
        inside = {first}
        for other in range(first + 1, model.nbody):  # those that hang from one have higher numbers
            if int(model.body_parentid[other]) in inside:
                inside.add(other)
        for geom in np.flatnonzero(np.isin(model.geom_bodyid, list(inside))).tolist():
            centre, half = np.split(model.geom_aabb[geom], 2)
            frame = self.data.geom_xmat[geom].reshape(3, 3)
            points = self.data.geom_xpos[geom] + box_corners(centre - half, centre + half) @ frame.T
            found.append(box_corners(points.min(axis=0), points.max(axis=0)))
        return np.concatenate(found)

    def picture(self, camera: Camera, oversampling: int = OVERSAMPLING) -> Picture:
        """What a camera sees now."""
        return self._painter.picture(camera, oversampling)

    @property
    def is_open(self) -> bool:
        """Whether the world, or its window, is still there."""
        return self._is_open and (self._window is None or bool(self._window.is_running()))

    def close(self) -> None:
        """Give the window back."""
        if self._window is not None:
            self._window.close()
        self._is_open = False

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.close()


class _Shown:
    """A robot in a studio. Its joints (n,) [m or rad] are in the order of commands."""

    def __init__(self, studio: Studio, robot: Robot) -> None:
        self._studio, self._robot = studio, robot
        model = studio.model
        names = [model.joint(joint).name for joint in range(model.njnt)]
        moved = [name for name in names if name != OBJECT]
        self._places = model.jnt_qposadr[[names.index(name) for name in moved]]
        self._coupling = coupling_of(robot, moved)
        self._tips = [robot.hand.contacts[contact] for contact in robot.contacts]

    def place(self, joints: Array) -> None:
        """Put the joints there; ``moved`` moves the links."""
        self._studio.data.qpos[self._places] = self._coupling @ joints

    def frame(self, link: str) -> tuple[Array, Array]:
        """Where a link's frame is (3,) [m] and its rotation (3, 3)."""
        body = self._studio.data.body(link)
        return body.xpos.copy(), body.xmat.reshape(3, 3).copy()

    def tips(self) -> Array:
        """The middles (k, 3) [m] of the fingertips."""
        frames = [(self.frame(tip.link), np.array(tip.shape.centre)) for tip in self._tips]
        return np.array([origin + rotation @ centre for (origin, rotation), centre in frames])


class GraspStudio(Studio):
    """The hand and the object of a world of rigid bodies, the robot's root standing as at the start of a trial."""

    def __init__(self, view: View) -> None:
        assert view.start is not None
        settings = view.settings
        self._grasp, self._centre = list(view.grasp), settings.body.shape.solid.centre
        spec = _standing(settings.robot, view.start)
        put_table(spec, 0.0 if stands_free(settings.anchor) else -OUT_OF_THE_WAY)
        put_object(spec, shaded(settings.body.shape))
        super().__init__(spec, window=view.window)
        self.robot = _Shown(self, settings.robot)
        self._face = settings.robot.mount.face

    def show(self, at: Mapping[str, Array]) -> None:
        """Put the joints (n,) [m or rad], and the object's centre of mass (3,) [m] and rotation (3, 3)."""
        self.robot.place(at["joints"])
        rotation = at["object_rotation"]
        self.put(at["object_position"] - rotation @ self._centre, quaternion_of(rotation))
        self.moved()

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows the grasp as it stands."""
        tips, (origin, rotation) = self.robot.tips(), self.robot.frame(self._face)
        direction = grasp_direction(tips[self._grasp], rotation[:, 2])
        return camera_on(np.concatenate([tips, [origin], self.corners(OBJECT)]), direction, width, height)


class SurfaceStudio(Studio):
    """The surface of an object about the origin and contacts that float on it, drawn as small balls."""

    def __init__(self, view: View) -> None:
        self._contacts, surface = list(view.contacts), view.settings.body.shape.surface()
        mesh, spec = surface.mesh(FACETS), mujoco.MjSpec()
        put_object(spec, [Shaded(mesh.vertices, surface.normals(mesh.vertices), mesh.faces)])
        put_contacts(spec, len(self._contacts))
        super().__init__(spec, window=view.window)

    def show(self, at: Mapping[str, Array]) -> None:
        """Put the contacts at their points [m]."""
        self.data.mocap_pos[:] = at["points"][self._contacts]
        self.moved()

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows all of the surface."""
        return camera_on(1.25 * self.corners(OBJECT), ASIDE, width, height)


class ObjectStudio(Studio):
    """An object alone, standing on the table as it comes to rest there. Raises UnstableObjectError."""

    def __init__(self, body: Body, table_friction: float, gravity: float, *, window: bool = False) -> None:
        pose = resting_pose(MujocoEngine(EFFORT), body, table_friction, gravity)
        spec = mujoco.MjSpec()
        put_table(spec, 0.0)
        put_object(spec, shaded(body.shape))
        super().__init__(spec, window=window)
        self.put(*map(np.array, pose))
        self.moved()

    def camera(self, width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows all of the object."""
        return camera_on(self.corners(OBJECT), ASIDE, width, height)


class HandStudio(Studio):
    """A robot alone, nothing about it."""

    def __init__(self, robot: Robot, *, window: bool = False) -> None:
        super().__init__(_standing(robot, Start(np.zeros(3), np.eye(3), {})), window=window)
        self.robot = _Shown(self, robot)
        self._root = robot.hand.root

    def show(self, joints: Array) -> None:
        """Put the joints (n,) [m or rad]."""
        self.robot.place(joints)
        self.moved()

    def camera(self, postures: Sequence[Array], width: int = WIDTH, height: int = HEIGHT) -> Camera:
        """A camera that shows the hand in each of these postures (n,)."""
        corners = []
        for posture in postures:
            self.show(posture)
            corners.append(self.corners(self._root))
        return camera_on(np.concatenate(corners), ASIDE, width, height)


def _window(model: mujoco.MjModel, data: mujoco.MjData) -> Any:
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        try:
            import glfw

            if not glfw.init():  # of which the viewer would end the process
                raise NoWindowError(" ".join(str(warning.message) for warning in told))
            from mujoco.viewer import launch_passive

            return launch_passive(model, data, show_left_ui=False, show_right_ui=False)
        except (ImportError, RuntimeError) as error:
            raise NoWindowError(str(error)) from None


def _standing(robot: Robot, start: Start) -> mujoco.MjSpec:
    """A robot with its root as at a start."""
    spec = robot_looks(robot)
    position, quaternion = root_pose(robot, start)
    spec.bodies[1].pos, spec.bodies[1].quat = position, np.roll(quaternion, 1)
    return spec
