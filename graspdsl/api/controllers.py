"""Compiled controllers, for a loop of one's own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from os import PathLike, fspath
from typing import Any

import numpy.typing as npt

from graspdsl.api.arrays import finite, floats, of_shape, of_unit_length
from graspdsl.api.examples import example_of
from graspdsl.api.formulas import Formula
from graspdsl.compiler.pipeline import Pipeline, Tick
from graspdsl.compiler.program import Program, program_of_expression
from graspdsl.compiler.surroundings import USUAL, Surroundings
from graspdsl.diagnostics import Diagnostic, DiagnosticError, reading
from graspdsl.plugins.answering import answered_for
from graspdsl.worlds.protocol import Observation

# In the order of an observation: its units, and its axes, as long as there are contacts and joints.
_CONTACTS, _JOINTS = "contacts", "joints"
_FIELDS: Mapping[str, tuple[str, tuple[int | str, ...]]] = {
    "time": ("s", ()),
    "points": ("m", (_CONTACTS, 3)),
    "normals": ("1", (_CONTACTS, 3)),
    "forces": ("N", (_CONTACTS, 3)),
    "touching": ("1", (_CONTACTS,)),
    "joints": ("rad, m of a slide", (_JOINTS,)),
    "jacobian": ("m/rad, 1 of a slide", (_CONTACTS, 3, _JOINTS)),
    "angular_jacobian": ("1, rad/m of a slide", (_CONTACTS, 3, _JOINTS)),
    "orientations": ("rad", (_CONTACTS, 3)),
    "centre_of_mass": ("m", (3,)),
    "weight": ("N", (3,)),
}
_TICK = {"force_residual": "1", "moment_residual": "m", "force_error": "N", "ranks": "1", "locked": "1"}


def compile(
    formula: Formula | str,
    *,
    hand: str | PathLike[str] = "barrett",
    mount: str = "gantry",
    resources: Mapping[str, str] | None = None,
    parameters: Mapping[str, npt.ArrayLike] | None = None,
    control: Mapping[str, Any] | None = None,
    held: bool | None = None,
) -> Controller:
    """The controller of a formula, on a hand and a mount, as ``graspdsl explain`` shows it.

    hand, mount: of the catalogue, or a file. resources: ``{"γ1": "finger-3", "Γ": "{γ1, γ2}"}``, by default γ1 the
    thumb of the Barrett hand and Γ = {γ1, <γ2, γ3>}; of another hand its contacts γ1, γ2 … in their order, and Γ all of
    them. parameters: numbers and vectors that the formula names, by default κ_f = 0.5 N. control: keys of a spec's
    ``control``, ``{"step": 0.0005}``. held: whether the object is fixed to the hand, by default where the formula turns
    contacts or senses gravity.

    Raises DiagnosticError with the place of every mistake in the formula, or in what is given besides, which is shown
    as the spec that it makes. A formula with ``then`` is more than one: :class:`graspdsl.ControlLoop` runs programs.
    """
    text = str(formula)
    around = Surroundings(fspath(hand), mount, control=control or {}, held=held)
    if resources is not None or around.hand != USUAL.hand:
        around = replace(around, resources=resources)
    if parameters is not None:
        around = replace(around, parameters=parameters)
    with reading("formula", text), answered_for():
        program = program_of_expression(text, around)
        ((pipeline, *others),) = program.pipelines()
        if others:
            message = f"'then' makes {len(others) + 1} controllers of this formula, one after the other"
            hint = "compile each by itself, or run a spec of them with ControlLoop"
            raise DiagnosticError([Diagnostic("several-controllers", message, hint=hint)])
    return Controller(program, pipeline)


class Controller:
    """A compiled controller: called with an observation, it gives back a tick. Made by :func:`compile`.

    It keeps no memory: the same observation gives the same tick. ``program``: what it was compiled from; ``pipeline``:
    its numerical steps.
    """

    def __init__(self, program: Program, pipeline: Pipeline) -> None:
        self.program, self.pipeline = program, pipeline
        sizes = {_CONTACTS: len(self.contacts), _JOINTS: len(self.joints)}
        self._shapes = {
            name: tuple(sizes[size] if isinstance(size, str) else size for size in axes)
            for name, (_, axes) in _FIELDS.items()
        }
        self._read = {step.reading for step in pipeline.steps if step.reading is not None} | {"joints"}

    def __call__(self, observation: Observation) -> Tick:
        """What to do now: ``tick.command``, and what was measured on the way.

        ``force_residual`` (3,) and ``moment_residual`` (3,) [m] are ρ_f and ρ_m of the grasp's contacts as sensed,
        ``force_error`` [N] the largest distance of a contact force from its reference, ``ranks`` the dimensions of the
        null spaces below the levels that others are subject to, ``disturbances`` how far the command takes what each of
        these senses from where that level alone would have taken it, ``locked`` the joints at a limit.
        Raises ValueError, saying what was expected, for an observation of other shapes, or one in which what is read is
        no finite number or a normal is no unit vector.
        """
        checked = self._checked(observation)
        with answered_for(self.program.plugins):
            return self.pipeline.evaluate(checked)

    @property
    def joints(self) -> tuple[str, ...]:
        """The names of the joints, in the order of observations and commands."""
        return tuple(self.program.robot.joints)

    @property
    def contacts(self) -> tuple[str, ...]:
        """The names of the contacts, in the order of observations."""
        return self.program.robot.contacts

    @property
    def space(self) -> str:
        """What a command displaces a tick: "q", all joints (n,) [rad or m], or "x", all contacts (k, 3) [m]."""
        return self.pipeline.space

    @property
    def rate(self) -> float:
        """The ticks a second that its gains and steps are laid out for."""
        return self.program.target.rate

    @property
    def units(self) -> dict[str, str]:
        """The units of what an observation and a tick hold, by name."""
        command = _FIELDS["joints"][0] if self.space == "q" else "m"
        disturbances = ", ".join(priority.effect_unit for priority in self.pipeline.priorities)
        units = {name: unit for name, (unit, _) in _FIELDS.items()}
        return units | {"command": command, "disturbances": disturbances} | _TICK

    @property
    def shapes(self) -> dict[str, tuple[int, ...]]:
        """The shapes of what an observation holds, by name."""
        return dict(self._shapes)

    def example(self) -> Observation:
        """An observation to start from: every fingertip on one ball in front of the palm, pressing with 1 N.

        Its Jacobians are those of the hand with its fingers as far closed as the ball has them, in the frame of the
        robot's root; always the same numbers.
        """
        return example_of(self.program)

    def __repr__(self) -> str:
        scene = self.program.spec.scene
        label, given = self.program.phases[0].label, f"{scene.hand} on {scene.mount}"
        return f"<Controller {label}: {given}, {len(self.contacts)} contacts, commands in {self.space}>"

    def _checked(self, observation: Observation) -> Observation:
        """The observation as arrays of floats."""
        arrays = {field.name: floats(field.name, getattr(observation, field.name)) for field in fields(Observation)}
        for name, array in arrays.items():
            of_shape(name, array, self._shapes[name])
            if name in self._read:
                finite(name, array)
        of_unit_length("normals", arrays["normals"])
        checked: dict[str, Any] = {**arrays, "touching": arrays["touching"].astype(bool)}
        return replace(observation, **checked)
