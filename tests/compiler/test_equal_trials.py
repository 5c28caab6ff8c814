"""Several trials are warned of where nothing tells one from another, and only there."""

from __future__ import annotations

import pytest

from graspdsl.compiler.program import examine

from .specs import FLOATING, POINTS, RESOURCES, spec

BULLET = "world: bullet, object: towel-roll"
NOISY = "sensing: {load-cell: {force_noise: 0.01}}"
GRID = "grid: [{parameter: roll, low: -1.0, high: 1.0, cells: 4}]"


def codes(trials: str, scene: str = BULLET, *overrides: str) -> list[str]:
    """What is said of a spec with these trials."""
    resources = {**RESOURCES, **(POINTS if FLOATING in scene else {})}
    formula = "π_gx|Γ Γ" if FLOATING in scene else "π_s|Γ Γ (π_gx|Γ Γ)"
    text = spec(formula, scene=scene, resources=resources).replace("program:", f"trials: {{{trials}}}\nprogram:")
    return [diagnostic.code for diagnostic in examine(text, "spec.yaml", overrides).diagnostics]


@pytest.mark.parametrize(
    "sensing", ["", ", sensing: exact", ", sensing: skin", ", sensing: {load-cell: {latency: 0.02}}"]
)
def test_equal_trials_are_warned_of(sensing: str) -> None:
    assert codes("count: 2", BULLET + sensing) == ["equal-trials"]
    assert codes("count: 2, start: {posture: {spread-1: 0.5}}", BULLET + sensing) == ["equal-trials"]


@pytest.mark.parametrize(
    ("trials", "scene"),
    [
        ("count: 1", BULLET),
        ("start: {roll: 0.3}", BULLET),
        ("count: 2, start: {roll: {uniform: [-1, 1]}}", BULLET),
        ("count: 2, start: {posture: {spread-1: {choice: [0.2, 0.4]}}}", BULLET),
        (f"count: 4, {GRID}", BULLET),
        ("count: 4, start: {roll: {choice: [0.1, 0.2]}, yaw: {choice: [0, 1]}}", BULLET),
        ("count: 2", f"{BULLET}, {NOISY}"),
        ("count: 2", f"{FLOATING}, object: ball"),
    ],
)
def test_trials_that_differ_or_were_not_asked_for_are_not(trials: str, scene: str) -> None:
    assert codes(trials, scene) == []


@pytest.mark.parametrize(
    ("trials", "scene"),
    [
        ("count: 2, start: {roll: {uniform: [0.3, 0.3]}}", BULLET),
        ("count: 2, start: {roll: {normal: [0.3, 0]}, yaw: {choice: [0.1, 0.1]}}", BULLET),
        ("count: 2, start: {approach: top, height: {uniform: [0.1, 0.2]}}", BULLET),
        ("count: 2", f"{BULLET}, sensing: {{load-cell: {{force_quantum: 0.003}}}}"),
        ("count: 3, start: {roll: {choice: [0.1, 0.2]}}", BULLET),
        (f"count: 5, {GRID}", BULLET),
    ],
)
def test_what_seems_to_be_drawn_and_is_the_same_each_time(trials: str, scene: str) -> None:
    """Distributions of one number, a height that is not used, rounding without noise, fewer starts than trials."""
    assert "equal-trials" in codes(trials, scene)


def test_cells_that_no_trial_begins_in_are_warned_of() -> None:
    assert codes(f"count: 3, {GRID}") == ["empty-cells"]
    assert codes("grid: [{parameter: roll, low: -1.0, high: 1.0, cells: 40}]") == ["empty-cells"]


def test_the_last_word_counts() -> None:
    assert codes("count: 2", BULLET, "trials.count=1") == []
    assert codes("count: 2", BULLET, "trials.start.roll={uniform: [-1, 1]}") == []
    assert codes("count: 1", BULLET, "trials.count=3") == ["equal-trials"]
