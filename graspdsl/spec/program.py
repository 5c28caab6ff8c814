"""What the controller does: the phases of a trial, and how a tick turns a gradient into motion."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from graspdsl.spec.fields import Metres, Model, Number, Seconds, Unit, fault


class Until(Model):
    """When a phase has reached its end: all of the conditions given hold, for a while."""

    contact: Literal["all"] | None = Field(default=None, description="all: every contact touches the object")
    force_residual: Number | None = Field(
        default=None, gt=0.0, description="the norm of the net unit force (1) is below this"
    )
    moment_residual: Metres | None = Field(
        default=None, gt=0.0, description="the norm of the net moment of unit forces (m) is below this"
    )
    hold: Seconds = Field(default=0.2, ge=0.0, le=600.0, description="how long the conditions must hold (s)")

    @model_validator(mode="after")
    def _some_condition(self) -> Until:
        if self.contact is None and self.force_residual is None and self.moment_residual is None:
            hint = "for example {contact: all}, or {force_residual: 0.1, moment_residual: 0.005}"
            raise fault("missing-key", "'until' needs contact, force_residual or moment_residual", hint)
        return self


class Phase(Model):
    """One controller, run until its end or its time limit."""

    run: str = Field(min_length=1, description="the controller: a formula", examples=["π_s|Γ Γ (π_gx|Γ Γ)"])
    until: Until = Field(description="when the phase has reached its end", examples=[{"contact": "all"}])
    limit: Seconds = Field(default=30.0, gt=0.0, le=600.0, description="time limit of the phase (s), up to 600")


class Control(Model):
    """How gradients become motion. A tick is one step of the control loop."""

    step: Metres = Field(
        default=0.0005, gt=0.0, le=0.1, description="displacement (m) a tick for a unit gradient of the force residual"
    )
    moment_gain: Number = Field(
        default=1.0, ge=0.0, le=1e6, description="factor (1) on the moment residual's part of the motion"
    )
    cap: Metres = Field(default=0.00075, gt=0.0, le=0.1, description="largest displacement (m) of a contact a tick")
    admittance: Annotated[Number, Unit("m/N")] = Field(
        default=5e-5, ge=0.0, le=0.1, description="displacement for a unit of force error (m/N) a tick"
    )
    approach: Annotated[Number, Unit("m/s")] = Field(
        default=0.02, gt=0.0, le=1.0, description="speed (m/s) of a contact that does not touch yet"
    )
    nullspace: Literal["gradient", "task"] = Field(
        default="gradient",
        description="where lower priorities may act; gradient: normal to the higher gradients (Eq. 4.19); "
        "task: the null space of the higher task Jacobians",
    )
    inverse: Literal["pseudo-inverse", "transpose"] = Field(
        default="pseudo-inverse", description="what turns contact motion into joint motion"
    )
    damping: Number = Field(default=0.02, ge=0.0, le=10.0, description="damping (1) of the pseudo-inverse")
    virtual: Literal["members", "common"] = Field(
        default="members",
        description="how a virtual contact moves; members: each member by its own share; common: all alike",
    )
    origin: Literal["centroid", "world"] = Field(
        default="centroid", description="the point moments are taken about; centroid: the mean of the contacts"
    )
    curvature_radius: Metres = Field(
        default=0.05, gt=0.0, le=100.0, description="radius (m) of the object that the gradients assume"
    )
