"""What the controller does: the phases of a trial, and how a tick turns a gradient into motion."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal

from pydantic import Field, model_validator

from graspdsl.places.fields import Metres, Model, Number, Seconds, Unit, fault
from graspdsl.spec.growing import Growing


class Until(Model):
    """When a phase has reached its end: all of the conditions given hold, for a while."""

    contact: Literal["all"] | None = Field(default=None, description="all: every contact touches the object")
    force_residual: Number | None = Field(
        default=None, gt=0.0, le=100.0, description="the norm of the net unit force (1) is below this"
    )
    moment_residual: Metres | None = Field(
        default=None, gt=0.0, le=0.5, description="the norm of the net moment of unit forces (m) is below this"
    )
    force_error: Annotated[Number, Unit("N")] | None = Field(
        default=None, gt=0.0, le=1000.0, description="every contact force is within this (N) of its reference"
    )
    hold: Seconds = Field(default=0.2, ge=0.0, le=600.0, description="how long the conditions must hold (s)")

    @model_validator(mode="after")
    def _some_condition(self) -> Until:
        conditions = (self.contact, self.force_residual, self.moment_residual, self.force_error)
        if all(condition is None for condition in conditions):
            hint = "for example {contact: all}, or {force_residual: 0.1, moment_residual: 0.005}"
            raise fault("missing-key", "'until' needs contact, force_residual, moment_residual or force_error", hint)
        return self


class Phase(Model):
    """One controller, run until its end or its time limit."""

    run: str = Field(min_length=1, description="the controller: a formula", examples=["π_s|Γ Γ (π_gx|Γ Γ)"])
    until: Until = Field(description="when the phase has reached its end", examples=[{"contact": "all"}])
    hysteresis: Number | None = Field(
        default=None,
        ge=1.0,
        le=1000.0,
        description="for 'a then b': go back to a when its residual exceeds its bound by this factor (1); else never",
    )
    limit: Seconds = Field(default=30.0, gt=0.0, le=600.0, description="time limit of the phase (s), up to 600")
    full_time: bool = Field(
        default=False,
        strict=True,
        description="whether the phase goes on to its limit though its end conditions hold, so that what is measured "
        "at its end does not depend on them; it has reached its end if they hold then",
    )


class Control(Growing):
    """How gradients become motion. A tick is one step of the control loop."""

    later: ClassVar = {"backend"}
    silent: ClassVar = "numpy"

    displacement: Literal["sliding", "probing"] = Field(
        default="sliding",
        description="how contacts get to another place; sliding: over the surface, a gradient step a tick; probing: "
        "lifted, moved and put down again, a gradient step a probe (Sec. 4.1.2)",
    )
    step: Metres | None = Field(
        default=None,
        gt=0.0,
        le=0.1,
        description="displacement (m) a tick or probe for a unit net force; by default a hundredth of the curvature "
        "radius sliding, and half of it over Σw², the weights of the contacts, for probes and floating contacts",
    )
    moment_gain: Number = Field(
        default=1.0, ge=0.0, le=1e6, description="factor (1) on the moment residual's part of the motion"
    )
    cap: Metres | None = Field(
        default=None,
        gt=0.0,
        le=0.1,
        description="largest displacement (m) of a contact a tick or probe; by default 0.015 curvature radii sliding, "
        "0.15 for probes and floating contacts",
    )
    admittance: Annotated[Number, Unit("m/N")] = Field(
        default=5e-5, ge=0.0, le=0.1, description="displacement for a unit of force error (m/N) a tick"
    )
    approach: Annotated[Number, Unit("m/s")] = Field(
        default=0.02, gt=0.0, le=1.0, description="speed (m/s) of a contact that does not touch yet"
    )
    nullspace: Literal["gradient", "task"] = Field(
        default="gradient",
        description="where lower priorities may act; gradient: normal to the higher gradients (Eq. 4.19), which "
        "protects one direction of each; task: the null space of the higher task Jacobians, which protects all of it",
    )
    inverse: Literal["pseudo-inverse", "transpose"] = Field(
        default="pseudo-inverse",
        description="what turns contact motion into joint motion, J⁺ of Eq. 4.20; pseudo-inverse: damped; "
        "transpose: Jᵀ/σ², σ the largest "
        "singular value of J; slow where joints move contacts little, and it presses: give it nullspace: task",
    )
    position_gain: Number = Field(
        default=1.0,
        gt=0.0,
        lt=2.0,
        description="K_p of Eq. 4.20 (1): share of a position or orientation error taken back a tick, by the transpose "
        "of the part that the joints move best; above 1 it overshoots, from 2 on it would grow",
    )
    damping: Number = Field(default=0.02, ge=0.0, le=10.0, description="damping (1) of the pseudo-inverse")
    posture_gain: Number = Field(
        default=0.05, gt=0.0, le=1.0, description="share (1) of the posture error that is taken back a tick"
    )
    surface: Literal["tangent", "spherical"] = Field(
        default="tangent",
        description="surface coordinates; tangent: local frames; spherical: the chapter's, Eq. 4.3 to 4.8",
    )
    virtual: Literal["members", "common"] = Field(
        default="members",
        description="how a virtual contact moves; members: each member by its own share; common: all alike",
    )
    virtual_forces: Literal["alike", "shared"] = Field(
        default="alike",
        description="what a force reference asks of a virtual contact; alike: each member presses with all of it, so "
        "that their mean is the reference (Eq. 4.32), and a thumb meets twice its force in two fingers; shared: each "
        "presses with its share, all together with the reference, so that opposed contacts balance",
    )
    origin: Literal["centroid", "object", "world"] = Field(
        default="centroid",
        description="the point moments are taken about; centroid: the mean of the contacts; object: the centre of mass "
        "of an object that is held or floats; world: the origin of the world",
    )
    curvature_radius: Metres = Field(
        default=0.05, gt=0.0, le=100.0, description="radius (m) of the object that the gradients assume"
    )
    backend: Literal["numpy", "jax", "casadi"] = Field(
        default="numpy",
        description="what evaluates a tick; numpy: each step by itself; jax: all steps compiled as one by JAX, on a "
        "GPU where there is one; casadi: steps compiled to formulas of numbers by CasADi, for few trials; numbers "
        "agree up to rounding",
    )
