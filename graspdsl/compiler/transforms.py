"""Lowering of transforms: sensors, effectors and what they read, as pipeline steps."""

from __future__ import annotations

from functools import partial

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import spherical_frames, spherical_stretch, tangent_frames
from graspdsl.basis.effector import Effector
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler import operations
from graspdsl.compiler.citing import cited
from graspdsl.compiler.pipeline import PipelineBuilder
from graspdsl.compiler.settings import Target

READINGS = {
    "points": "contact points [m]",
    "normals": "inward unit normals",
    "forces": "contact forces [N]",
    "touching": "which contacts touch",
    "joints": "joint positions [m or rad]",
    "orientations": "fingertip orientations [rad]",
    "centre_of_mass": "the object's centre of mass [m]",
    "weight": "the object's weight [N]",
}
DOWN = np.array([0.0, 0.0, -1.0])


class Transforms:
    """Makes the steps of sensor and effector transforms over resource sets.

    Joints are worked with in scaled coordinates, each divided by its weight, so that metres and radians weigh alike in
    transposes, inverses and projectors.
    """

    def __init__(self, build: PipelineBuilder, grasp: ContactSet, target: Target) -> None:
        self._build, self._grasp, self._target, self._control = build, grasp, target, target.control

    def mixing(self, resources: ContactSet) -> Array:
        """The rows (m, k) of per-contact tasks: one a member of a virtual contact, or one a resource (their mean)."""
        if self._control.virtual == "common":
            return resources.matrix
        chosen = [contact for member in resources.members for contact, _ in member.weights]
        rows: Array = np.eye(resources.matrix.shape[1])[chosen]
        return rows

    def sensor(self, sensor: Sensor, resources: ContactSet | JointSet, mixing: Array | None = None) -> int:
        """σ(Γ); ``mixing`` overrules the rows that the control settings ask for."""
        if mixing is None:
            mixing = self._rows(sensor, resources)
        with_gravity = isinstance(resources, ContactSet) and resources.has_gravity
        return self._build.apply(
            f"{sensor.symbol}({resources.label})",
            f"{sensor.about}, {cited(sensor.equation)}",
            partial(sensor.evaluate, mixing),
            *[self._read_with_gravity(name) if with_gravity else self.read(name) for name in sensor.reads],
        )

    def _rows(self, sensor: Sensor, resources: ContactSet | JointSet) -> Array:
        if isinstance(resources, JointSet):
            return resources.matrix
        return self.mixing(resources) if sensor.per_contact else resources.weights

    def _read_with_gravity(self, name: str) -> int:
        """A reading over the contacts and, last, gravity (Eq. 4.35 to 4.37)."""
        match name:
            case "points":
                last, about = self.read("centre_of_mass"), "contact points and the centre of mass, Eq. 4.35"
            case "forces":
                last, about = self.read("weight"), "contact forces and the weight, Eq. 4.36"
            case "normals":
                last, about = self._build.constant("γ_g", "down", DOWN), "normals and down, Eq. 4.37"
            case _:
                return self.read(name)
        return self._build.apply(f"{name}, γ_g", about, operations.with_last_row, self.read(name), last)

    def effector(self, effector: Effector, resources: ContactSet | JointSet, sensed: ContactSet | JointSet) -> int:
        """τ(Γτ) of a controller that senses ``sensed``, in joint space with a row for each of its rows."""
        space = effector.gradient_space
        label, with_gravity = f"{effector.symbol}({resources.label})", False
        if isinstance(resources, JointSet):
            assert isinstance(sensed, JointSet)
            mixing = sensed.matrix * resources.mask
        elif space is GradientSpace.ROTATION:
            assert isinstance(sensed, ContactSet)
            mixing, with_gravity = sensed.turning, sensed.has_gravity
        else:
            assert isinstance(sensed, ContactSet)
            mixing = self.mixing(sensed) if space is GradientSpace.JOINTS else resources.weights
        step = self._build.apply(
            label,
            f"{effector.about}, {cited(effector.equation)}",
            partial(effector.evaluate, mixing),
            *[self._read_with_gravity(name) if with_gravity else self.read(name) for name in effector.reads],
        )
        if self._target.held and "angular_jacobian" in effector.reads:
            turning = partial(np.multiply, np.array(self._target.turning_joints, dtype=float))
            return self._build.apply(label, "the fingers hold still", turning, step)
        shared = self._control.virtual == "common" and isinstance(resources, ContactSet) and resources.has_virtual
        if space in (GradientSpace.ROTATION, GradientSpace.JOINTS) or not shared:
            return step
        assert isinstance(resources, ContactSet)
        together = (resources.matrix > 0.0).astype(float)
        about, sharing = "members of a virtual contact move as one, Eq. 4.34", together.T @ together
        if space is GradientSpace.SURFACE and self._control.surface == "tangent":
            share = partial(operations.shared_along_frames, sharing)
            return self._build.apply(label, about, share, step, self.read("frames"))
        return self._build.apply(label, about, partial(operations.shared, sharing), step)

    def read(self, name: str) -> int:
        """A field of the observation, or a quantity made of one."""
        build = self._build
        match name:
            case "jacobian" | "angular_jacobian":
                turning = "angular " if name == "angular_jacobian" else ""
                raw = build.read(name, f"{turning}Jacobians of the contacts")
                scale = partial(np.multiply, np.array(self._target.robot.weights))
                return build.apply("J", f"{turning}Jacobians in scaled joint coordinates", scale, raw)
            case "joint_weights":
                return build.constant("D", "joint weights", np.array(self._target.robot.weights))
            case "curvature_radius":
                radius = np.array(self._control.curvature_radius)
                return build.constant("r", f"radius of the model sphere, {radius:g} m", radius)
            case "frames":
                frames = spherical_frames if self._control.surface == "spherical" else tangent_frames
                return build.apply("(r̂_θ r̂_φ)", "frames of the tangent planes", frames, self.read("normals"))
            case "stretch" if self._control.surface == "spherical":
                return build.apply("(cosφ, 1)", "stretch of the coordinates", spherical_stretch, self.read("normals"))
            case "stretch":
                return build.constant("(1, 1)", "stretch of the coordinates: none", np.ones((self._grasp.count, 2)))
            case "origin":
                return self._origin()
        return build.read(name, READINGS[name])

    def _origin(self) -> int:
        build, grasp = self._build, self._grasp
        match self._control.origin:
            case "world":
                return build.constant("c", "origin of moments: the world's", np.zeros(3))
            case "object":
                return build.apply("c", "origin of moments: the object's", operations.same, self.read("centre_of_mass"))
        mean = partial(np.matmul, grasp.weights / grasp.weights.sum())
        points = self._read_with_gravity("points") if grasp.has_gravity else self.read("points")
        return build.apply("c", "origin of moments: centroid of the contacts", mean, points)

    def fingers(self, resources: ContactSet) -> Array:
        """(k, n): ones at the joints of each contact's own finger; zero rows for contacts outside the set."""
        robot = self._target.robot
        return np.array(
            [
                [float(index in resources.contacts and joint in contact.finger) for joint in robot.joints]
                for index, contact in enumerate(robot.hand.contacts.values())
            ]
        )
