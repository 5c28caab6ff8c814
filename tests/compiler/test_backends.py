"""Backends: JAX computes what numpy does, of single ticks and of whole runs, and says what it cannot do."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from shipped import NAMES, SPECS

from graspdsl.arrays import Array
from graspdsl.backends import BACKENDS
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import NET_FORCE
from graspdsl.compiler.backend_check import unfit
from graspdsl.compiler.explain import explained
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.pipeline import Ticks
from graspdsl.compiler.program import Program, missing_engine, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.objects.surfaces.compiled import compiled as in_backend
from graspdsl.trials.identity import identities, versions
from graspdsl.worlds.floating import FloatingWorld
from graspdsl.worlds.protocol import Command

from .observations import ROBOT, UPPER, compiled, observation, one_of
from .specs import floating

JAX = BACKENDS["jax"]
AGREES = 1e-10
SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
FLOATING = ("chapter/4_18_grasp.yaml", "chapter/4_30_grasp_cartesian.yaml", "chapter/cstar.yaml")


def shipped(name: str) -> Program:
    return program_of((SPECS / name).read_text("utf-8"), name, (), (SPECS / name).parent)


def assert_same(found: Ticks, expected: Ticks) -> None:
    for field in fields(Ticks):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        assert (one.shape, one.dtype) == (other.shape, other.dtype), field.name
        np.testing.assert_allclose(one, other, rtol=AGREES, atol=AGREES, err_msg=field.name)


@pytest.mark.slow
def test_every_step_of_every_shipped_spec_agrees() -> None:
    """Of arrays of every shape it can be compiled; of those of one shape it is, for that takes its time."""
    traced, agreed = set[Any](), set[str]()
    for name in NAMES:
        program = shipped(name)
        at = in_general_position(program.robot)
        for pipeline in (made for stages in program.pipelines() for made in stages):
            values = pipeline.values(at)
            for step, value in zip(pipeline.steps, values, strict=True):
                given = [np.asarray(values[place]) for place in step.inputs]
                function = step.function.func if isinstance(step.function, partial) else step.function
                does = (called := str(function), *(np.shape(one) for one in (*step.constants, *given)))
                if step.reading is None and does not in traced:
                    traced.add(does)
                    assert JAX.refusal(step.function, *given) == "", step.label
                if step.reading is None and called not in agreed:
                    agreed.add(called)
                    (found,) = JAX.compiled(_Whole(step.function))((), *given)
                    np.testing.assert_allclose(found, value, rtol=AGREES, atol=AGREES, err_msg=step.label)
    assert len(agreed) > 40


class _Whole:
    """A step as a function of its own."""

    def __init__(self, function: Callable[..., Array]) -> None:
        self._function = JAX.own(function)

    def __call__(self, *arrays: Array) -> tuple[Array]:
        return (self._function(*arrays),)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formula", "control"),
    [(SLIDE, {}), ("π_g|Γ Γ", {"surface": "spherical", "nullspace": "task"})],
)
def test_ticks_agree(formula: str, control: dict[str, str]) -> None:
    """Of one trial, of many, and of fewer, of which nothing new is compiled; at the limits of joints, too."""
    expected, found = (compiled(formula, **control, backend=name) for name in ("numpy", "jax"))
    seen = observation(3, 6)
    seen.joints[1:3] = UPPER
    seen.touching[4, 0] = False
    whole = found.ticks(seen)
    assert_same(whole, expected.ticks(seen))
    if formula == SLIDE:
        assert whole.locked.any()
        assert_same(found.ticks(one_of(seen, 1)), expected.ticks(one_of(seen, 1)))
    few = replace(
        seen, **{field.name: getattr(seen, field.name)[2:5] for field in fields(seen) if field.name != "time"}
    )
    assert_same(found.ticks(few), expected.ticks(few))


SURFACES = (
    "ellipsoid: {size: [0.08, 0.1, 0.14]}",
    "superquadric: {size: [0.08, 0.1, 0.14], exponent: 3.5}",
    "sphere: {diameter: 0.1}",
    "bottle: {diameter: 0.08, height: 0.2, body_height: 0.12, neck_diameter: 0.03, neck_height: 0.04, "
    "shoulder: 0.02, edge: 0.005}",
)


@pytest.mark.slow
@pytest.mark.parametrize("shape", SURFACES)
def test_contacts_slide_over_every_surface_alike(shape: str) -> None:
    surface = program_of(floating(scene=f"object: {{{shape}}}"), "test.yaml").body.shape.surface()
    random = np.random.default_rng(3)
    points = surface.sample(60, random).reshape(20, 3, 3)
    astray = points + random.normal(scale=0.004, size=points.shape)
    other = in_backend(surface, JAX)
    np.testing.assert_allclose(other.normals(astray), surface.normals(astray), atol=AGREES)
    np.testing.assert_allclose(other.retract(astray), surface.retract(astray), atol=AGREES)


@pytest.mark.slow
@pytest.mark.parametrize("name", FLOATING)
def test_whole_runs_of_floating_contacts_agree(name: str) -> None:
    """Of all controllers in turn, 60 ticks each, wherever their phases would end."""
    program = shipped(name)
    surface, names = program.body.shape.surface(), program.robot.contacts
    start = surface.sample(8 * len(names), np.random.default_rng(5)).reshape(8, len(names), 3)
    ends = []
    for backend in BACKENDS.values():
        world = FloatingWorld(names, in_backend(surface, backend), 1.0)
        world.place(start)
        seen = world.observe()
        for pipeline in (made for stages in program.pipelines() for made in stages):
            runs = replace(pipeline, backend=backend)
            for _ in range(60):
                seen = world.step(Command(runs.space, runs.ticks(seen).displacement))
        ends.append(seen.points)
    np.testing.assert_allclose(ends[1], ends[0], atol=AGREES)
    assert np.abs(ends[0] - start).max() > 1e-3


def program(control: str = "backend: jax") -> Program:
    return program_of(floating(control=control), "test.yaml")


def test_the_backend_is_one_of_those_there_are_and_is_told() -> None:
    with pytest.raises(DiagnosticError, match="expected numpy or jax, found the text 'torch'"):
        program("backend: torch")
    (explanation,) = explained(program())
    assert "contacts float; all steps compiled as one by jax" in explanation.text()
    assert explanation.as_dict()["backend"] == "jax"
    assert "compiled" not in explained(program(""))[0].text().partition("definitions")[0]


def test_identities_and_versions_name_the_backend() -> None:
    """Those of numpy are as they were before there was another."""
    usual, said, other = program(""), program("backend: numpy"), program()
    assert versions(other).keys() - versions(usual).keys() == {"jax", "jaxlib"}
    assert "backend" not in usual.spec.model_dump(mode="json")["control"]
    of_usual, of_said, of_other = (identities(one, 0)(0) for one in (usual, said, other))
    assert of_usual == of_said != of_other


def test_a_backend_that_is_not_installed_is_refused_at_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    assert missing_engine(program()) is None
    monkeypatch.setitem(sys.modules, "jax", None)
    missing = missing_engine(program())
    assert missing is not None
    assert (missing.code, missing.span and missing.span.line) == ("engine-missing", 10)
    assert missing.message == "the jax backend needs jax, which this Python has not"
    assert missing.hint == "pip install 'graspdsl[jax]'; or leave backend out"
    assert missing_engine(program("backend: numpy")) is None


class Doubled(Sensor):
    """σ_d: twice the net force, in the way of numpy alone, (..., 3) [1] (Eq. 4.11)."""

    symbol = "σ_d"
    about = "twice the net force"
    equation = "4.11"
    space = NET_FORCE
    reads = ("normals",)
    per_contact = False

    def evaluate(self, mixing: Array, *inputs: Array) -> Array:
        """2 Σ w n, shape (..., 3)."""
        (normals,) = inputs
        return np.asarray(np.einsum("k,...kj->...j", 2.0 * mixing, normals))


def test_a_step_of_numpy_alone_is_refused_by_name() -> None:
    pipeline = compiled("π_fr|Γ Γ")
    steps = tuple(
        replace(step, function=partial(Doubled().evaluate, *step.constants)) if step.label == "σ_fr(Γ)" else step
        for step in pipeline.steps
    )
    refused = unfit(JAX, [[replace(pipeline, steps=steps)]], ROBOT)
    assert refused is not None
    assert refused.code == "numpy-alone"
    assert refused.message.startswith(
        "σ_fr(Γ), net force of unit contact forces, Eq. 4.11, cannot be compiled by jax: "
    )
    assert unfit(JAX, [[pipeline]], ROBOT) is None
    assert unfit(BACKENDS["numpy"], [[replace(pipeline, steps=steps)]], ROBOT) is None
