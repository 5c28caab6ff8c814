"""From graph to numbers: the command against a computation of its own, and what every pipeline keeps to."""

from __future__ import annotations

from dataclasses import astuple
from functools import partial
from itertools import combinations, product
from typing import Any

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.compiler.pipeline import Step
from graspdsl.spec.program import Control
from graspdsl.worlds.protocol import Observation

from .observations import (
    CONTACTS,
    FIRST,
    JOINTS,
    SECOND,
    TARGET,
    THUMB,
    WEIGHTS,
    command,
    compiled,
    observation,
    one_of,
)

SLIDE = "π_s|Γ Γ (π_gx|Γ Γ)"
FORMS = [
    {"nullspace": nullspace, "inverse": inverse, "virtual": virtual, "origin": origin}
    for nullspace, inverse, virtual, origin in product(
        ("task", "gradient"), ("pseudo-inverse", "transpose"), ("members", "common"), ("centroid", "world")
    )
]
EACH_FORM = pytest.mark.parametrize("form", FORMS, ids=lambda form: "-".join(form.values()))

SHARE = np.zeros(CONTACTS)
SHARE[[THUMB, FIRST, SECOND]] = 1.0, 0.5, 0.5
MEAN = np.zeros((2, CONTACTS))
MEAN[0, THUMB], MEAN[1, [FIRST, SECOND]] = 1.0, 0.5
EACH = np.eye(CONTACTS)[[THUMB, FIRST, SECOND]]


def null_space(jacobian: Array) -> Array:
    """I − J⁺J."""
    projector: Array = np.eye(jacobian.shape[1]) - np.linalg.pinv(jacobian) @ jacobian
    return projector


def settled(**settings: Any) -> Control:
    """Control settings with the step and the cap that sliding has by default: 1 % and 1.5 % of the curvature radius."""
    radius = Control(**settings).curvature_radius
    return Control(**{"step": 0.01 * radius, "cap": 0.015 * radius, **settings})


def no_further_than(cap: float, step: Array) -> Array:
    """All displacements (k, 3) shortened alike so that none is longer than the cap."""
    shortened: Array = step / max(1.0, np.linalg.norm(step, axis=1).max() / cap)
    return shortened


def grasp_step(seen: Observation, control: Control) -> Array:
    """π_gx|Γ Γ for Γ = {γ1, <γ2, γ3>}: the displacement of each contact, (k, 3), however long."""
    normals, radius = seen.normals, control.curvature_radius
    assert control.step is not None
    centre = SHARE @ seen.points / SHARE.sum() if control.origin == "centroid" else np.zeros(3)
    force = SHARE @ normals
    moment = SHARE @ np.cross(seen.points - centre, normals)
    tangent = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    by_contact = [-SHARE[:, None, None] * block for block in (tangent / radius, np.cross(normals[:, None], np.eye(3)))]
    by_contact[1] = np.swapaxes(by_contact[1], 1, 2)  # rows of cross(n, I) are the columns of [n]×
    if control.virtual == "common":
        for block in by_contact:
            block[[FIRST, SECOND]] = block[FIRST] + block[SECOND]
    force_task, moment_task = (np.hstack(list(block)) for block in by_contact)
    down_force = -control.step * radius * force_task.T @ force
    down_moment = -control.step * control.moment_gain / radius * moment_task.T @ moment
    above = force_task if control.nullspace == "task" else down_force[None]
    step: Array = (down_force + null_space(above) @ down_moment).reshape(-1, 3)
    return step


def slide_step(seen: Observation, control: Control, pressure: float) -> Array:
    """π_s|Γ Γ (π_gx|Γ Γ) for contacts that all touch: the displacement of each joint, (n,)."""
    rows = EACH if control.virtual == "members" else MEAN
    assert control.cap is not None
    step = no_further_than(control.cap, grasp_step(seen, control))
    jacobian = seen.jacobian * WEIGHTS
    position_task = np.einsum("rk,kin->rin", rows, jacobian).reshape(-1, JOINTS)
    gram = position_task @ position_task.T
    inverse = position_task.T / np.linalg.eigvalsh(gram).max()
    if control.inverse == "pseudo-inverse":
        inverse = position_task.T @ np.linalg.inv(gram + control.damping**2 * np.eye(3 * len(rows)))
    along = control.position_gain * inverse @ (rows @ step).ravel()
    outer = seen.normals[:, :, None] * seen.normals[:, None, :]
    force_task = np.einsum("rk,kij,kjn->rin", rows, outer, jacobian).reshape(-1, JOINTS)
    error = rows @ (pressure * seen.normals - np.einsum("kij,kj->ki", outer, seen.forces))
    press = control.admittance * error
    press = press / np.maximum(1.0, np.linalg.norm(press, axis=1, keepdims=True) / (control.approach / TARGET.rate))
    into = force_task.T @ press.ravel()
    above = force_task if control.nullspace == "task" else into[None]
    displacement: Array = WEIGHTS * (into + null_space(above) @ along)
    return displacement


