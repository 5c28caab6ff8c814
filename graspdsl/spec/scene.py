"""What stands in the world: the hand, how it is carried and what it feels, and the object."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BaseModel, Field, create_model, model_validator
from pydantic.fields import FieldInfo

from graspdsl.objects.object_files import FILES, FilePath, Mass, Mesh, MjcfChoice
from graspdsl.objects.shape import DescribedShape
from graspdsl.objects.shapes import SHAPES
from graspdsl.objects.turned import ObjectPose
from graspdsl.places.fields import Count, Model, Number, Seconds, Unit, fault, form, forms, name_in
from graspdsl.spec.growing import Growing, grow
from graspdsl.spec.sensing import SensingChoice

GRAVITY = 9.81  # m/s²
TIME_STEPS, MOST_ITERATIONS = (1e-4, 0.02), 10_000  # s; 1


class _Described(Growing):
    like: str | None = Field(default=None, min_length=1, description="an object of the catalogue, instead of a shape")
    name: str | None = Field(default=None, min_length=1, max_length=60, description="what reports call the object")
    mass: Mass | None = Field(default=None, description="mass (kg), above 0; by default 0.5, or the catalogue's")
    held: bool = Field(default=False, strict=True, description="whether it is fixed to the hand when a trial starts")
    fixed: bool = Field(default=False, strict=True, description="whether it is fixed to the world")
    pose: ObjectPose | None = Field(
        default=None,
        description="how it is turned before it is put on the table, by name or by {rpy: [roll, pitch, yaw]} (rad), by "
        "default as its shape or file has it; lay-down: its major axis level, along y; upside-down: on its head",
        examples=["lay-down"],
    )


def _key(kind: type[DescribedShape]) -> Any:
    return Field(default=None, description=kind.about)


if TYPE_CHECKING:
    _Shaped = _Described
else:  # with a key for each shape of the table
    _keys = {name: (kind | None, _key(kind)) for name, kind in SHAPES.items()}
    _Shaped = create_model("_Shaped", __base__=_Described, **_keys)


class InlineObject(_Shaped):
    """An object described in the spec itself: exactly one shape or a catalogue name, and what is special about it."""

    later: ClassVar = set()

    mesh: Mesh | None = Field(default=None, description="a file of triangles, placed by its bounding box")
    urdf: FilePath | None = Field(
        default=None,
        description="a URDF file: its collision geometry as one body, placed by its bounding box, without its inertias",
        examples=["part.urdf"],
    )

    mjcf: MjcfChoice | None = Field(
        default=None,
        description="an MJCF file, or {file: …, body: …}: what touches of a body, as one body, as of a URDF",
        examples=["part.xml"],
    )

    @model_validator(mode="after")
    def _one_shape(self) -> InlineObject:
        shapes = [name for name in ("like", *SHAPES, *FILES) if self.given(name) is not None]
        if len(shapes) != 1:
            found = " and ".join(shapes) or "none"
            hint = "for example {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}"
            message = f"an object has exactly one shape ({', '.join((*SHAPES, *FILES))}, or like), found {found}"
            raise fault("wrong-form", message, hint)
        if self.mesh is not None and self.mesh.density is not None and self.mass is not None:
            raise fault("wrong-form", "an object has a mass or a density, not both", "keep one")
        if self.held and self.fixed:
            raise fault("wrong-form", "an object is held by the hand or fixed to the world, not both", "keep one")
        return self

    @property
    def shape(self) -> DescribedShape | None:
        """The one shape there is; None for one of the catalogue or of a file."""
        return next((shape for name in SHAPES if (shape := self.given(name)) is not None), None)

    @property
    def file(self) -> tuple[str, ...]:
        """The key, or the keys, under which a file is named; empty where none is."""
        if self.mesh is not None:
            return ("mesh", "file")
        if self.urdf is not None:
            return ("urdf",)
        return () if self.mjcf is None else ("mjcf",) if isinstance(self.mjcf, str) else ("mjcf", "file")


def _object_form(value: Any) -> str | None:
    if isinstance(value, str):
        return "name"
    return "inline" if isinstance(value, dict | InlineObject) else None


ObjectChoice = Annotated[
    Annotated[str, Field(min_length=1), form("name")] | Annotated[InlineObject, form("inline")],
    forms("the name of an object, or an object such as {cylinder: {diameter: 0.10, height: 0.20}}", _object_form),
]


class Physics(Model):
    """How finely physics is worked out."""

    time_step: Seconds | None = Field(
        default=None,
        ge=TIME_STEPS[0],
        le=TIME_STEPS[1],
        description="time between steps of physics (s), 0.0001 to 0.02; a tick of 0.02 s is a whole number of them; "
        "by default 0.002",
        examples=[0.001],
    )
    solver_iterations: Count | None = Field(
        default=None,
        ge=1,
        le=MOST_ITERATIONS,
        description="how often the solver of contact forces iterates in a step (1), at most; by default 200 in bullet, "
        "100 in mujoco",
        examples=[400],
    )


class Scene(Growing):
    """What the controller meets."""

    later: ClassVar = {"physics"}

    world: Annotated[str, name_in("worlds")] = Field(
        description="what the trials run in",
        examples=["bullet"],
    )
    hand: str = Field(default="barrett", min_length=1, description="a hand of the catalogue, or a hand file")
    mount: str = Field(
        default="gantry", min_length=1, description="what carries the hand: a mount of the catalogue, or a mount file"
    )
    object: ObjectChoice = Field(
        description="an object of the catalogue, or one described here", examples=["towel-roll"]
    )
    friction: Number = Field(
        default=0.4, ge=0.0, le=5.0, description="friction coefficient between fingertip and object (1), 0 to 5"
    )
    gravity: Annotated[Number, Unit("m/s²")] = Field(
        default=GRAVITY,
        ge=0.0,
        le=100.0,
        description="acceleration of free fall (m/s²), downwards; 0: a free object floats where it would stand, the "
        "table is out of the way, and a grasp has to balance by itself",
    )
    sensing: SensingChoice | None = Field(
        default=None,
        description="what a contact feels through, by name or as one sensor with parameters; load-cell: a fingertip "
        "load cell; skin: taxels; proximity: distances; exact: the true contact; by default exact in "
        "floating, else load-cell",
    )

    physics: Physics | None = Field(
        default=None, description="how finely physics is worked out, by default as is usual in the world"
    )

    @property
    def held(self) -> bool:
        """Whether the object is fixed to the hand."""
        return isinstance(self.object, InlineObject) and self.object.held

    @property
    def afloat(self) -> bool:
        """Whether the object floats: it is free and has no weight."""
        bound = isinstance(self.object, InlineObject) and (self.object.held or self.object.fixed)
        return self.gravity == 0.0 and not bound


def add_shape(shape: type[DescribedShape], around: Sequence[type[BaseModel]]) -> None:
    """Enter a shape into the table, and its key into the models, those ``around`` a scene the inner first."""
    optional: Any = shape | None
    field = FieldInfo.from_annotated_attribute(optional, _key(shape))
    grow({(InlineObject, shape.name): field}, (Scene, *around))
    InlineObject.later.add(shape.name)
    SHAPES[shape.name] = shape
