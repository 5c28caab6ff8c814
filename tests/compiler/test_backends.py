"""Backends: all compute what numpy does, of single ticks and of whole runs, and say what they cannot do."""

from __future__ import annotations

import sys
from collections.abc import Callable, Hashable
from dataclasses import fields, replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest
from shipped import NAMES, SPECS

from graspdsl.arrays import Array
from graspdsl.backends import BACKENDS, symbols
from graspdsl.basis.sensors import Sensor
from graspdsl.basis.spaces import NET_FORCE
from graspdsl.compiler.backend_check import unfit
from graspdsl.compiler.explain import explained
from graspdsl.compiler.general_position import in_general_position
from graspdsl.compiler.pipeline import Pipeline, Step, Ticks, fingerprint
from graspdsl.compiler.program import Program, missing_engine, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import Robot
from graspdsl.objects.surfaces.compiled import compiled as in_backend
from graspdsl.trials.identity import identities, versions
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.floating import FloatingWorld
from graspdsl.worlds.protocol import Command, Observation

from .observations import ROBOT, UPPER, compiled, observation, one_of
from .specs import floating

NUMPY, JAX, CASADI = (BACKENDS[name] for name in ("numpy", "jax", "casadi"))
COMPILERS = pytest.mark.parametrize("backend", ["jax", "casadi"])
AGREES = 1e-10
SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
FLOATING = ("chapter/4_18_grasp.yaml", "chapter/4_30_grasp_cartesian.yaml", "chapter/cstar.yaml")


def shipped(name: str, *overrides: str) -> Program:
    return program_of((SPECS / name).read_text("utf-8"), name, overrides, (SPECS / name).parent)


@cache
def pipelines() -> list[tuple[Robot, Pipeline]]:
    """All that are shipped, of those that do the same one, with what each drives."""
    programs = [shipped(name) for name in NAMES]
    found = [(one.robot, made) for one in programs for stages in one.pipelines() for made in stages]
    return list({(fingerprints(made), len(robot.joints)): (robot, made) for robot, made in found}.values())


def fingerprints(pipeline: Pipeline) -> Hashable:
    return tuple((fingerprint(step.function), step.inputs, step.reading) for step in pipeline.steps)


def assert_same(found: Ticks, expected: Ticks) -> None:
    for field in fields(Ticks):
        one, other = getattr(found, field.name), getattr(expected, field.name)
        assert (one.shape, one.dtype) == (other.shape, other.dtype), field.name
        np.testing.assert_allclose(one, other, rtol=AGREES, atol=AGREES, err_msg=field.name)


@pytest.mark.slow
def test_every_step_of_every_shipped_spec_agrees() -> None:
    """Of arrays of every shape it can be compiled; of those of one shape it is, for that takes its time."""
    traced, agreed = set[Any](), dict[str, tuple[Step, list[Array], Array]]()
    for robot, pipeline in pipelines():
        values = pipeline.values(in_general_position(robot))
        for step, value in zip(pipeline.steps, values, strict=True):
            given = [np.asarray(values[place]) for place in step.inputs]
            function = step.function.func if isinstance(step.function, partial) else step.function
            does = (called := str(function), *(np.shape(one) for one in (*step.constants, *given)))
            if step.reading is None and does not in traced:
                traced.add(does)
                assert JAX.refusal(step.function, *given) == "", step.label
                agreed.setdefault(called, (step, given, value))
    assert len(agreed) > 40

    def one_after_the_other(call: Callable[..., Array], *arrays: Array) -> tuple[Array, ...]:
        left = iter(arrays)
        return tuple(call(step.function, *(next(left) for _ in given)) for step, given, _ in agreed.values())

    found = JAX.compiled(one_after_the_other)((), *(array for _, given, _ in agreed.values() for array in given))
    for made, (step, _, value) in zip(found, agreed.values(), strict=True):
        np.testing.assert_allclose(made, value, rtol=AGREES, atol=AGREES, err_msg=step.label)


def degenerate(robot: Robot) -> list[Observation]:
    """In general position, with contacts away and joints beyond their limits, where all gradients vanish, where nothing
    moves a contact, and turned by half a turn with no contact at all."""
    seen, half = in_general_position(robot), np.zeros((len(robot.contacts), 3))
    half[:, 0] = np.pi
    away = np.arange(len(robot.contacts)) % 2 == 0
    return [
        seen,
        replace(seen, touching=away, joints=np.where(np.arange(len(robot.joints)) % 2, 50.0, -50.0)),
        replace(seen, points=0.0 * seen.points, normals=0.0 * seen.normals + [0.0, 0.0, 1.0]),
        replace(seen, forces=0.0 * seen.forces, jacobian=0.0 * seen.jacobian, orientations=0.0 * seen.orientations),
        replace(seen, orientations=half, touching=away & False),
    ]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:divide by zero", "ignore:invalid value")
