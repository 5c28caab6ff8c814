"""Control laws: how the gradient of a potential becomes a displacement in its gradient space."""

from __future__ import annotations

from functools import partial

import numpy as np

from graspdsl.basis.algebra import damped_pseudo_inverse, scaled_transpose
from graspdsl.basis.resources import ContactSet, JointSet
from graspdsl.basis.spaces import GradientSpace, TaskSpace
from graspdsl.compiler import operations
from graspdsl.compiler.citing import cited
from graspdsl.compiler.graph import ControllerNode
from graspdsl.compiler.pipeline import PipelineBuilder
from graspdsl.compiler.settings import Target
from graspdsl.compiler.transforms import Transforms

POSTURE_STEP = 5e-4  # of scaled joint displacement a tick: about half a millimetre at a fingertip


class Laws:
    """Makes the steps from ∇φ (``slope``) and τ (``task``) of a controller to its displacement."""

    def __init__(self, build: PipelineBuilder, transforms: Transforms, grasp: ContactSet, target: Target) -> None:
        self._build, self._transforms, self._grasp = build, transforms, grasp
        self._control, self._target = target.control, target

    def displacement(self, node: ControllerNode, slope: int, task: int) -> int:
        """The step of the controller's displacement."""
        laws = {
            TaskSpace.NET_FORCE: self._residual,
            TaskSpace.NET_MOMENT: self._residual,
            TaskSpace.NET_WRENCH: self._residual,
            TaskSpace.POSITION: self._inverse,
            TaskSpace.ORIENTATION: self._inverse,
            TaskSpace.FORCE: self._pressing,
            TaskSpace.MOMENT: self._pressing,
            TaskSpace.POSTURE: self._posture,
        }
        return laws[node.potential.space](node, slope, task)

    def _residual(self, node: ControllerNode, slope: int, task: int) -> int:
        """−k τᵀ∇φ: a unit net force moves a contact by ``step``; a moment weighs as a force at the curvature radius.

        In surface coordinates and in rotations it moves or turns by that over the curvature radius.
        """
        radius, step = (
            self._control.curvature_radius,
            self._target.step(float(self._grasp.weights @ self._grasp.weights)),
        )
        moment = node.potential.space is TaskSpace.NET_MOMENT
        gain = 0.5 * step * self._control.moment_gain / radius if moment else 0.5 * step * radius
        turns = node.gradient_space is not GradientSpace.CARTESIAN
        gain, moved = (gain / radius**2, f"{step / radius:.3g} rad") if turns else (gain, f"{1000 * step:.3g} mm")
        name = node.potential.symbol
        about = f"gradient in {node.gradient_space.value}, {cited(node.effector.equation)}"
        gradient = self._build.apply(f"τᵀ∇{name}", about, operations.transposed_times, task, slope)
        what = f"a moment of {1000 * radius:.3g} mm, × {self._control.moment_gain:g}" if moment else "a unit net force"
        about = f"step down it, k = {gain:.3g}: {moved} a {self._target.each} for {what}"
        return self._build.apply(f"−k∇{name}", about, partial(np.multiply, gain), gradient)

    def _inverse(self, node: ControllerNode, slope: int, task: int) -> int:
        """K_p J⁺e, J⁺ a pseudo-inverse or a transpose, while all contacts touch; else they wait (Eq. 4.20)."""
        name, damping, gain = node.potential.symbol, self._control.damping, self._control.position_gain
        if self._control.inverse == "pseudo-inverse":
            invert = partial(damped_pseudo_inverse, damping)
            inverse = self._build.apply("J⁺", f"damped pseudo-inverse, λ = {damping:g}", invert, task)
        else:
            inverse = self._build.apply("Jᵀ/σ²", "transpose, σ the largest singular value", scaled_transpose, task)
        about = f"joint displacement, {cited(node.potential.equation)}"
        moved = self._build.apply(f"J⁺∇{name}", about, operations.times, inverse, slope)
        if gain != 1.0:
            moved = self._build.apply(f"K_p Δ{name}", f"{gain:g} of it a tick", partial(np.multiply, gain), moved)
        if self._target.held:
            return moved
        resources = contacts_of(node.effector_resources)
        members = np.isin(np.arange(resources.count), resources.contacts).astype(float)
        check = partial(operations.all_touch, members)
        gate = self._build.apply("touch", "1 when every contact touches", check, self._transforms.read("touching"))
        return self._build.apply(f"Δ{name}", "held while a contact is lost", operations.gated, moved, gate)

    def _pressing(self, node: ControllerNode, slope: int, task: int) -> int:
        """Admittance times Jᵀe for contacts that touch; the others approach along their normals, finger by finger."""
        build, resources, read = self._build, contacts_of(node.effector_resources), self._transforms.read
        fastest, admittance = self._control.approach / self._target.rate, self._control.admittance
        name, unit, most = node.potential.symbol, "m/N", "m"
        if node.potential.space is TaskSpace.MOMENT:
            admittance, unit, most = admittance / self._control.curvature_radius**2, "1/(N·m)", "rad"
            fastest /= self._control.curvature_radius
        check = partial(operations.row_touches, self._transforms.mixing(resources))
        touching = build.apply("touch(Γ)", "1 for each resource that touches", check, read("touching"))
        rows = build.apply(f"∇{name}(Γ)", "by resource", operations.by_contact, slope)
        press = partial(operations.pressing, admittance, fastest)
        about = f"admittance {admittance:g} {unit} a tick, capped at {fastest:.3g} {most} a tick"
        pressed = build.apply("k e", about, press, rows, touching)
        pressed = build.apply("k e", "flattened", operations.flat, pressed)
        about = f"joint displacement, {cited(node.potential.equation)}"
        servo = build.apply("τᵀ k e", about, operations.transposed_times, task, pressed)
        close = partial(operations.approach, self._transforms.fingers(resources), fastest)
        inputs = (read("jacobian"), read("normals"), read("touching"))
        about = f"contacts that do not touch close with their own fingers, {fastest:.3g} m a tick"
        approach = build.apply("approach", about, close, *inputs)
        return build.apply(f"Δ{name}", "servo + approach", np.add, servo, approach)

    def _posture(self, node: ControllerNode, slope: int, task: int) -> int:
        """A share of the posture error, τ⁺e: the joints of Γσ that Γτ moves go that part of the way."""
        name, gain = node.potential.symbol, self._control.posture_gain
        inverse = self._build.apply("τ⁺", "pseudo-inverse", np.linalg.pinv, task)
        moved = self._build.apply(f"τ⁺∇{name}", "joint displacement, Eq. 4.25", operations.times, inverse, slope)
        part = self._build.apply(f"k Δ{name}", f"{gain:g} of it a tick", partial(np.multiply, gain), moved)
        slow = partial(operations.shortened, POSTURE_STEP)
        return self._build.apply(f"Δ{name}", f"no more than {POSTURE_STEP:g} a tick", slow, part)


def contacts_of(resources: ContactSet | JointSet) -> ContactSet:
    """The contacts of a controller that the checker has found to act on contacts."""
    assert isinstance(resources, ContactSet)
    return resources
