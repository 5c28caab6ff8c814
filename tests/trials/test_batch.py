"""Many floating starts at once: what becomes of each does not depend on the others."""

from __future__ import annotations

from dataclasses import fields

import numpy as np
import pytest
from worlds.floating_runs import (
    ELLIPSOID_B,
    LOW,
    RADIUS,
    SPHERE,
    contacts,
    pipelines,
    run,
    starts,
)

from graspdsl.trials.batch import BatchResult, run_batch

THREE = contacts(3)
FORMULAS = ["π_gx|Γ Γ", "π_cstar|Γ Γ", "φ_w|τ_wx(Γ) σ_w(Γ)"]
EACH_FORMULA = pytest.mark.parametrize("formula", FORMULAS)
EACH_END = pytest.mark.parametrize("stop", [True, False], ids=["stop", "go on"])


def rows(result: BatchResult, index: int | slice) -> list[object]:
    """The results of some starts."""
    return [getattr(result, field.name)[index] for field in fields(BatchResult)]


@EACH_FORMULA
@EACH_END
def test_a_start_fares_alone_as_it_does_among_others(formula: str, stop: bool) -> None:
    stages, points = pipelines(formula, THREE), starts(ELLIPSOID_B, 12)
    whole = run_batch(stages, ELLIPSOID_B, points, stop=stop, steps=200, **LOW)
    for index in range(len(points)):
        alone = run_batch(stages, ELLIPSOID_B, points[index : index + 1], stop=stop, steps=200, **LOW)
        for found, expected in zip(rows(alone, 0), rows(whole, index), strict=True):
            np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)


@EACH_FORMULA
def test_starts_are_left_as_they_were(formula: str) -> None:
    points = starts(ELLIPSOID_B, 5)
    before = points.copy()
    run_batch(pipelines(formula, THREE), ELLIPSOID_B, points, steps=30, **LOW)
    np.testing.assert_array_equal(points, before)


def test_batch_is_the_run_step_by_step() -> None:
    (pipeline,), points, steps = pipelines("π_gx|Γ Γ", THREE), starts(ELLIPSOID_B, 40), 120
    traced = run(pipeline, ELLIPSOID_B, points, steps + 1)
    found = run_batch((pipeline,), ELLIPSOID_B, points, stop=False, steps=steps, **LOW)
    np.testing.assert_allclose(found.force_residual, np.sqrt(traced.force_errors[-1]), rtol=1e-9, atol=1e-15)
    np.testing.assert_array_equal(found.points, run(pipeline, ELLIPSOID_B, points, steps).points)


def test_ticks_tell_from_when_on_residuals_stayed_low() -> None:
    """Bounds on the force alone, so that the run step by step says when."""
    (pipeline,), points, hold = pipelines("π_fr|Γ Γ", THREE), starts(SPHERE, 40), 20
    errors = run(pipeline, SPHERE, points, 200).force_errors
    for bound in (0.3, 1e-3):
        found = run_batch((pipeline,), SPHERE, points, force_bound=bound, moment_bound=np.inf, hold=hold, steps=199)
        high = np.sqrt(errors) >= bound
        since = len(errors) - np.argmax(high[::-1], axis=0)  # the residual never rises
        np.testing.assert_array_equal(found.ticks, np.where(high.any(axis=0), since, 0))
        assert found.converged.all()


@EACH_FORMULA
def test_bounds_hold_of_what_has_converged(formula: str) -> None:
    found = run_batch(pipelines(formula, THREE), ELLIPSOID_B, starts(ELLIPSOID_B, 100), **LOW)
    assert np.all(found.force_residual[found.converged] < LOW["force_bound"])
    assert np.all(found.moment_residual[found.converged] < LOW["moment_bound"])
    assert np.all(found.ticks[~found.converged] == 1000)
    assert np.all(found.ticks[found.converged] <= 1000 - 20 + 1)


@EACH_END
def test_bounds_that_nothing_meets_or_everything(stop: bool) -> None:
    stages, points = pipelines("π_gx|Γ Γ", THREE), starts(ELLIPSOID_B, 10)
    never = run_batch(stages, ELLIPSOID_B, points, force_bound=0.0, moment_bound=0.0, steps=50, stop=stop)
    assert not never.converged.any()
    assert np.all(never.ticks == 50)
    always = run_batch(stages, ELLIPSOID_B, points, force_bound=9.0, moment_bound=9.0, steps=50, stop=stop)
    assert always.converged.all()
    assert np.all(always.ticks == 0)
    moved = run(stages[0], ELLIPSOID_B, points, 19 if stop else 50).points
    np.testing.assert_allclose(always.points, moved, atol=1e-14)


def test_too_few_steps_to_hold_are_not_enough() -> None:
    stages, points = pipelines("π_gx|Γ Γ", THREE), starts(ELLIPSOID_B, 10)
    for steps, enough in ((18, False), (19, True)):
        found = run_batch(stages, ELLIPSOID_B, points, force_bound=9.0, moment_bound=9.0, steps=steps)
        assert found.converged.all() == enough == found.converged.any()


def test_each_stage_has_to_hold_anew() -> None:
    """Where everything is low, the second stage begins in the step in which the first has held, and counts from one."""
    points, hold = starts(ELLIPSOID_B, 10), 20
    bounds = {"force_bound": 9.0, "moment_bound": 9.0, "hold": hold}
    found = run_batch(pipelines("π_cstar|Γ Γ", THREE), ELLIPSOID_B, points, steps=50, **bounds)
    assert found.converged.all()
    assert np.all(found.ticks == hold - 1)
    short = run_batch(pipelines("π_cstar|Γ Γ", THREE), ELLIPSOID_B, points, steps=2 * hold - 3, **bounds)
    assert not short.converged.any()


def test_a_stage_begins_when_the_one_before_has_held() -> None:
    """The force's stage of C* lasts as long as the force controller alone; only then does the moment's move."""
    force, moment = pipelines("π_cstar|Γ Γ", THREE)
    points, hold = starts(ELLIPSOID_B, 30), 20
    alone = run_batch((force,), ELLIPSOID_B, points, force_bound=0.1, moment_bound=np.inf, hold=hold)
    assert alone.converged.all()
    first = int(alone.ticks.max()) + hold - 1
    both = run_batch((force, moment), ELLIPSOID_B, points, steps=first, **LOW)
    latest = alone.ticks == alone.ticks.max()
    np.testing.assert_allclose(both.points[latest], alone.points[latest], atol=1e-14)
    assert np.abs(both.points - alone.points)[alone.ticks < alone.ticks.max()].max() > 1e-3 * RADIUS
