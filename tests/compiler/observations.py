"""Random observations of the Barrett hand, and pipelines of formulas in the default scene."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from graspdsl.arrays import Array
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import examine_expression, program_of_expression
from graspdsl.spec.program import Control
from graspdsl.worlds.protocol import Observation

TARGET = program_of_expression("π_close|Γ Γ").target
ROBOT = TARGET.robot
CONTACTS, JOINTS = len(ROBOT.contacts), len(ROBOT.joints)
THUMB, FIRST, SECOND = (ROBOT.contacts.index(name) for name in ("finger-3", "finger-1", "finger-2"))
WEIGHTS = np.array(ROBOT.weights)
LOWER, UPPER = TARGET.limits


def observation(seed: int = 7, *batch: int) -> Observation:
    """Contacts that all touch, at random places, with random Jacobians."""
    random = np.random.default_rng(seed)
    normals = random.normal(size=(*batch, CONTACTS, 3))
    return Observation(
        time=0.0,
        points=random.normal(scale=0.05, size=(*batch, CONTACTS, 3)),
        normals=normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        forces=random.normal(size=(*batch, CONTACTS, 3)),
        touching=np.ones((*batch, CONTACTS), dtype=bool),
        joints=random.uniform(0.1, 0.9, size=(*batch, JOINTS)) * (UPPER - LOWER) + LOWER,
        jacobian=random.normal(scale=0.1, size=(*batch, CONTACTS, 3, JOINTS)),
        angular_jacobian=random.normal(size=(*batch, CONTACTS, 3, JOINTS)),
        orientations=random.normal(size=(*batch, CONTACTS, 3)),
        centre_of_mass=random.normal(scale=0.05, size=(*batch, 3)),
        weight=np.broadcast_to([0.0, 0.0, -random.uniform(1.0, 9.0)], (*batch, 3)).copy(),
    )


def one_of(batch: Observation, index: int) -> Observation:
    """One observation of a batch."""
    names = [field.name for field in fields(Observation) if field.name != "time"]
    return replace(batch, **{name: getattr(batch, name)[index] for name in names})


def rotated(seen: Observation, rotation: Array) -> Observation:
    """The same as seen from a world frame that is turned about its origin."""
    turn = Rotation.from_matrix(rotation)
    return replace(
        seen,
        points=seen.points @ rotation.T,
        normals=seen.normals @ rotation.T,
        forces=seen.forces @ rotation.T,
        jacobian=np.einsum("ij,kjn->kin", rotation, seen.jacobian),
        angular_jacobian=np.einsum("ij,kjn->kin", rotation, seen.angular_jacobian),
        orientations=(turn * Rotation.from_rotvec(seen.orientations)).as_rotvec(),
        centre_of_mass=seen.centre_of_mass @ rotation.T,
        weight=seen.weight @ rotation.T,
    )


def compiled(formula: str, **control: Any) -> Pipeline:
    """The pipeline of a formula in the default scene, which has γ1, γ2, γ3, Γ = {γ1, <γ2, γ3>} and κ_f."""
    phase, robot = examine_expression(formula)
    (graph,) = phase.stages
    return compile_controller(graph, phase.grasp, replace(TARGET, robot=robot, control=Control(**control)))


def command(formula: str, seen: Observation, **control: Any) -> Array:
    """The displacement that a formula makes of an observation."""
    return compiled(formula, **control).evaluate(seen).command.displacement
