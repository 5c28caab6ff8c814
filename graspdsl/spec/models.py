"""The spec: everything a run is made from."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field

from graspdsl.places.fields import Model, Number, fault, form, forms, is_number, name_in
from graspdsl.places.wording import shown, slug
from graspdsl.spec.grading import Grading
from graspdsl.spec.monitors import MonitorBounds
from graspdsl.spec.program import Control, Phase
from graspdsl.spec.scene import Scene
from graspdsl.spec.sweeping import Sweep
from graspdsl.spec.trials import Trials


def _version(value: Any) -> Any:
    # True and 1.0 equal 1, but a version is written 1.
    if type(value) is not int or value != 1:
        message = f"expected 1, the version of the spec's format, found {shown(value)}"
        raise fault("wrong-version", message, "write 1", "1")
    return value


def folder_name(name: str) -> str:
    """A name that may become part of a folder's name, on any system; refuses others."""
    if not re.fullmatch(r"[^\W_](?:[\w.-]{0,58}\w)?", name):
        near = slug(name)
        message = f"expected a name of up to 60 letters, digits, '-', '_' and '.', found {shown(name)}"
        hint = f"write {near}" if near else "for example towel-roll-two-contacts"
        raise fault("bad-name", message, hint, near or None)
    return name


class ControllerDefinition(Model):
    """A controller of the user's own, with where it comes from."""

    model_config = ConfigDict(serialize_by_alias=True)

    body: str = Field(alias="is", min_length=1, description="what the name stands for: a formula", examples=["π_s|Γ Γ"])
    equation: str = Field(default="", description="the number of its equation in the literature")
    about: str = Field(default="", description="what it is for")


def _definition_form(value: Any) -> str | None:
    if isinstance(value, str):
        return "body"
    return "definition" if isinstance(value, dict | ControllerDefinition) else None


def _parameter_form(value: Any) -> str | None:
    if is_number(value):
        return "number"
    return "list" if isinstance(value, list | tuple) else None


ControllerEntry = Annotated[
    Annotated[str, Field(min_length=1), form("body")] | Annotated[ControllerDefinition, form("definition")],
    forms('a formula, or {is: a formula, equation: "4.30", about: …}', _definition_form),
]
LARGEST_PARAMETER = 10_000.0  # N, m, rad or N·m

Value = Annotated[Number, Field(ge=-LARGEST_PARAMETER, le=LARGEST_PARAMETER)]
Parameter = Annotated[
    Annotated[Value, form("number")] | Annotated[tuple[Value, ...], Field(min_length=1), form("list")],
    forms("a number or a list of numbers", _parameter_form),
]


class Spec(Model):
    """A grasp controller, the scene it runs in, and the trials it is judged by."""

    graspdsl: Annotated[Literal[1], BeforeValidator(_version)] = Field(
        description="the version of this format", examples=[1]
    )
    name: Annotated[str, AfterValidator(folder_name)] = Field(
        description="a short name, also of the folder of results", examples=["towel-roll-two-contacts"]
    )
    about: str = Field(default="", description="what the spec is for")
    scene: Scene = Field(
        description="the world, the hand and the object", examples=[{"world": "bullet", "object": "towel-roll"}]
    )
    resources: dict[str, str] = Field(
        description="names of contacts and of sets of them",
        examples=[{"γ1": "finger-3", "γ2": "finger-1", "Γ": "{γ1, γ2}"}],
    )
    parameters: dict[str, Parameter] = Field(
        default={}, description="numbers and vectors that formulas use by name, in the unit their place asks for"
    )
    controllers: dict[str, ControllerEntry] = Field(
        default={}, description="controllers of your own: 'π_mine|Γ_τ Γ_σ' and what it stands for"
    )
    control: Control = Field(default=Control.usual(), description="how gradients become motion")
    program: tuple[Phase, ...] = Field(
        min_length=1,
        description="the phases of a trial, in their order",
        examples=[[{"run": "π_close|Γ Γ", "until": {"contact": "all"}}]],
    )
    code: tuple[Annotated[str, Field(min_length=1, max_length=1000)], ...] = Field(
        default=(),
        description="Python files beside the spec with potentials, grades and the like of your own; read only with "
        "--allow-code",
        examples=[["my_potential.py"]],
    )
    monitors: MonitorBounds = Field(default=MonitorBounds.usual(), description="what ends a trial that went wrong")
    evaluate: tuple[Annotated[str, name_in("grades")], ...] = Field(
        default=(), description="how the final grasps are graded"
    )
    grading: Grading = Field(default=Grading.usual(), description="by what conventions they are graded")
    trials: Trials = Field(default=Trials.usual(), description="how many trials there are and how they start")
    sweep: Sweep | None = Field(
        default=None, description="points at which all trials are run, which differ in some fields of the spec"
    )

    def before(self, height: float) -> Spec:
        """The spec with the heights of its starts in m, before an object of a height [m]."""
        return self.model_copy(update={"trials": self.trials.before(height)})

    def definitions(self) -> dict[str, ControllerDefinition]:
        """The user's own controllers by their heads, all in the long form."""
        return {
            head: ControllerDefinition.model_validate({"is": entry}) if isinstance(entry, str) else entry
            for head, entry in self.controllers.items()
        }
