"""Lowering of errors: what a controller strives for minus what it senses, as pipeline steps."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.rotations import turn_between, turned
from graspdsl.basis.spaces import TaskSpace
from graspdsl.compiler import operations
from graspdsl.compiler.graph import (
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
)
from graspdsl.compiler.pipeline import PipelineBuilder
from graspdsl.compiler.settings import Target
from graspdsl.compiler.transforms import Transforms
from graspdsl.hands.descriptions import joint_limits


class Errors:
    """Makes the steps of reference − sensed. ``motion`` gives the step of a whole controller's displacement."""

    def __init__(
        self,
        build: PipelineBuilder,
        transforms: Transforms,
        target: Target,
        motion: Callable[[ControllerGraph], int],
    ) -> None:
        self._build, self._transforms, self._target, self._motion = build, transforms, target, motion

    def error(self, node: ControllerNode) -> int:
        """reference − sensed, flattened; a controller without a reference strives for zero or for its default."""
        build, resources = self._build, node.sensor_resources
        turning = node.potential.space is TaskSpace.ORIENTATION
        sensed = self._transforms.sensor(node.sensor, resources)
        label = f"e {node.potential.symbol}"
        if isinstance(resources, JointSet):
            return build.apply(label, "error: reference − sensed", np.subtract, self._posture(node, resources), sensed)
        match node.reference:
            case None:
                return build.apply(label, "error: zero − sensed", np.negative, sensed)
            case VectorReference(name, values):
                return self._vector(node, resources, name, np.array(values).reshape(-1, 3))
            case SensorReference(name, factor, sensor, set_of_reference):
                value = self._transforms.sensor(sensor, set_of_reference)
                value = build.apply(name, "reference", partial(np.multiply, factor), value)
            case ControllerReference(controller):
                shift = self._shift(controller, resources, turning)
                combine = turned if turning else np.add
                value = build.apply("ref", "reference: sensed + displacement", combine, shift, sensed)
        between = turn_between if turning else np.subtract
        error = build.apply(label, "error: reference − sensed", between, value, sensed)
        return build.apply(label, "flattened", operations.flat, error)

    def _shift(self, controller: ControllerGraph, resources: ContactSet, turning: bool) -> int:
        """One step of the controller in the reference, by resource, capped."""
        name, unit = ("Δr", 1.0 / self._target.control.curvature_radius) if turning else ("Δx", 1.0)
        cap = self._target.cap * unit
        capped = partial(operations.capped, cap)
        moved = self._build.apply(name, self._limited(cap, turning), capped, self._motion(controller))
        mixing = self._transforms.mixing(resources)
        rows = partial(operations.rows_of, np.ones((len(mixing), 1)) if turning else mixing)
        return self._build.apply(f"{name}({resources.label})", "by resource", rows, moved)

    def _vector(self, node: ControllerNode, resources: ContactSet, name: str, values: Array) -> int:
        """Reference minus the resources' means; the members of a virtual contact share its error.

        A far position or orientation is approached in steps of the cap.
        """
        build, space, label = self._build, node.potential.space, f"e {node.potential.symbol}"
        value = build.constant(name, "reference", values)
        means = self._transforms.sensor(node.sensor, resources, resources.matrix)
        between = turn_between if space is TaskSpace.ORIENTATION else np.subtract
        error = build.apply(label, "error: reference − sensed", between, value, means)
        if self._target.control.virtual == "members":
            owner = np.repeat(np.arange(len(resources.members)), [len(member.weights) for member in resources.members])
            spread = np.eye(len(resources.members))[owner]
            error = build.apply(label, "error of each member", partial(np.matmul, spread), error)
        error = build.apply(label, "flattened", operations.flat, error)
        caps = {TaskSpace.POSITION: 1.0, TaskSpace.ORIENTATION: 1.0 / self._target.control.curvature_radius}
        if space in caps:
            cap = self._target.cap * caps[space]
            about = self._limited(cap, space is TaskSpace.ORIENTATION)
            error = build.apply(label, about, partial(operations.capped, cap), error)
        return error

    def _limited(self, cap: float, turning: bool) -> str:
        size = f"{cap:.3g} rad" if turning else f"{1000 * cap:.3g} mm"
        return f"capped at {size} a {self._target.each}"

    def _posture(self, node: ControllerNode, joints: JointSet) -> int:
        match node.reference:
            case VectorReference(name, values):
                return self._build.constant(name, "reference posture", np.array(values))
            case SensorReference(name, factor, sensor, set_of_reference):
                value = self._transforms.sensor(sensor, set_of_reference)
                return self._build.apply(name, "reference posture", partial(np.multiply, factor), value)
        lower, upper = joint_limits(self._target.robot)
        middle = joints.matrix @ (np.array(lower) + np.array(upper)) / 2
        return self._build.constant("q_mid", "middle of the joints' ranges", middle)
