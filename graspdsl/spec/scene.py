"""What stands in the world: the hand, how it is carried and what it feels, and the object."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from graspdsl.spec.fields import Kilograms, Metres, Model, Number, exactly, fault, form, forms

Size = Annotated[Metres, Field(ge=0.005, le=2.0)]


class Cylinder(Model):
    """An upright cylinder."""

    diameter: Size = Field(description="diameter (m), 0.005 to 2", examples=[0.10])
    height: Size = Field(description="height (m), 0.005 to 2", examples=[0.20])


class Sphere(Model):
    """A ball."""

    diameter: Size = Field(description="diameter (m), 0.005 to 2", examples=[0.10])


class Box(Model):
    """A box with edges along the axes of the world."""

    size: Annotated[tuple[Size, Size, Size], exactly(3, "[x, y, z]: three lengths (m)")] = Field(
        description="lengths of the edges along x, y and z (m), 0.005 to 2 each", examples=[[0.06, 0.06, 0.20]]
    )


class InlineObject(Model):
    """An object described in the spec itself: exactly one shape, its mass, and a name if it should have one."""

    name: str | None = Field(default=None, min_length=1, max_length=60, description="what reports call the object")
    mass: Kilograms = Field(default=0.5, gt=0.0, le=100.0, description="mass (kg), above 0")
    cylinder: Cylinder | None = Field(default=None, description="an upright cylinder")
    sphere: Sphere | None = Field(default=None, description="a ball")
    box: Box | None = Field(default=None, description="a box")

    @model_validator(mode="after")
    def _one_shape(self) -> InlineObject:
        shapes = [name for name in ("cylinder", "sphere", "box") if getattr(self, name) is not None]
        if len(shapes) != 1:
            found = " and ".join(shapes) or "none"
            hint = "for example {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}"
            raise fault("wrong-form", f"an object has exactly one shape (cylinder, sphere or box), found {found}", hint)
        return self

    @property
    def shape(self) -> Cylinder | Sphere | Box:
        """The one shape there is."""
        return next(shape for shape in (self.cylinder, self.sphere, self.box) if shape is not None)


def _object_form(value: Any) -> str | None:
    if isinstance(value, str):
        return "name"
    return "inline" if isinstance(value, dict | InlineObject) else None


ObjectChoice = Annotated[
    Annotated[str, Field(min_length=1), form("name")] | Annotated[InlineObject, form("inline")],
    forms("the name of an object, or an object such as {cylinder: {diameter: 0.10, height: 0.20}}", _object_form),
]


class Scene(Model):
    """What the controller meets."""

    world: Literal["bullet"] = Field(description="bullet: rigid-body physics", examples=["bullet"])
    hand: str = Field(default="barrett", min_length=1, description="a hand of the catalogue, or a hand file")
    mount: Literal["gantry"] = Field(
        default="gantry", description="what carries the hand; gantry: a free wrist (6 axes)"
    )
    object: ObjectChoice = Field(
        description="an object of the catalogue, or one described here", examples=["towel-roll"]
    )
    friction: Number = Field(
        default=0.4, ge=0.0, le=5.0, description="friction coefficient between fingertip and object (1), 0 to 5"
    )
    sensing: Literal["load-cell", "exact"] = Field(
        default="load-cell",
        description="what a contact feels through; load-cell: a fingertip load cell; exact: the true contact",
    )
