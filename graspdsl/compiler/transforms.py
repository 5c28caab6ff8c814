"""Lowering of transforms: sensors, effectors and what they read, as pipeline steps."""

from __future__ import annotations

from functools import partial

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.effectors import Effector
from graspdsl.basis.resources import ContactSet
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler import operations
from graspdsl.compiler.pipeline import PipelineBuilder
from graspdsl.compiler.settings import Target

READINGS = {
    "points": "contact points [m]",
    "normals": "inward unit normals",
    "forces": "contact forces [N]",
    "touching": "which contacts touch",
}


class Transforms:
    """Makes the steps of sensor and effector transforms over resource sets.

    Joints are worked with in scaled coordinates, each divided by its weight, so that metres and radians weigh alike in
    transposes, inverses and projectors; likewise the contacts, each divided by its ``contact_scale``.
    """

    def __init__(self, build: PipelineBuilder, grasp: ContactSet, target: Target) -> None:
        self._build, self._grasp, self._target, self._control = build, grasp, target, target.control

    def mixing(self, resources: ContactSet) -> Array:
        """The rows (m, k) of per-contact tasks: one a member of a virtual contact, or one a resource (their mean)."""
        if self._control.virtual == "common":
            return resources.matrix
        rows: Array = np.eye(resources.count)[
            [contact for member in resources.members for contact, _ in member.weights]
        ]
        return rows

    def sensor(self, sensor: Sensor, resources: ContactSet, mixing: Array | None = None) -> int:
        """σ(Γ); ``mixing`` overrules the rows that the control settings ask for."""
        if mixing is None:
            mixing = self.mixing(resources) if sensor.per_contact else resources.weights
        return self._build.apply(
            f"{sensor.symbol}({resources.label})",
            f"{sensor.about}, Eq. {sensor.equation}",
            partial(sensor.evaluate, mixing),
            *[self.read(name) for name in sensor.reads],
        )

    def effector(self, effector: Effector, resources: ContactSet) -> int:
        """τ(Γ)."""
        space = effector.gradient_space
        joints = space is GradientSpace.JOINTS
        label = f"{effector.symbol}({resources.label})"
        step = self._build.apply(
            label,
            f"{effector.about}, Eq. {effector.equation}",
            partial(effector.evaluate, self.mixing(resources) if joints else resources.weights),
            *[self.read(name) for name in effector.reads],
        )
        if joints or not self._grasp.has_virtual:
            return step
        if self._control.virtual == "members":
            scale = partial(np.multiply, self.contact_scale(space))
            return self._build.apply(label, "in scaled contact coordinates", scale, step)
        together = (resources.matrix > 0.0).astype(float)
        share = partial(operations.shared, together.T @ together)
        return self._build.apply(label, "members of a virtual contact move as one, Eq. 4.34", share, step)

    def contact_scale(self, space: GradientSpace) -> Array:
        """Factors on the coordinates of the contacts in ψ or x: 1/√w for a weight w, so that a member of a virtual
        contact moves as far as it would alone, and the virtual contact by the mean of that (Eq. 4.34)."""
        weights = self._grasp.weights
        scale = np.where(weights > 0.0, 1.0 / np.sqrt(np.where(weights > 0.0, weights, 1.0)), 1.0)
        if self._control.virtual == "common":
            scale = np.ones_like(scale)
        return np.repeat(scale, 2 if space is GradientSpace.SURFACE else 3)

    def read(self, name: str) -> int:
        """A field of the observation, or a quantity made of one: ``jacobian``, ``curvature_radius``, ``origin``."""
        match name:
            case "jacobian":
                raw = self._build.read("jacobian", "Jacobians of the contact points")
                scale = partial(np.multiply, np.array(self._target.robot.weights))
                return self._build.apply("J", "Jacobians in scaled joint coordinates", scale, raw)
            case "curvature_radius":
                radius = np.array(self._control.curvature_radius)
                return self._build.constant("r", "radius of the model sphere [m]", radius)
            case "origin" if self._control.origin == "world":
                return self._build.constant("c", "origin of moments: the world's", np.zeros(3))
            case "origin":
                shares = self._grasp.weights / self._grasp.weights.sum()
                mean = partial(np.matmul, shares)
                return self._build.apply("c", "origin of moments: centroid of the contacts", mean, self.read("points"))
        return self._build.read(name, READINGS[name])

    def fingers(self, resources: ContactSet) -> Array:
        """(k, n): ones at the joints of each contact's own finger; zero rows for contacts outside the set."""
        robot = self._target.robot
        return np.array(
            [
                [float(index in resources.contacts and joint in contact.finger) for joint in robot.joints]
                for index, contact in enumerate(robot.hand.contacts.values())
            ]
        )