@EACH_FORM
def test_grasp_step(form: dict[str, str]) -> None:
    control = settled(**form)
    assert control.cap is not None
    for seed in range(5):
        seen = observation(seed)
        whole = grasp_step(seen, control)
        found = command("π_gx|Γ Γ", seen, cap=0.1, **form)
        np.testing.assert_allclose(found, whole, rtol=1e-9, atol=1e-15)
        found = command("π_gx|Γ Γ", seen, **form)
        np.testing.assert_allclose(found, no_further_than(control.cap, whole), rtol=1e-9, atol=1e-15)
        longest = np.linalg.norm(whole, axis=1).max()
        found = command("π_gx|Γ Γ", seen, cap=longest / 3, **form)
        np.testing.assert_allclose(found, whole / 3, rtol=1e-9, atol=1e-15)


@EACH_FORM
def test_slide_step(form: dict[str, str]) -> None:
    control = settled(**form)
    for seed in range(5):
        seen = observation(seed)
        np.testing.assert_allclose(command(SLIDE, seen, **form), slide_step(seen, control, 0.5), rtol=1e-8, atol=1e-13)


@pytest.mark.parametrize(
    "settings",
    [
        {"step": 0.01, "cap": 1e-4},
        {"moment_gain": 7.0, "curvature_radius": 0.3, "cap": 0.1},
        {"admittance": 0.1, "approach": 0.005},
        {"damping": 1.0},
        {"position_gain": 0.3},
        {"position_gain": 1.7, "inverse": "transpose"},
    ],
)
def test_slide_step_under_other_settings(settings: dict[str, float]) -> None:
    seen = observation()
    expected = slide_step(seen, settled(**settings), 0.5)
    np.testing.assert_allclose(command(SLIDE, seen, **settings), expected, rtol=1e-8, atol=1e-13)


@pytest.mark.parametrize("nullspace", ["task", "gradient"])
def test_surface_step_is_the_grasp_step_in_tangent_frames(nullspace: str) -> None:
    seen = observation()
    for cap in (0.1, 5e-4):
        settings = {"nullspace": nullspace, "curvature_radius": 0.08, "cap": cap}
        over_surface = compiled("π_g|Γ Γ", **settings).evaluate(seen).command
        assert (over_surface.space, over_surface.displacement.shape) == ("x", (CONTACTS, 3))
        expected = command("π_gx|Γ Γ", seen, **settings)
        np.testing.assert_allclose(over_surface.displacement, expected, rtol=1e-9, atol=1e-15)
        longest = np.linalg.norm(expected, axis=1).max()
        assert longest == pytest.approx(cap) if cap < 0.1 else longest < cap


def test_unit_net_force_moves_a_contact_by_a_step() -> None:
    seen = observation()
    found = command("φ_fr|τ_frx(γ1) σ_fr(γ2)", seen, step=0.003, cap=0.1)
    across = seen.normals[FIRST] - seen.normals[FIRST] @ seen.normals[THUMB] * seen.normals[THUMB]
    np.testing.assert_allclose(found[THUMB], 0.003 * across, atol=1e-15)
    np.testing.assert_array_equal(found[[FIRST, SECOND]], 0.0)


def test_rows_may_be_named_in_any_order() -> None:
    seen, reference = observation(), "(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)"
    one = command(f"φ_p|τ_p({{γ1, γ2}}) σ_p({{γ1, γ2}}) {reference}", seen)
    other = command(f"φ_p|τ_p({{γ2, γ1}}) σ_p({{γ1, γ2}}) {reference}", seen)
    np.testing.assert_allclose(one, other, atol=1e-15)


@pytest.mark.parametrize("virtual", ["members", "common"])
def test_vector_reference_is_of_the_mean_of_a_virtual_contact(virtual: str) -> None:
    """Contacts whose means are where they should be stay; both forms move the means alike otherwise."""
    seen = observation()
    here = (MEAN @ seen.points).ravel()
    at_rest, shifted = (
        command(
            f"φ_p|τ_p(Γ) σ_p(Γ) ({', '.join(map(repr, where.tolist()))})", seen, virtual=virtual, damping=1e-4, cap=0.1
        )
        for where in (here, here + 0.01)
    )
    np.testing.assert_allclose(at_rest, 0.0, atol=1e-12)
    moved = MEAN @ np.einsum("kin,n->ki", seen.jacobian, shifted)
    np.testing.assert_allclose(moved, 0.01, rtol=1e-3)


