"""A hand on its mount inside MuJoCo: joints, couplings, fingertips, load cells, contact Jacobians."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import Robot, coupling_of
from graspdsl.worlds.mujoco.model import ACTING, LIFT, SOFT_IMPEDANCE, TIP, TipBody
from graspdsl.worlds.mujoco.state import State
from graspdsl.worlds.protocol import Palm
from graspdsl.worlds.touch.compliance import DAMPING, stiffness_under
from graspdsl.worlds.touch.fingertip_sensor import Fingertip

NO_SPRING = 1e-6  # zero would be the engine's own choice


class MujocoHand:
    """The robot of a model in a state of it. A link's number is that of its body in the model."""

    def __init__(self, state: State, robot: Robot, tips: Sequence[TipBody]) -> None:
        self._state, self._model, self._data, self.robot = state, state.model, state.data, robot
        model = state.model
        self._root = int(model.body_rootid[model.body(robot.hand.root).id])
        self.root_name: str = model.body(self._root).name
        self.parents: list[int] = model.body_parentid.tolist()
        names = [model.joint(joint).name for joint in range(model.njnt)]
        driven = [model.joint(model.actuator_trnid[motor, 0]).id for motor in range(model.nu)]
        self.movable: list[int] = model.jnt_bodyid[driven].tolist()
        sliding = {model.jnt_bodyid[j] for j in driven if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_SLIDE}
        self.slides = [body in sliding for body in range(model.nbody)]
        self._places, self._motions = model.jnt_qposadr[driven], model.jnt_dofadr[driven]
        self.coupling = coupling_of(robot, [names[joint] for joint in driven])
        order = {names[joint]: row for row, joint in enumerate(driven)}
        self._actuated = self._places[[order[name] for name in robot.joints]]
        self._face, self._palm = model.body(robot.mount.face).id, model.body(robot.hand.palm).id
        self._tip_bodies: list[int] = [model.body(tip.body).id for tip in tips]
        self.tip_geoms: list[int] = [int(model.body_geomadr[body]) for body in self._tip_bodies]
        self._cells = np.array(
            [
                [
                    *model.sensor(f"{tip.cell}-force").adr + np.arange(3),
                    *model.sensor(f"{tip.cell}-moment").adr + np.arange(3),
                ]
                for tip in tips
            ]
        )
        sensors = [model.sensor(number) for number in range(model.nsensor)]
        self.acting = np.array([sensor.adr + np.arange(9) for sensor in sensors if sensor.name.startswith(ACTING)])
        self._tip_of_pair = np.array([self.tip_geoms.index(geom) for geom in model.pair_geom1.tolist()])
        self._scales = _scales(model)
        model.pair_solref[:, 1] = -self._scales * DAMPING
        model.pair_solreffriction[:, 0] = -NO_SPRING
        model.pair_solreffriction[:, 1] = -self._scales * LIFT
        self._stiffnesses = list[float]()
        self.press([0.0] * len(tips))
        self.tips = tuple(self._tip(*each) for each in zip(robot.contacts, self._tip_bodies, strict=True))
        spans = zip(model.body_geomadr.tolist(), model.body_geomnum.tolist(), strict=True)
        self._geoms_of = [range(first, first + count) for first, count in spans]
        robots = [body for body in range(1, model.nbody) if model.body_rootid[body] == self._root]
        self.geoms: list[int] = np.flatnonzero(np.isin(model.geom_bodyid, robots)).tolist()
        self.is_mine = np.isin(np.arange(model.ngeom), self.geoms)
        self.tip_of = np.full(model.ngeom, -1)
        self.tip_of[self.tip_geoms] = range(len(self.tip_geoms))
        self.link_of = {geom: model.body(model.geom_bodyid[geom]).name.removeprefix(TIP) for geom in self.geoms}

    def _tip(self, contact: str, body: int) -> Fingertip:
        shape = self.robot.hand.contacts[contact].shape
        centre = np.array(shape.centre)
        return Fingertip(shape, centre, float(self._model.body_mass[body]), self._model.body_ipos[body] - centre)

    def geoms_of(self, link: int) -> Sequence[int]:
        """The geoms of a link."""
        return self._geoms_of[link]

    @property
    def tip_links(self) -> tuple[int, ...]:
        """The bodies of the fingertips."""
        return tuple(self._tip_bodies)

    def move_root(self, position: Array, quaternion: Array) -> None:
        """Put the root's frame at a position (3,) [m] and quaternion (4,), x first, the joints as they are."""
        self._model.body_pos[self._root] = position
        self._model.body_quat[self._root] = np.roll(quaternion, 1)
        self._state.moved()

    def place(self, joints: Array) -> None:
        """Put the joints (n,) where they are told, at rest, without simulating."""
        self._data.qpos[self._places] = self.coupling @ joints
        self._data.qvel[self._motions] = 0.0
        self._state.moved()

    def controls(self, targets: Array) -> Array:
        """What the motors are told to drive the joints to targets (s, n), (s, m) of them."""
        return np.asarray(targets @ self.coupling.T)

    def press(self, presses: Sequence[float]) -> None:
        """Give the fingertips the stiffness that belongs to the normal forces [N] they press with."""
        stiffnesses = [stiffness_under(press) for press in presses]
        if stiffnesses != self._stiffnesses:
            self._stiffnesses = stiffnesses
            self._model.pair_solref[:, 0] = -self._scales * np.array(stiffnesses)[self._tip_of_pair]

    def joints(self) -> Array:
        """The (n,) actuated positions."""
        return np.asarray(self._data.qpos[self._actuated])

    def tip_frames(self) -> tuple[Array, Array]:
        """Origins (k, 3) and rotations (k, 3, 3) of the fingertips' frames."""
        data = self._state.placed
        return data.xpos[self._tip_bodies], data.xmat[self._tip_bodies].reshape(-1, 3, 3)

    def cell_readings(self) -> Array:
        """The (k, 6) wrenches on the load cells, force then moment about the tips' centres of mass, in their frames."""
        return np.asarray(self._data.sensordata[self._cells])

    def face_frame(self) -> tuple[Array, Array]:
        """Origin (3,) and rotation (3, 3) of the mounting face."""
        return self._state.placed.xpos[self._face].copy(), self._state.placed.xmat[self._face].reshape(3, 3).copy()

    def note_jacobians(self, points: Array, linear: Array, angular: Array) -> None:
        """Write down how all motions of the model move points (k, 3) of the fingertips, and turn these, (k, 3, v)."""
        data = self._state.placed
        for body, *of_tip in zip(self._tip_bodies, points, linear, angular, strict=True):
            mujoco.mj_jac(self._model, data, of_tip[1], of_tip[2], of_tip[0], body)

    def by_joints(self, jacobians: Array) -> Array:
        """Jacobians (..., v) by all motions of the model as such by the joints, (..., n)."""
        return np.asarray(jacobians[..., self._motions] @ self.coupling)

    def links_beyond(self, joints: Sequence[str]) -> set[int]:
        """The links that these joints move."""
        moved = {int(self._model.joint(name).bodyid[0]) for name in joints}
        for body, parent in enumerate(self.parents):
            if body and parent in moved:
                moved.add(body)
        return moved

    def link_origins(self) -> list[Array]:
        """Where the frame of each link is (3,) [m]."""
        return list(self._state.placed.xpos.copy())

    def link_sizes(self, links: Sequence[int]) -> list[float]:
        """How far [m] links reach from the origins of their frames, at the most."""
        places, radii = np.linalg.norm(self._model.geom_pos, axis=1), self._model.geom_rbound
        return [max((float(places[geom] + radii[geom]) for geom in self.geoms_of(link)), default=0.0) for link in links]

    def palm(self) -> Palm:
        """The palm at the origin of its link."""
        data, found = self._state.placed, np.zeros((2, 3, self._model.nv))
        place, frame = data.xpos[self._palm].copy(), data.xmat[self._palm].reshape(3, 3).copy()
        mujoco.mj_jac(self._model, data, found[0], found[1], place, self._palm)
        return Palm(place, frame, np.concatenate(self.by_joints(found)))


def _scales(model: mujoco.MjModel) -> Array:
    """What N/m and N·s/m of each pair are to be multiplied by, (p,) [1/kg]: the engine has them per unit of mass, that
    is of the sum of the inverse masses that it has noted of the two bodies."""
    inverse = model.body_invweight0[model.geom_bodyid[np.stack([model.pair_geom1, model.pair_geom2])], 0]
    return np.asarray((1.0 - SOFT_IMPEDANCE) * inverse.sum(axis=0))
