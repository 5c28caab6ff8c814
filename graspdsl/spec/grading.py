"""How final grasps are judged: the conventions that a grade's numbers mean nothing without."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from graspdsl.places.fields import Count, Metres, Model, fault, form, forms, is_number

RADIUS_OF_GYRATION: Literal["radius-of-gyration"] = "radius-of-gyration"
DEFAULT_EDGES = 16

ContactKind = Literal["hard", "soft-finger", "frictionless"]


def _even(edges: int) -> int:
    if edges % 2:
        message = f"a friction pyramid has an even number of edges, found {edges}"
        raise fault("out-of-range", message, f"write {edges + 1}", f"{edges + 1}")
    return edges


def _scale_form(value: Any) -> str | None:
    if is_number(value) or (isinstance(value, str) and value[:1].isdigit()):  # a text such as 4 cm is meant as one
        return "length"
    return "name" if value == RADIUS_OF_GYRATION else None


TorqueScale = Annotated[
    Annotated[Literal["radius-of-gyration"], form("name")] | Annotated[Metres, Field(ge=1e-4, le=10.0), form("length")],
    forms("radius-of-gyration (the default) or a length", _scale_form),
]


class Grading(Model):
    """By what conventions the final grasps are judged: the same for all grasps of a run."""

    contact: ContactKind | None = Field(
        default=None,
        description="what a contact can pass on; hard: force in the friction cone; soft-finger: also a moment about "
        "its normal; frictionless: force along its normal; by default soft-finger for grasps in which no more than two "
        "contacts touch, or where torsion is given, and hard for all others (Sec. 4.1.3)",
    )
    torsion: Metres | None = Field(
        default=None,
        gt=0.0,
        le=0.1,
        description="largest moment of a soft finger about its normal over its normal force (m); by default "
        "(3π/16) μ a with the friction coefficient μ and a round patch of the radius a = 2.8 mm, that of a Barrett "
        "fingertip under 1 N",
    )
    edges: Annotated[Count, AfterValidator(_even)] = Field(
        default=DEFAULT_EDGES,
        ge=4,
        le=64,
        description="how many edges the pyramids within the friction cones have, an even number, 4 to 64",
    )
    torque_scale: TorqueScale = Field(
        default=RADIUS_OF_GYRATION,
        description="what moments are divided by to be compared with forces, a length (m) or by name; "
        "radius-of-gyration: that of the object",
    )
