"""What ``explain`` shows of a spec, or of a formula alone, is what its trials run."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
import pytest
from shipped import NAMES, SPECS

from graspdsl.compiler.explain import explained
from graspdsl.compiler.pipeline import Pipeline
from graspdsl.compiler.program import Program, program_of, program_of_expression
from graspdsl.trials.setup import trial_loop

from .specs import spec

FORMULAS = ("π_s|Γ Γ (π_gx|Γ Γ)", "π_gx|Γ Γ", "π_cstar|Γ Γ", "π_gθ|γ1 {γ1, γ_g}", "π_close|Γ Γ then π_sgx|Γ Γ")


def shipped(name: str, *overrides: str) -> Program:
    return program_of((SPECS / name).read_text("utf-8"), name, overrides)


def told(pipeline: Pipeline) -> list[dict[str, Any]]:
    """The steps of a pipeline that runs, as ``explain --json`` has them."""
    return [
        {
            "label": step.label,
            "about": step.about,
            "inputs": list(step.inputs),
            "constants": [np.asarray(value).tolist() for value in step.constants],
        }
        for step in pipeline.steps
    ]


def assert_what_runs_is_shown(program: Program) -> None:
    """Every step, number and space of the pipelines that the trial loop runs."""
    stages = trial_loop(program)._stages
    running = [[stage.pipeline for stage in stages if stage.phase == phase] for phase in range(len(program.phases))]
    for pipelines, explanation in zip(running, explained(program), strict=True):
        shown = json.loads(json.dumps(explanation.as_dict()))
        text = explanation.text()
        for pipeline, steps in zip(pipelines, shown["pipeline"], strict=True):
            kept = [{key: step[key] for key in ("label", "about", "inputs", "constants")} for step in steps]
            assert kept == told(pipeline)
            for step in pipeline.steps:
                assert step.label in text
                assert step.about in text
            assert f"{len(pipeline.steps)} steps" in text
        spaces = ["q" if space == "q" else "x" for space in shown["gradient_space"]]
        assert spaces == [pipeline.space for pipeline in pipelines]
        assert shown["rate"] == program.world.rate
        assert f"{program.world.rate:g} times a second" in text


@pytest.mark.parametrize("name", NAMES)
def test_a_spec_is_explained_as_it_runs(name: str) -> None:
    assert_what_runs_is_shown(shipped(name))


@pytest.mark.parametrize("formula", FORMULAS)
def test_a_formula_alone_is_explained_as_it_runs(formula: str) -> None:
    assert_what_runs_is_shown(program_of_expression(formula))


@pytest.mark.parametrize(
    ("formula", "scene", "control"),
    [
        ("π_s|Γ Γ (π_gx|Γ Γ)", "", ""),
        ("π_gx|Γ Γ", "", "displacement: probing"),
        ("π_gθ|γ1 {γ1, γ_g}", "world: bullet, object: {like: towel-roll, held: true}", ""),
    ],
)
def test_a_formula_alone_runs_as_in_the_spec_that_it_could_stand_in(formula: str, scene: str, control: str) -> None:
    """The scene that only it could run in: probed, or with the object held."""
    whole = program_of(spec(formula, control=control, **({"scene": scene} if scene else {})), "spec.yaml")
    alone = program_of_expression(formula)
    (stages,), (others,) = whole.pipelines(), alone.pipelines()
    assert [told(pipeline) for pipeline in stages] == [told(pipeline) for pipeline in others]


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("chapter/4_18_grasp.yaml", "k = 0.0833: 0.167 rad a tick for a unit net force"),
        ("compare/probing.yaml", "16.7 mm a probe for a unit net force"),
        ("compare/probing.yaml", "capped at 7.5 mm a probe"),
        ("compare/sliding.yaml", "0.5 mm a tick for a unit net force"),
        ("compare/sliding.yaml", "capped at 0.75 mm a tick"),
        ("compare/sliding.yaml", "admittance 5e-05 m/N a tick, capped at 0.0004 m a tick"),
        ("chapter/4_26_slide_with_posture.yaml", "0.05 of it a tick"),
        ("chapter/4_40_rotate.yaml", "capped at 0.015 rad a tick"),
    ],
)
def test_gains_are_printed(name: str, shown: str) -> None:
    """Half the step over Σw² and the curvature radius: 0.5 · 0.05 / 3 / 0.05 for three floating contacts."""
    assert shown in "\n".join(explanation.text() for explanation in explained(shipped(name)))


def test_probing_and_rotations_are_explained_as_they_are_carried_out() -> None:
    _, probed = explained(shipped("compare/probing.yaml"))
    assert [pipeline.space for pipeline in probed.pipelines] == ["x"]
    assert re.search(r"^runs as +φ_mr\|τ_mrx\(Γ\) σ_mr\(Γ\) ◁ φ_fr", probed.text(), re.M)
    _, turned = explained(shipped("chapter/4_40_rotate.yaml"))
    assert [pipeline.space for pipeline in turned.pipelines] == ["q"]
    assert re.search(r"^runs as +φ_r\|τ_r\(γ1\)", turned.text(), re.M)


def test_a_users_controller_is_shown_with_its_equation_and_what_it_is_for() -> None:
    own = {
        "π_mine|Γ Γ": '{is: π_inner|Γ Γ, equation: "7.1", about: a close of my own}',
        "π_inner|Γ Γ": '{is: π_close|Γ Γ, equation: "Platt 2002, Eq. 3"}',
    }
    (explanation,) = explained(program_of(spec("π_mine|Γ Γ", controllers=own), "spec.yaml"))
    text = explanation.text()
    assert "π_mine|Γ Γ ≡ π_inner|Γ Γ  (Eq. 7.1) a close of my own" in text
    assert "π_inner|Γ Γ ≡ π_close|Γ Γ  (Platt 2002, Eq. 3)" in text
    mine, inner, close = explanation.as_dict()["definitions"]
    assert (mine["equation"], mine["about"]) == ("7.1", "a close of my own")
    assert (inner["equation"], inner["about"]) == ("Platt 2002, Eq. 3", "")
    assert close["equation"] == "4.21"
