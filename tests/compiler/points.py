"""Graphs and pipelines over many contacts: the points hand, whatever its world can carry out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from graspdsl.basis.prelude import prelude
from graspdsl.compiler.check import Checker
from graspdsl.compiler.complaints import Complaints
from graspdsl.compiler.declarations import Declaration
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.resources import ResourceTable
from graspdsl.diagnostics import DiagnosticError, SourceText
from graspdsl.hands.descriptions import robot
from graspdsl.notation.parser import parse_expression, parse_resources
from graspdsl.spec.program import Control
from graspdsl.worlds.protocol import Observation

from .observations import TARGET

POINTS = robot("points", "gantry")
COUNT, JOINTS = len(POINTS.contacts), len(POINTS.joints)
GRASP_MEMBERS = ["γ1", "<γ2, γ3>", "γ4", "γ5"]
GRASP = f"{{{', '.join(GRASP_MEMBERS)}}}"


def over_points(formula: str, **control: Any) -> Pipeline:
    """The pipeline of a formula over γ1 to γ8; Γ is five of them, two of which are a virtual contact."""
    complaints = Complaints()
    names = {**{f"γ{i + 1}": name for i, name in enumerate(POINTS.contacts)}, "Γ": GRASP}
    entries = [Declaration(SourceText.of(name), SourceText.of(meaning), ()) for name, meaning in names.items()]
    table = ResourceTable(entries, POINTS, complaints, senses_gravity=True)
    checker = Checker(table, prelude(), {}, complaints)
    stages = checker.stages(parse_expression(SourceText.of(formula)))
    if complaints.found or stages is None:
        raise DiagnosticError(complaints.found)
    (stage,) = stages
    grasp = table.resolve(parse_resources(SourceText.of(GRASP)))
    assert grasp is not None
    target = replace(TARGET, robot=POINTS, control=Control(**control))
    return compile_controller(stage, grasp, target)


def of_points(seed: int) -> Observation:
    """Eight contacts that touch, at random places, on six joints of a wrist."""
    random = np.random.default_rng(seed)
    normals = random.normal(size=(COUNT, 3))
    return Observation(
        time=0.0,
        points=random.normal(scale=0.05, size=(COUNT, 3)),
        normals=normals / np.linalg.norm(normals, axis=-1, keepdims=True),
        forces=random.normal(size=(COUNT, 3)),
        touching=np.ones(COUNT, dtype=bool),
        joints=random.normal(size=JOINTS),
        jacobian=random.normal(scale=0.1, size=(COUNT, 3, JOINTS)),
        angular_jacobian=random.normal(size=(COUNT, 3, JOINTS)),
        orientations=random.normal(size=(COUNT, 3)),
        centre_of_mass=random.normal(scale=0.05, size=3),
        weight=np.array([0.0, 0.0, -5.0]),
    )
