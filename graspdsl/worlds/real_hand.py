"""A hand of one's own: what its driver reads becomes an observation, by the robot's description and the touch code of
all worlds. There is no engine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.basis.rotations import logarithm
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.hands.descriptions import Robot
from graspdsl.hands.fingertip_motion import FingertipMotion, LinkMotion
from graspdsl.models.urdf_elements import mass_of, pose_of
from graspdsl.spec.scene import GRAVITY
from graspdsl.spec.sensing import SampledSensor, TactileSensor
from graspdsl.worlds.protocol import Observation, Start
from graspdsl.worlds.start_pose import root_pose
from graspdsl.worlds.touch.fingertip_sensor import Clock, Fingertip, TipFrames
from graspdsl.worlds.touch.fingertips import Fingertips, read
from graspdsl.worlds.touch.sensors import sensor_for

RESOLUTION = 1000.0  # Hz, of the clock that readings are filtered by
ROUNDED = 1e-3  # by which the products of a rotation's columns may be beside those of axes


def _unknown() -> Array:
    return np.full(3, np.nan)


@dataclass(frozen=True, slots=True)
class Reading:
    """What a driver reads at one ``time`` [s] of its own clock.

    joints: (n,) positions [m or rad] in the order of ``robot.joints``, the mount's first. wrenches: (k, 6), the load on
    each cell in the order of ``robot.contacts``, force [N] then moment [N·m]: what object and weight put on the
    fingertip, in the frame of its link and about the origin of that. centre_of_mass (3,) [m] and weight (3,) [N] of an
    object that the hand holds, in the world.
    """

    time: float
    joints: Array
    wrenches: Array
    centre_of_mass: Array = field(default_factory=_unknown)
    weight: Array = field(default_factory=_unknown)


class RealHand:
    """Makes observations of the readings of a hand of one's own; it has the memory that touch needs.

    The load cells are read as those of a simulated hand: tared, rid of the weight of the tips, filtered and taken for
    touching as the spec's ``sensing`` has it. Its noise, biases, drifts, quanta, rate and latency are those of a
    simulation: the real cells have their own.
    """

    def __init__(
        self,
        robot: Robot,
        sensing: TactileSensor,
        position: Array | None = None,
        rotation: Array | None = None,
        gravity: float = GRAVITY,
    ) -> None:
        """position (3,) [m] and rotation (3, 3): the pose in the world of the mounting face when all joints of a mount
        without a base are zero; an arm stands on its base, and neither is read. Gravity [m/s²] is along −z.

        Raises DiagnosticError where contacts are sensed by other than load cells, and ValueError for a mount without a
        base where there is no pose, or what is given is none.
        """
        if not (sensor_for(sensing).needs_cells and isinstance(sensing, SampledSensor)):
            message = f"a real hand is read by its load cells; the spec senses by {sensor_for(sensing).called}"
            raise DiagnosticError([Diagnostic("no-load-cells", message, hint="sensing: load-cell, under scene")])
        self.robot, self._time = robot, -np.inf
        self._needs_zero = sensor_for(sensing).tares
        start = Start(np.zeros(3), np.eye(3), {}) if robot.mount.base else _start(robot, position, rotation)
        self._felt = _Felt(robot, *root_pose(robot, start))
        perfect = {**dict.fromkeys(sensing.flaws, 0.0), "rate": None, "latency": 0.0, "filter": sensing.time_constant}
        clock = Clock(RESOLUTION, RESOLUTION)
        self._tips = Fingertips(self._felt, robot, sensing.model_copy(update=perfect), gravity, clock, seed=0)

    def tare(self, readings: Sequence[Reading]) -> None:
        """Take the mean of these as the zero of the cells: the hand rests, and nothing touches the fingertips.

        Raises ValueError as ``observe`` does, and where there is no reading.
        """
        if not readings:
            raise ValueError("there is no zero to take without a reading at rest")
        for reading in readings:
            self._take(reading)
            self._tips.note_rest()
        self._tips.tare()
        self._needs_zero = False

    def observe(self, reading: Reading) -> Observation:
        """What is sensed by the reading.

        Raises ValueError, and the reading is as good as lost, where it is not of the robot's joints and contacts, holds
        what is no number, or is not later than the one before; and before the cells have been tared.
        """
        if self._needs_zero:
            raise ValueError("the load cells have no zero yet: tare the hand on readings at rest before it observes")
        self._take(reading)
        felt = self._felt
        origins, rotations = (np.array(part)[None] for part in zip(*felt.frames(), strict=True))
        tips = read([self._tips], TipFrames(origins, rotations), lambda places: felt.jacobians(places[0])[:1])
        linear, angular = felt.jacobians(tips.local[0])
        return Observation(
            time=reading.time,
            points=tips.points[0],
            normals=tips.normals[0],
            forces=tips.forces[0],
            touching=tips.touching[0],
            joints=np.asarray(reading.joints, dtype=float),
            jacobian=linear,
            angular_jacobian=angular,
            orientations=logarithm(tips.rotations[0]),
            centre_of_mass=reading.centre_of_mass,
            weight=reading.weight,
        )

    def _take(self, reading: Reading) -> None:
        joints, wrenches = np.asarray(reading.joints, dtype=float), np.asarray(reading.wrenches, dtype=float)
        parts = {"joints": (joints, (len(self.robot.joints),)), "wrenches": (wrenches, (len(self.robot.contacts), 6))}
        for name, (values, shape) in parts.items():
            if values.shape != shape:
                raise ValueError(f"{name} of a reading must be {shape}, not {values.shape}")
            if not np.isfinite(values).all():
                raise ValueError(f"{name} of the reading hold what is no number")
        if not self._time < reading.time < np.inf:
            raise ValueError(f"a reading of {reading.time:g} s comes after one of {self._time:g} s")
        passed = reading.time - self._time
        self._felt.take(joints, wrenches)
        self._tips.advance(max(1, round(passed * RESOLUTION)) if np.isfinite(passed) else 1)
        self._time = reading.time


class _Felt:
    """The fingertips as the last reading has them; all that is known of the object is what the cells bear."""

    def __init__(self, robot: Robot, position: Array, quaternion: Array) -> None:
        self.tips = tuple(_tips(robot))
        self._motion = FingertipMotion(robot)
        from scipy.spatial.transform import Rotation  # which takes its time to import

        self._position, self._rotation = position, Rotation.from_quat(quaternion).as_matrix()
        self._links: list[LinkMotion] = []
        self._held_up = np.zeros((len(self.tips), 6))

    def take(self, joints: Array, loads: Array) -> None:
        """The joints (n,) and the loads (k, 6) on the cells."""
        self._links = self._motion.links(joints)
        # A cell's joint holds up against the load, about the tip's centre of mass.
        levers = np.array([tip.centre + tip.weight_lever for tip in self.tips])
        self._held_up = -np.hstack([loads[:, :3], loads[:, 3:] - cross(levers, loads[:, :3])])

    def frames(self) -> list[tuple[Array, Array]]:
        """The frames of the tips' links."""
        return [(self._position + self._rotation @ link.origin, self._rotation @ link.rotation) for link in self._links]

    def wrenches(self) -> Array:
        """What the cells' joints hold up, (k, 6)."""
        return self._held_up

    def jacobians(self, places: Array) -> Array:
        """The linear and angular Jacobians (2, k, 3, n), in the world, of a point (k, 3) of each tip."""
        pairs = [link.jacobians(place) for link, place in zip(self._links, places, strict=True)]
        return np.asarray(self._rotation @ np.array(pairs).swapaxes(0, 1))

    def contacts(self) -> tuple[Array, Array, Array]:
        """Not known."""
        unknown = np.full((3, len(self.tips), 3), np.nan)
        return unknown[0], unknown[1], unknown[2]

    def presses(self) -> list[tuple[Array, Array]]:
        """Not known."""
        return [(np.zeros((0, 3)), np.zeros(0)) for _ in self.tips]

    def nearest(self, within: float) -> list[tuple[float, Array] | None]:
        """Not known."""
        del within
        return [None] * len(self.tips)