@pytest.mark.parametrize("virtual", ["members", "common"])
@pytest.mark.parametrize(("transform", "cap"), [("p", 7.5e-4), ("r", 7.5e-4 / 0.05)])
def test_far_references_are_approached_in_steps_of_the_cap(transform: str, cap: float, virtual: str) -> None:
    """In metres or, for orientations, in radians: metres over the curvature radius."""
    seen, settings = observation(), {"virtual": virtual, "damping": 1e-5}
    jacobian = seen.jacobian if transform == "p" else seen.angular_jacobian
    step = command(f"φ_{transform}|τ_{transform}(Γ) σ_{transform}(Γ) (1, 2, 3, -2, -1, 0)", seen, **settings)
    moved = jacobian @ step
    rows = moved if virtual == "members" else MEAN @ moved
    np.testing.assert_allclose(np.linalg.norm(rows, axis=1).max(), cap, rtol=1e-4)


@EACH_FORM
def test_batch_gives_what_its_members_give(form: dict[str, str]) -> None:
    pipeline = compiled(SLIDE, **form)
    batch = observation(3, 4)
    batch.touching[1, THUMB] = False
    values = pipeline.values(batch)
    outputs = [pipeline.command, pipeline.force_residual, pipeline.moment_residual]
    outputs += [step for one in pipeline.priorities for step in (one.rank, one.sensed, one.effect, one.alone)]
    for index in range(4):
        one = pipeline.values(one_of(batch, index))
        for output in outputs:
            np.testing.assert_allclose(values[output][index], one[output], rtol=1e-7, atol=1e-12)


def test_tick_reports_the_residuals_of_the_grasp() -> None:
    seen = observation()
    tick = compiled(SLIDE).evaluate(seen)
    centre = SHARE @ seen.points / SHARE.sum()
    np.testing.assert_allclose(tick.force_residual, SHARE @ seen.normals, atol=1e-15)
    np.testing.assert_allclose(tick.moment_residual, SHARE @ np.cross(seen.points - centre, seen.normals), atol=1e-15)


@pytest.mark.parametrize("virtual", ["members", "common"])
def test_tick_reports_the_largest_distance_of_a_force_from_its_reference(virtual: str) -> None:
    seen = observation()
    pressed = np.sum(seen.forces * seen.normals, axis=-1, keepdims=True) * seen.normals
    rows = EACH if virtual == "members" else MEAN
    expected = np.linalg.norm(rows @ (0.5 * seen.normals - pressed), axis=-1).max()
    for formula in ("π_close|Γ Γ", SLIDE):
        assert compiled(formula, virtual=virtual).evaluate(seen).force_error == pytest.approx(expected)
    assert np.isnan(compiled("π_gx|Γ Γ", virtual=virtual).evaluate(seen).force_error)


# --- sharing ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("formula", [SLIDE, "π_sgx|Γ Γ", "π_gx|γ1 Γ", "π_g|Γ Γ", "π_close|Γ Γ ◁ π_close|γ1 γ1"])
def test_nothing_is_computed_twice_or_in_vain(formula: str) -> None:
    pipeline = compiled(formula)
    readings = [step.reading for step in pipeline.steps if step.reading]
    assert len(set(readings)) == len(readings)
    values = pipeline.values(observation())
    for (one, a), (other, b) in combinations(zip(pipeline.steps[: pipeline.bare], values, strict=False), 2):
        if np.any(a) and _function(one) == _function(other):
            assert a.shape != b.shape or not np.array_equal(a, b), f"{one.label} = {other.label}"
    used = {place for step in pipeline.steps for place in step.inputs}
    outputs = {pipeline.command, pipeline.force_residual, pipeline.moment_residual}
    for one in pipeline.priorities:
        outputs |= {one.rank, one.sensed, one.effect, one.alone, one.shortened}
    outputs |= set(astuple(pipeline.certificate)) if pipeline.certificate else set()
    outputs |= set() if pipeline.force_error is None else {pipeline.force_error}
    assert used | outputs == set(range(len(pipeline.steps)))


def _function(step: Step) -> str:
    function = step.function.func if isinstance(step.function, partial) else step.function
    return getattr(function, "__qualname__", repr(function))


@pytest.mark.parametrize("label", ["σ_p(Γ)", "σ_n(Γ)", "σ_f(Γ)", "σ_fr(Γ)", "σ_mr(Γ)", "τ_p(Γ)", "τ_f(Γ)", "J", "c"])
def test_each_transform_is_evaluated_once(label: str) -> None:
    assert [step.label for step in compiled(SLIDE).steps].count(label) == 1


def test_a_controller_written_twice_costs_nothing_more() -> None:
    once, twice = compiled("π_close|Γ Γ"), compiled("π_close|Γ Γ ◁ π_close|Γ Γ")
    labels = [step.label for step in twice.steps[: twice.bare]]
    assert [labels.count(step.label) for step in once.steps] == [
        [step.label for step in once.steps].count(step.label) for step in once.steps
    ]


def test_evaluation_is_pure() -> None:
    pipeline, seen = compiled(SLIDE), observation()
    first = pipeline.evaluate(seen).command.displacement.copy()
    pipeline.evaluate(observation(8))
    np.testing.assert_array_equal(pipeline.evaluate(seen).command.displacement, first)
