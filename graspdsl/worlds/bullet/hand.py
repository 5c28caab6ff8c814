"""A hand on its mount inside Bullet: joints, couplings, fingertips, load cells, contact Jacobians."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, coupling_of
from graspdsl.models.model import UNSTATED_EFFORT
from graspdsl.worlds.bullet.assembly import assembled_urdf
from graspdsl.worlds.bullet.engine import silenced
from graspdsl.worlds.camera import box_corners
from graspdsl.worlds.protocol import Palm
from graspdsl.worlds.rigid.assembly import joined
from graspdsl.worlds.rigid.neighbours import neighbours
from graspdsl.worlds.touch.compliance import DAMPING, stiffness_under
from graspdsl.worlds.touch.fingertip_sensor import Fingertip


def rotation_matrix(quaternion: tuple[float, ...]) -> Array:
    """The (3, 3) rotation of a quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


@dataclass(frozen=True, slots=True)
class Tip(Fingertip):
    """A fingertip with its numbers in the engine: those of its link and of its load cell's joint, and the rotation
    (3, 3) of its axes of inertia in the link's frame."""

    link: int
    cell: int | None
    inertial_rotation: Array


class BulletHand:
    """A hand on its mount, loaded with its root at a given pose and all joints at zero.

    Joint vectors of length n are in command order (mount first); the engine's own, longer vectors also hold the
    coupled joints: full = coupling @ actuated. The engine is given no looks.
    """

    def __init__(
        self,
        engine: Any,
        client: int,
        robot: Robot,
        position: Array,
        quaternion: Array,
        friction: float,
    ) -> None:
        self._engine, self._client, self.robot = engine, client, robot
        flags = engine.URDF_USE_INERTIA_FROM_FILE | engine.URDF_USE_SELF_COLLISION | engine.URDF_IGNORE_VISUAL_SHAPES
        with tempfile.TemporaryDirectory(prefix="graspdsl-") as folder:
            path = Path(folder, "robot.urdf")
            path.write_text(assembled_urdf(robot, Path(folder)), encoding="utf-8")
            with silenced():
                self.body: int = engine.loadURDF(
                    str(path),
                    position.tolist(),
                    quaternion.tolist(),
                    useFixedBase=True,
                    flags=flags,
                    physicsClientId=client,
                )
        self._read_joints()
        self._face = self.link_index[robot.mount.face]
        self._part_neighbours()
        self.tips = tuple(self._tip(name) for name in robot.contacts)
        self._base_rotation = rotation_matrix(tuple(quaternion))
        for tip in self.tips:
            engine.changeDynamics(
                self.body,
                tip.link,
                lateralFriction=friction,
                physicsClientId=client,
            )
            if tip.cell is not None:
                engine.enableJointForceTorqueSensor(self.body, tip.cell, True, physicsClientId=client)
        self._stiffnesses = [0.0] * len(self.tips)
        self.press([0.0] * len(self.tips))

    def press(self, presses: Sequence[float]) -> None:
        """Give the fingertips the stiffness that belongs to the normal forces [N] they press with."""
        for row, (tip, press) in enumerate(zip(self.tips, presses, strict=True)):
            stiffness = stiffness_under(press)
            if stiffness != self._stiffnesses[row]:
                self._stiffnesses[row] = stiffness
                self._engine.changeDynamics(
                    self.body,
                    tip.link,
                    contactStiffness=stiffness,
                    contactDamping=DAMPING,
                    physicsClientId=self._client,
                )

    def _read_joints(self) -> None:
        engine, client = self._engine, self._client
        infos = [engine.getJointInfo(self.body, j, client) for j in range(engine.getNumJoints(self.body, client))]
        self.joint_index = {info[1].decode(): info[0] for info in infos}
        self.link_index = {info[12].decode(): info[0] for info in infos}
        self.link_names = {index: name for name, index in self.link_index.items()}
        self.parents = [info[16] for info in infos]
        self.slides = [info[2] == engine.JOINT_PRISMATIC for info in infos]
        self.movable = [info[0] for info in infos if info[2] != engine.JOINT_FIXED]
        self.movable_names = [infos[j][1].decode() for j in self.movable]
        self.coupling = coupling_of(self.robot, self.movable_names)
        self._actuated_rows = np.array([self.movable_names.index(name) for name in self.robot.joints])
        self.efforts = [infos[j][10] or UNSTATED_EFFORT for j in self.movable]

    def _part_neighbours(self) -> None:
        """Let neither neighbours touch each other, nor what overlaps as the joints stand at zero.

        Parts of a closed loop do that wherever they are.
        """
        for link, other in neighbours(joined(self.robot), self.robot):
            self._part(self.link_index.get(link, -1), self.link_index.get(other, -1))
        self._engine.performCollisionDetection(self._client)
        for contact in self._engine.getContactPoints(self.body, self.body, physicsClientId=self._client):
            if contact[8] < 0.0:
                self._part(contact[3], contact[4])

    def _part(self, link: int, other: int) -> None:
        self._engine.setCollisionFilterPair(self.body, self.body, link, other, 0, self._client)

    def _tip(self, contact: str) -> Tip:
        description = self.robot.hand.contacts[contact]
        link = self.link_index[description.link]
        dynamics = self._engine.getDynamicsInfo(self.body, link, self._client)
        centre = np.array(description.shape.centre)
        return Tip(
            link=link,
            cell=self.joint_index[description.cell] if description.cell else None,
            shape=description.shape,
            centre=centre,
            mass=dynamics[0],
            weight_lever=np.array(dynamics[3]) - centre,
            inertial_rotation=rotation_matrix(dynamics[4]),
        )

    def move_root(self, position: Array, quaternion: Array) -> None:
        """Put the root's frame at a position (3,) [m] and quaternion (4,), the joints as they are."""
        inertial = self._engine.getDynamicsInfo(self.body, -1, self._client)[3:5]
        centre = self._engine.multiplyTransforms(position.tolist(), quaternion.tolist(), *inertial)
        self._engine.resetBasePositionAndOrientation(self.body, *centre, self._client)
        self._base_rotation = rotation_matrix(tuple(quaternion))

    def place(self, joints: Array) -> None:
        """Put the joints (n,) where they are told, at rest, without simulating."""
        positions = (self.coupling @ joints)[:, None].tolist()
        self._engine.resetJointStatesMultiDof(self.body, self.movable, positions, physicsClientId=self._client)

    def drive(self, joints: Array) -> None:
        """Set the position targets (n,) of the joint motors, the coupled joints with them."""
        self._engine.setJointMotorControlArray(
            self.body,
            self.movable,
            self._engine.POSITION_CONTROL,
            targetPositions=(self.coupling @ joints).tolist(),
            forces=self.efforts,
            physicsClientId=self._client,
        )

    def all_joints(self) -> list[float]:
        """Positions of all movable joints, the coupled ones too, in the engine's order."""
        states = self._engine.getJointStates(self.body, self.movable, self._client)
        return [state[0] for state in states]

    def actuated(self, all_joints: list[float]) -> Array:
        """The (n,) actuated positions out of all movable ones."""
        actuated: Array = np.array(all_joints)[self._actuated_rows]
        return actuated

    def joints(self) -> Array:
        """The (n,) actuated positions."""
        return self.actuated(self.all_joints())

    @property
    def tip_links(self) -> tuple[int, ...]:
        """The links of the fingertips."""
        return tuple(tip.link for tip in self.tips)

    def tip_frames(self) -> list[tuple[Array, Array]]:
        """Origin (3,) and rotation (3, 3) of each fingertip link's frame, in the world."""
        links = [tip.link for tip in self.tips]
        states = self._engine.getLinkStates(
            self.body, links, computeForwardKinematics=True, physicsClientId=self._client
        )
        return [(np.array(state[4]), rotation_matrix(state[5])) for state in states]

    def cell_readings(self) -> Array:
        """The (k, 6) raw wrenches on the load cells' joints, force then moment, in the tips' frames."""
        cells = [tip.cell for tip in self.tips]
        states = self._engine.getJointStates(self.body, cells, self._client)
        # The engine tells them in the tips' axes of inertia.
        readings = np.array([state[2] for state in states]).reshape(-1, 2, 3)
        turned = [pair @ tip.inertial_rotation.T for tip, pair in zip(self.tips, readings, strict=True)]
        return np.array(turned).reshape(-1, 6)

    def face_frame(self) -> tuple[Array, Array]:
        """Origin (3,) and rotation (3, 3) of the mounting face, in the world."""
        state = self._engine.getLinkState(
            self.body, self._face, computeForwardKinematics=True, physicsClientId=self._client
        )
        return np.array(state[4]), rotation_matrix(state[5])

    def tip_jacobians(self, places: Sequence[Array]) -> tuple[Array, Array]:
        """Linear and angular Jacobians (k, 3, n) of a point (3,) fixed in the frame of each fingertip's link."""
        now = self.all_joints()
        pairs = [self.jacobians(tip, place, now) for tip, place in zip(self.tips, places, strict=True)]
        return np.array([linear for linear, _ in pairs]), np.array([angular for _, angular in pairs])

    def jacobians(self, tip: Tip, point: Array, all_joints: list[float]) -> tuple[Array, Array]:
        """The linear and angular (3, n) world-frame Jacobians of a material point (3,), given in the tip's frame."""
        return self._jacobians(tip.link, tip.inertial_rotation.T @ point, all_joints)

    def _jacobians(self, link: int, local: Array, all_joints: list[float]) -> tuple[Array, Array]:
        """Those of a point from a link's origin in its axes of inertia; the engine answers in the frame of the base."""
        zeros = [0.0] * len(all_joints)
        both = self._engine.calculateJacobian(self.body, link, local.tolist(), all_joints, zeros, zeros, self._client)
        linear, angular = (self._base_rotation @ np.array(part) @ self.coupling for part in both)
        return linear, angular

    def links_beyond(self, joints: Sequence[str]) -> set[int]:
        """The links that these joints move."""
        moved = {self.joint_index[name] for name in joints}
        for index, parent in enumerate(self.parents):
            if parent in moved:
                moved.add(index)
        return moved

    def still_links(self) -> set[int]:
        """The links that no joint moves, that of the root (-1) among them."""
        return {-1, *range(len(self.parents))} - self.links_beyond(self.movable_names)

    def link_origins(self) -> list[Array]:
        """Where the frame of each link is (3,) [m]."""
        every = list(range(len(self.parents)))
        states = self._engine.getLinkStates(
            self.body, every, computeForwardKinematics=True, physicsClientId=self._client
        )
        return [np.array(state[4]) for state in states]

    def link_sizes(self, links: Sequence[int]) -> list[float]:
        """How far [m] links reach from the origins of their frames, at the most: those of the boxes they are in."""
        origins, sizes = self.link_origins(), list[float]()
        for link in links:
            low, high = self._engine.getAABB(self.body, link, self._client)
            away = np.linalg.norm(box_corners(np.array(low), np.array(high)) - origins[link], axis=1)
            sizes.append(float(away.max()))
        return sizes

    def palm(self) -> Palm:
        """The palm at the origin of its link."""
        link = self.link_index[self.robot.hand.palm]
        state = self._engine.getLinkState(self.body, link, computeForwardKinematics=True, physicsClientId=self._client)
        jacobian = np.vstack(self._jacobians(link, np.zeros(3), self.all_joints()))
        return Palm(np.array(state[4]), rotation_matrix(state[5]), jacobian)
