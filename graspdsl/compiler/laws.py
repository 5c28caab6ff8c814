"""Control laws: how the gradient of a potential becomes a displacement in its gradient space."""

from __future__ import annotations

from functools import partial

import numpy as np

from graspdsl.basis.algebra import damped_pseudo_inverse
from graspdsl.basis.spaces import GradientSpace, TaskSpace
from graspdsl.compiler import operations
from graspdsl.compiler.graph import ControllerNode
from graspdsl.compiler.pipeline import PipelineBuilder
from graspdsl.compiler.settings import Target
from graspdsl.compiler.transforms import Transforms


class Laws:
    """Makes the steps from ∇φ (``slope``) and τ (``task``) of a controller to its displacement."""

    def __init__(self, build: PipelineBuilder, transforms: Transforms, target: Target) -> None:
        self._build, self._transforms = build, transforms
        self._control, self._rate = target.control, target.rate

    def displacement(self, node: ControllerNode, slope: int, task: int) -> int:
        """The step of the controller's displacement."""
        laws = {
            TaskSpace.NET_FORCE: self._residual,
            TaskSpace.NET_MOMENT: self._residual,
            TaskSpace.POSITION: self._position,
            TaskSpace.FORCE: self._force,
        }
        return laws[node.potential.space](node, slope, task)

    def _residual(self, node: ControllerNode, slope: int, task: int) -> int:
        """−k τᵀ∇φ: a unit net force moves a contact by ``step``; a moment weighs as a force at the curvature radius.

        In surface coordinates the contact moves by as much, a displacement being the curvature radius times an angle.
        """
        radius, step = self._control.curvature_radius, self._control.step
        moment = node.potential.space is TaskSpace.NET_MOMENT
        gain = 0.5 * step * self._control.moment_gain / radius if moment else 0.5 * step * radius
        surface = node.gradient_space is GradientSpace.SURFACE
        gain, unit = (gain / radius**2, "rad") if surface else (gain, "m")
        name = node.potential.symbol
        about = f"gradient in {node.gradient_space.value}, Eq. {node.effector.equation}"
        gradient = self._build.apply(f"τᵀ∇{name}", about, operations.transposed_times, task, slope)
        return self._build.apply(f"−k∇{name}", f"step down it [{unit} a tick]", partial(np.multiply, gain), gradient)

    def _position(self, node: ControllerNode, slope: int, task: int) -> int:
        """J⁺e or Jᵀe while every contact touches; otherwise the contacts wait for each other."""
        name, damping = node.potential.symbol, self._control.damping
        if self._control.inverse == "pseudo-inverse":
            invert = partial(damped_pseudo_inverse, damping)
            inverse = self._build.apply("J⁺", f"damped pseudo-inverse, λ = {damping:g}", invert, task)
            moved = self._build.apply(f"J⁺∇{name}", "joint displacement, Eq. 4.20", operations.times, inverse, slope)
        else:
            about = "joint displacement, Eq. 4.20"
            moved = self._build.apply(f"Jᵀ∇{name}", about, operations.transposed_times, task, slope)
        resources = node.effector_resources
        members = np.isin(np.arange(resources.count), resources.contacts).astype(float)
        check = partial(operations.all_touch, members)
        gate = self._build.apply("touch", "1 when every contact touches", check, self._transforms.read("touching"))
        return self._build.apply(f"Δ{name}", "held while a contact is lost", operations.gated, moved, gate)

    def _force(self, node: ControllerNode, slope: int, task: int) -> int:
        """Admittance times Jᵀe for contacts that touch; the others approach along their normals, finger by finger."""
        build, resources, read = self._build, node.effector_resources, self._transforms.read
        fastest, admittance = self._control.approach / self._rate, self._control.admittance
        name = node.potential.symbol
        check = partial(operations.row_touches, self._transforms.mixing(resources))
        touching = build.apply("touch(Γ)", "1 for each resource that touches", check, read("touching"))
        rows = build.apply(f"∇{name}(Γ)", "by resource", operations.by_contact, slope)
        press = partial(operations.pressing, admittance, fastest)
        pressed = build.apply("k e", f"admittance {admittance:g} m/N a tick, capped", press, rows, touching)
        pressed = build.apply("k e", "flattened", operations.flat, pressed)
        servo = build.apply("τᵀ k e", "joint displacement, Eq. 4.21", operations.transposed_times, task, pressed)
        close = partial(operations.approach, self._transforms.fingers(resources), fastest)
        inputs = (read("jacobian"), read("normals"), read("touching"))
        approach = build.apply("approach", "contacts that do not touch close with their own fingers", close, *inputs)
        return build.apply(f"Δ{name}", "force servo + approach", np.add, servo, approach)
