"""Formulas in the default scene: checked, compiled, and ticked on observations in general position."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any

import numpy as np

from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.contracts.rule import Breach
from graspdsl.hands.descriptions import Robot, joint_limits
from graspdsl.worlds.protocol import Observation

CONTACTS, WITH_GRAVITY, JOINTS = "{γ1, γ2, γ3}", "{γ1, γ2, γ3, γ_g}", "flexion"
SEEDS = range(3)


def observations(robot: Robot) -> list[Observation]:
    """Contacts that all touch, joints within their ranges, the object held: the same for each run."""
    found = []
    for seed in SEEDS:
        seen = in_general_position(robot, seed)
        share = np.random.default_rng(seed).uniform(0.2, 0.8, len(robot.joints))
        lower, upper = (np.array(limits) for limits in joint_limits(robot))
        found.append(replace(seen, joints=lower + share * (upper - lower)))
    return found


def together(seen: list[Observation]) -> Observation:
    """Observations as one of many trials, (N, ...) each."""
    values: dict[str, Any] = {
        field.name: np.stack([getattr(one, field.name) for one in seen])
        for field in fields(Observation)
        if field.name != "time"
    }
    return replace(seen[0], **values)


def faulty_ticks(pipeline: Pipeline, robot: Robot, formula: str) -> Iterator[Breach]:
    """A tick gives a finite displacement, (n,) of the joints or (k, 3) of the contacts."""
    shape = (len(robot.joints),) if pipeline.space == GradientSpace.JOINTS.value else (len(robot.contacts), 3)
    for seen in observations(robot):
        displacement = pipeline.ticks(seen).displacement
        if displacement.shape != shape:
            yield f"{formula} commands {displacement.shape} numbers, not {shape}", "see what its parts give"
            return
        if not np.isfinite(displacement).all():
            yield f"{formula} commands numbers that are not finite", "mind divisors and roots that can be zero"
            return


def uneven_ticks(pipeline: Pipeline, robot: Robot, formula: str) -> Iterator[Breach]:
    """Trials side by side are commanded what each is by itself."""
    seen = observations(robot)
    side_by_side = pipeline.ticks(together(seen)).displacement
    alone = np.stack([pipeline.ticks(one).displacement for one in seen])
    if not np.allclose(side_by_side, alone, rtol=1e-9, atol=1e-12, equal_nan=True):
        yield f"{formula} commands trials side by side something else than one by one", "let leading axes be"
