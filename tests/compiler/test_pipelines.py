"""From graph to numbers: the command against a computation of its own, and what every pipeline keeps to."""

from __future__ import annotations

from functools import partial
from itertools import combinations, product

import numpy as np
import pytest

from graspdsl.arrays import Array
from graspdsl.basis.algebra import tangent_frames
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


def grasp_step(seen: Observation, control: Control) -> Array:
    """π_gx|Γ Γ for Γ = {γ1, <γ2, γ3>}: the displacement of each contact, (k, 3)."""
    normals, radius = seen.normals, control.curvature_radius
    centre = SHARE @ seen.points / SHARE.sum() if control.origin == "centroid" else np.zeros(3)
    force = SHARE @ normals
    moment = SHARE @ np.cross(seen.points - centre, normals)
    tangent = np.eye(3) - normals[:, :, None] * normals[:, None, :]
    by_contact = [-SHARE[:, None, None] * block for block in (tangent / radius, np.cross(normals[:, None], np.eye(3)))]
    by_contact[1] = np.swapaxes(by_contact[1], 1, 2)  # rows of cross(n, I) are the columns of [n]×
    scale = np.ones(CONTACTS)
    if control.virtual == "members":
        scale = 1 / np.sqrt(SHARE)
        by_contact = [block * scale[:, None, None] for block in by_contact]
    else:
        for block in by_contact:
            block[[FIRST, SECOND]] = block[FIRST] + block[SECOND]
    force_task, moment_task = (np.hstack(list(block)) for block in by_contact)
    down_force = -control.step * radius * force_task.T @ force
    down_moment = -control.step * control.moment_gain / radius * moment_task.T @ moment
    above = force_task if control.nullspace == "task" else down_force[None]
    step: Array = (down_force + null_space(above) @ down_moment).reshape(-1, 3) * scale[:, None]
    return step


def slide_step(seen: Observation, control: Control, pressure: float) -> Array:
    """π_s|Γ Γ (π_gx|Γ Γ) for contacts that all touch: the displacement of each joint, (n,)."""
    rows = EACH if control.virtual == "members" else MEAN
    step = grasp_step(seen, control)
    step = step / max(1.0, np.linalg.norm(step, axis=1).max() / control.cap)
    jacobian = seen.jacobian * WEIGHTS
    position_task = np.einsum("rk,kin->rin", rows, jacobian).reshape(-1, JOINTS)
    inverse = position_task.T
    if control.inverse == "pseudo-inverse":
        inverse = inverse @ np.linalg.inv(position_task @ position_task.T + control.damping**2 * np.eye(3 * len(rows)))
    along = inverse @ (rows @ step).ravel()
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
    control = Control(**form)
    for seed in range(5):
        seen = observation(seed)
        found = command("π_gx|Γ Γ", seen, **form)
        np.testing.assert_allclose(found, grasp_step(seen, control), rtol=1e-9, atol=1e-15)


@EACH_FORM
def test_slide_step(form: dict[str, str]) -> None:
    control = Control(**form)
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
    ],
)
def test_slide_step_under_other_settings(settings: dict[str, float]) -> None:
    seen = observation()
    expected = slide_step(seen, Control(**settings), 0.5)
    np.testing.assert_allclose(command(SLIDE, seen, **settings), expected, rtol=1e-8, atol=1e-13)


@pytest.mark.parametrize("nullspace", ["task", "gradient"])
def test_surface_step_is_the_grasp_step_in_tangent_frames(nullspace: str) -> None:
    seen = observation()
    over_surface = command("π_g|Γ Γ", seen, nullspace=nullspace, curvature_radius=0.08)
    assert over_surface.shape == (CONTACTS, 2)
    step = 0.08 * np.einsum("kij,kj->ki", tangent_frames(seen.normals), over_surface)
    expected = command("π_gx|Γ Γ", seen, nullspace=nullspace, curvature_radius=0.08)
    np.testing.assert_allclose(step, expected, rtol=1e-9, atol=1e-15)


def test_unit_net_force_moves_a_contact_by_a_step() -> None:
    seen = observation()
    found = command("φ_fr|τ_frx(γ1) σ_fr(γ2)", seen, step=0.003)
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
        command(f"φ_p|τ_p(Γ) σ_p(Γ) ({', '.join(map(repr, where.tolist()))})", seen, virtual=virtual, damping=1e-4)
        for where in (here, here + 0.01)
    )
    np.testing.assert_allclose(at_rest, 0.0, atol=1e-12)
    moved = MEAN @ np.einsum("kin,n->ki", seen.jacobian, shifted)
    np.testing.assert_allclose(moved, 0.01, rtol=1e-3)


@EACH_FORM
def test_batch_gives_what_its_members_give(form: dict[str, str]) -> None:
    pipeline = compiled(SLIDE, **form)
    batch = observation(3, 4)
    batch.touching[1, THUMB] = False
    values = pipeline.values(batch)
    outputs = [pipeline.command, pipeline.force_residual, pipeline.moment_residual, *[x.step for x in pipeline.leaks]]
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


# --- sharing ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("formula", [SLIDE, "π_sgx|Γ Γ", "π_gx|γ1 Γ", "π_g|Γ Γ", "π_close|Γ Γ ◁ π_close|γ1 γ1"])
def test_nothing_is_computed_twice_or_in_vain(formula: str) -> None:
    pipeline = compiled(formula)
    readings = [step.reading for step in pipeline.steps if step.reading]
    assert len(set(readings)) == len(readings)
    values = pipeline.values(observation())
    for (one, a), (other, b) in combinations(zip(pipeline.steps, values, strict=True), 2):
        if np.any(a) and _function(one) == _function(other):
            assert a.shape != b.shape or not np.array_equal(a, b), f"{one.label} = {other.label}"
    used = {place for step in pipeline.steps for place in step.inputs}
    outputs = {pipeline.command, pipeline.force_residual, pipeline.moment_residual}
    outputs |= {leak.step for leak in pipeline.leaks}
    assert used | outputs == set(range(len(pipeline.steps)))


def _function(step: Step) -> str:
    function = step.function.func if isinstance(step.function, partial) else step.function
    return getattr(function, "__qualname__", repr(function))


@pytest.mark.parametrize("label", ["σ_p(Γ)", "σ_n(Γ)", "σ_f(Γ)", "σ_fr(Γ)", "σ_mr(Γ)", "τ_p(Γ)", "τ_f(Γ)", "J", "c"])
def test_each_transform_is_evaluated_once(label: str) -> None:
    assert [step.label for step in compiled(SLIDE).steps].count(label) == 1


def test_a_controller_written_twice_costs_nothing_more() -> None:
    once, twice = compiled("π_close|Γ Γ"), compiled("π_close|Γ Γ ◁ π_close|Γ Γ")
    labels = [step.label for step in twice.steps]
    assert [labels.count(step.label) for step in once.steps] == [
        [step.label for step in once.steps].count(step.label) for step in once.steps
    ]


def test_evaluation_is_pure() -> None:
    pipeline, seen = compiled(SLIDE), observation()
    first = pipeline.evaluate(seen).command.displacement.copy()
    pipeline.evaluate(observation(8))
    np.testing.assert_array_equal(pipeline.evaluate(seen).command.displacement, first)