def test_every_shipped_controller_agrees_wherever_it_is() -> None:
    """By CasADi, which takes little time to compile."""
    for robot, pipeline in pipelines():
        by_casadi = replace(pipeline, backend=CASADI)
        for seen in degenerate(robot):
            assert_same(by_casadi.ticks(seen), pipeline.ticks(seen))


@pytest.mark.parametrize(
    ("control", "largest", "left"),
    [
        ({}, symbols.LARGEST, []),
        ({"inverse": "transpose"}, symbols.LARGEST, ["Jᵀ/σ²"]),
        ({"nullspace": "task"}, symbols.LARGEST, ["N(τ φ_fr)", "N(τ φ_f)"]),
        ({}, 800, ["J⁺"]),
    ],
)
def test_steps_that_formulas_cannot_be_made_of_are_called(
    control: dict[str, str], largest: int, left: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Those that decompose matrices or take very many products, and no others, each tick anew."""
    pipeline, called = compiled(SLIDE, **control), list[str]()
    monkeypatch.setattr(symbols, "LARGEST", largest)

    def counted(step: Step) -> Step:
        def function(*arrays: Array) -> Array:
            called.append(step.label)
            return step.function(*arrays)

        return step if step.reading else replace(step, function=function)

    watched = replace(pipeline, steps=tuple(map(counted, pipeline.steps)), backend=CASADI)
    watched.ticks(observation(1))
    assert set(called) > set(left)
    called.clear()
    assert_same(watched.ticks(observation(2)), pipeline.ticks(observation(2)))
    assert called == left


# What anyone writes with numpy, of a vector (3,).
WRITABLE: tuple[Callable[[Any], Any], ...] = (
    lambda x: np.where(np.abs(x) < 0.1, x, 0.1 * np.sign(x)),
    lambda x: x * np.minimum(1.0, 0.1 / np.maximum(np.linalg.norm(x, axis=-1, keepdims=True), 1e-12)),
    lambda x: x - x.mean(axis=-1, keepdims=True) + np.tanh(x) + np.abs(x) ** 1.5,
    lambda x: np.where((x > 0.0) & ~(x < 0.5), x, 0.0) + (x > 0.0).astype(float) * np.any(x[:1]),
    lambda x: np.where(np.array([True, False, True]), x, -x) + np.round(10.0 * x),
    lambda x: np.take_along_axis(x, x.argmax(axis=-1)[..., None], axis=-1) * np.ones_like(x),
    lambda x: np.einsum("ij,jk->ki", x[:, None] * x, np.arange(9.0).reshape(3, 3)) @ x + x @ np.eye(3),
    lambda x: np.stack([part * part for part in x]) + np.roll(x, 1) + x[[2, 0, 1]] + x.T,
    lambda x: np.pad(x, ((1, 0),)) + np.concatenate([np.zeros_like(x), x[:1]]),
    lambda x: (x[:, None] * x > 0.02) | (np.add.reduce(x) > 0.0),
)
CALLED: tuple[Callable[[Any], Any], ...] = (
    lambda x: x if x[0] > 0.0 else -x,
    lambda x: float(x[0]) * x,
    lambda x: (x > 0.0).sum() * x,
    lambda x: (x[:1] > 0.0).sum() * x,
    lambda x: ((x > 0.0) * (x < 1.0)) * x,
    lambda x: np.asarray(x) + 1.0,
    lambda x: np.array([x[0], x[1]]),
    lambda x: x[np.argmax(x, axis=-1)],
    lambda x: x % 0.3,
    lambda x: np.linalg.inv(np.eye(3) + x[:, None] * x),
    lambda x: np.linalg.trace(np.stack([x[:, None] * x] * 2)),
    lambda x: np.einsum("i,i", x, x),
    lambda x: np.pad(x, 1, constant_values=3.0),
    lambda x: x.astype(np.float32),
    lambda x: x.max(initial=0.2),
    lambda x: np.take_along_axis(x, np.array([0, 2]), axis=0),
    lambda x: np.add.outer(x, x),
    lambda x: x.std(),
)


@pytest.mark.parametrize("function", [*WRITABLE, *CALLED])
def test_functions_of_numpy_become_formulas_or_are_called(function: Callable[[Any], Any]) -> None:
    seen = list[Array]()

    def step(x: Array) -> Array:
        seen.append(x)
        made: Array = function(x)
        return made

    by_casadi = CASADI.compiled(lambda call, x: (call(step, x),))
    by_casadi((), np.ones(3))
    for given in (np.array([0.3, -0.2, 0.7]), np.array([-0.3, 0.6, 0.05]), np.zeros(3)):
        seen.clear()
        expected, (found,) = np.asarray(function(given)), by_casadi((), given)
        assert (len(seen) == 0) == (function in WRITABLE)
        assert (found.shape, found.dtype) == (expected.shape, expected.dtype)
        np.testing.assert_allclose(found, expected, rtol=1e-14, atol=1e-15)


@pytest.mark.slow
@COMPILERS
@pytest.mark.parametrize(
    ("formula", "control"),
    [(SLIDE, {}), ("π_g|Γ Γ", {"surface": "spherical", "nullspace": "task"})],
)
def test_ticks_agree(backend: str, formula: str, control: dict[str, str]) -> None:
    """Of one trial, of many, and of fewer, of which nothing new is compiled; at the limits of joints, too."""
    expected, found = (replace(compiled(formula, **control), backend=BACKENDS[name]) for name in ("numpy", backend))
    seen = observation(3, 6)
    seen.joints[1:3] = UPPER
    seen.touching[4, 0] = False
    whole = found.ticks(seen)
    assert_same(whole, expected.ticks(seen))
    if formula == SLIDE:
        assert whole.locked.any()
        alone = found.ticks(one_of(seen, 0))
        assert_same(alone, expected.ticks(one_of(seen, 0)))
        if backend == "casadi":
            assert not alone.locked.any()
            assert all((getattr(alone, one.name) == getattr(whole, one.name)[0]).all() for one in fields(Ticks))
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
    np.testing.assert_allclose(ends, [ends[0]] * len(BACKENDS), atol=AGREES)
    assert np.abs(ends[0] - start).max() > 1e-3


@pytest.mark.slow
def test_a_trial_in_an_engine_agrees_until_contacts_magnify_rounding() -> None:
    """Closing, and the first fifth of a second of sliding."""
    settings = ("scene.world=mujoco", "program.1.limit=0.2", "evaluate=[]")
    one, other = (
        trial_loop(shipped("towel_roll_two_contacts.yaml", *settings, f"control.backend={name}")).run(0, 5)
        for name in ("numpy", "casadi")
    )
    assert one.trajectory["phase"].max() == 1
    np.testing.assert_array_equal(other.trajectory["phase"], one.trajectory["phase"])
    np.testing.assert_allclose(other.trajectory["joints"], one.trajectory["joints"], atol=1e-6)


def program(control: str) -> Program:
    return program_of(floating(control=control), "test.yaml")


@COMPILERS
def test_the_backend_is_one_of_those_there_are_and_is_told(backend: str) -> None:
    with pytest.raises(DiagnosticError, match="expected numpy, jax or casadi, found the text 'torch'"):
        program("backend: torch")
    (explanation,) = explained(program(f"backend: {backend}"))
    assert f"contacts float; {BACKENDS[backend].about} by {backend}" in explanation.text()
    assert explanation.as_dict()["backend"] == backend
    assert "compiled" not in explained(program(""))[0].text().partition("definitions")[0]


@COMPILERS
def test_identities_and_versions_name_the_backend(backend: str) -> None:
    """Those of numpy are as they were before there was another."""
    usual, said, other = program(""), program("backend: numpy"), program(f"backend: {backend}")
    assert versions(other).keys() - versions(usual).keys() == set(BACKENDS[backend].libraries) > set()
    assert "backend" not in usual.spec.model_dump(mode="json")["control"]
    of_usual, of_said, of_other = (identities(one, 0)(0) for one in (usual, said, other))
    assert of_usual == of_said != of_other


@COMPILERS
def test_a_backend_that_is_not_installed_is_refused_at_its_place(backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    asked = program(f"backend: {backend}")
    assert missing_engine(asked) is None
    monkeypatch.setitem(sys.modules, backend, None)
    missing = missing_engine(asked)
    assert missing is not None
    assert (missing.code, missing.span and missing.span.line) == ("engine-missing", 10)
    assert missing.message == f"the {backend} backend needs {backend}, which this Python has not"
    assert missing.hint == f"pip install 'graspdsl[{backend}]'; or leave backend out"
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
    assert unfit(NUMPY, [[replace(pipeline, steps=steps)]], ROBOT) is None
    assert unfit(CASADI, [[replace(pipeline, steps=steps)]], ROBOT) is None
    seen, foreign = observation(3), replace(pipeline, steps=steps, backend=CASADI)
    assert_same(foreign.ticks(seen), replace(foreign, backend=NUMPY).ticks(seen))