def _start(robot: Robot, position: Array | None, rotation: Array | None) -> Start:
    """The pose of the mounting face that is given. Raises ValueError where it is none."""
    if position is None or rotation is None:
        raise ValueError(
            f"{robot.mount.mount} stands where you say: give position (3,) [m] and rotation (3, 3), the pose of its "
            "mounting face in the world when all its joints are zero"
        )
    place, axes = np.asarray(position, dtype=float), np.asarray(rotation, dtype=float)
    if place.shape != (3,) or not np.isfinite(place).all():
        raise ValueError(f"position must be three numbers [m], not {position}")
    if axes.shape != (3, 3) or not np.allclose(axes.T @ axes, np.eye(3), rtol=0.0, atol=ROUNDED):
        raise ValueError("rotation must be (3, 3), its columns unit vectors at right angles")
    if np.linalg.det(axes) < 0.0:
        raise ValueError("rotation is left-handed, a mirror image: its third column must be the first × the second")
    return Start(place, axes, {})


def _tips(robot: Robot) -> Iterable[Fingertip]:
    links = {link.get("name"): link for model in robot.models for link in ElementTree.fromstring(model).iter("link")}
    for contact in robot.hand.contacts.values():
        link, centre = links[contact.link], np.array(contact.shape.centre)
        inertial = link.find("inertial")
        place = np.zeros(3) if inertial is None else pose_of(inertial)[0]
        yield Fingertip(contact.shape, centre, mass_of(link), place - centre)
