"""How many trials there are, and how each one starts."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from graspdsl.spec.distributions import Angle, Gap, JointPlace, Length
from graspdsl.spec.fields import Count, Model


class Start(Model):
    """Where the hand stands when a trial starts; every number may be a distribution."""

    approach: Literal["side", "top", "surface"] | None = Field(
        default=None,
        description="where the palm faces the object from; surface: contacts drawn evenly over it, for the floating "
        "world; by default side, and surface in the floating world",
    )
    roll: Angle = Field(default=0.0, description="rotation (rad) of the hand about the normal of its palm")
    height: Length = Field(default=0.10, description="height (m) of the palm above the table")
    standoff: Gap = Field(default=0.047, description="gap (m) between palm and object")
    yaw: Angle = Field(default=0.0, description="direction (rad) the hand comes from, about the vertical")
    offset: Length = Field(default=0.0, description="sideways displacement (m) of the hand from the object's axis")
    tilt: Angle = Field(default=0.0, description="rotation (rad) of the palm's normal out of its plane of approach")
    posture: dict[str, JointPlace] = Field(
        default={}, description="joints (rad or m) of the hand that start elsewhere than in its open posture"
    )


class Trials(Model):
    """The trials of a run."""

    count: Count = Field(default=20, ge=1, le=100_000, description="how many trials there are, 1 to 100000")
    seed: Count = Field(default=0, ge=0, le=2**63 - 1, description="what the random numbers are made from, 0 to 2⁶³−1")
    start: Start = Field(default=Start(), description="where the hand stands when a trial starts")
