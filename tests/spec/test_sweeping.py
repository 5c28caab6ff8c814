"""The points of a sweep: what a spec, or the command line, asks for."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.places.document import parse_document
from graspdsl.spec import load_spec_text
from graspdsl.spec.overrides import apply_overrides, makes_sweep
from graspdsl.spec.sweeping import Sweep, setting

FRICTION, STEP = "scene.friction", "control.step"


def points(text: str, *overrides: str) -> list[Any]:
    """The points of the sweep of a text."""
    sweep = load_spec_text(text, "test.yaml", overrides).spec.sweep
    assert sweep is not None
    return sweep.points()


def test_a_grid_is_every_combination_the_last_field_side_by_side(good: str) -> None:
    found = points(good + "sweep: {grid: {scene.friction: [0.3, 0.6], scene.hand: [a, b, c]}}\n")
    assert found == [{FRICTION: f, "scene.hand": h} for f in (0.3, 0.6) for h in "abc"]


def test_steps_are_evenly_spaced_numbers_or_logarithms(good: str) -> None:
    grid = (
        "{scene.friction: {from: 0.1, to: 0.7, steps: 4}, control.step: {from: 1e-4, to: 0.01, steps: 3, scale: log}}"
    )
    found = points(good + f"sweep: {{grid: {grid}}}\n")
    assert list(dict.fromkeys(point[FRICTION] for point in found)) == [0.1, 0.3, 0.5, 0.7]
    assert list(dict.fromkeys(point[STEP] for point in found)) == [1e-4, 1e-3, 1e-2]


def test_a_list_is_its_points(good: str) -> None:
    whole = "{scene.friction: 0.3, scene.object: {sphere: {diameter: 0.1}}}"
    assert points(good + f"sweep: {{list: [{whole}]}}\n") == [
        {FRICTION: 0.3, "scene.object": {"sphere": {"diameter": 0.1}}}
    ]


def test_random_points_follow_their_laws_and_their_seed() -> None:
    over = {
        FRICTION: {"uniform": [0.2, 1.0]},
        STEP: {"log_uniform": [1e-4, 1e-2]},
        "control.damping": {"normal": [1.0, 0.1]},
        "scene.object": {"choice": ["sphere", {"like": "box"}]},
    }

    def drawn(seed: int) -> list[Any]:
        return Sweep.model_validate({"random": {"points": 1000, "seed": seed, "over": over}}).points()

    found = drawn(1)
    assert found == drawn(1)
    assert found != drawn(2)
    friction, step, damping = (np.array([point[field] for point in found]) for field in list(over)[:3])
    error = 1 / np.sqrt(len(found))  # four standard errors of each mean
    assert abs(friction.mean() - 0.6) < 4 * error * 0.8 / np.sqrt(12)
    assert abs(np.log10(step).mean() + 3) < 4 * error * 2 / np.sqrt(12)
    assert abs(damping.mean() - 1.0) < 4 * error * 0.1
    assert 0.2 <= friction.min() < friction.max() <= 1.0
    assert 1e-4 <= step.min() < step.max() <= 1e-2
    assert abs(sum(point["scene.object"] == "sphere" for point in found) - 500) < 4 * np.sqrt(250)


@pytest.mark.parametrize(
    ("override", "found"),
    [
        ("scene.friction=0.3,0.6", [{FRICTION: 0.3}, {FRICTION: 0.6}]),
        ("scene.friction= 0.3 , 6e-1", [{FRICTION: 0.3}, {FRICTION: 0.6}]),
        ("scene.object=sphere,box", [{"scene.object": "sphere"}, {"scene.object": "box"}]),
        ("control.step={uniform: [0, 1]},0.5", [{STEP: {"uniform": [0, 1]}}, {STEP: 0.5}]),
        ("resources.γ4=<γ2,γ3>,'<γ1,γ3>'", [{"resources.γ4": "<γ2,γ3>"}, {"resources.γ4": "<γ1,γ3>"}]),
    ],
)
def test_several_values_of_a_setting_are_a_sweep(good: str, override: str, found: list[Any]) -> None:
    assert makes_sweep(override)
    assert points(good, override) == found


def test_settings_with_several_values_are_one_grid_with_that_of_the_spec(good: str) -> None:
    text = good + "sweep: {grid: {scene.friction: [0.3], control.step: [0.1, 0.2]}}\n"
    assert points(text, "scene.friction=0.5,0.7", "control.damping=1,2")[0] == {
        FRICTION: 0.5,
        STEP: 0.1,
        "control.damping": 1,
    }
    listed = good + "sweep: {list: [{scene.friction: 0.3}]}\n"
    assert points(listed, "control.step=0.1,0.2") == [{STEP: 0.1}, {STEP: 0.2}]


@pytest.mark.parametrize(
    "override",
    [
        "about=one, and another",
        'about="a,b"',
        "trials.start.roll.uniform=[0, 1]",
        "scene.object={box: {size: [0.1, 0.1, 0.1]}}",
        "resources.Γ={γ1, γ2}",
        "resources.γ4=<γ2,γ3>",
        r"program.0.run=\pi_s|_{\langle \gamma_2, \gamma_3 \rangle}^{\Gamma}",
        "about=a,,b",
        "about=it's, a,b",
    ],
)
def test_commas_within_one_value_part_nothing(override: str) -> None:
    assert not makes_sweep(override)


@pytest.mark.parametrize(
    ("sweep", "code", "at"),
    [
        ("{}", "wrong-form", "{}"),
        ("{grid: {scene.friction: [0.3]}, list: [{scene.friction: 0.3}]}", "wrong-form", "{grid"),
        ("{grid: {scene.friction: []}}", "wrong-length", "[]"),
        ("{grid: {scene.friction: 0.3}}", "wrong-form", "0.3"),
        ("{grid: {scene.friction: [0.3, 0.3]}}", "declared-twice", "[0.3"),
        ("{grid: {scene.friction: {from: 0.3, to: 0.3, steps: 3}}}", "out-of-range", "{from"),
        ("{grid: {scene.friction: {from: 0, to: 0.3, steps: 3, scale: log}}}", "out-of-range", "{from"),
        ("{grid: {scene.friction: {from: 0, to: 0.3, steps: 1}}}", "out-of-range", "1}"),
        ("{grid: {trials.count: [1, 2]}}", "same-at-all-points", "[1"),
        ("{grid: {trials: [1, 2]}}", "same-at-all-points", "[1"),
        ("{grid: {name: [a, b]}}", "same-at-all-points", "[a"),
        ("{grid: {scene..friction: [0.3]}}", "bad-override", "[0.3"),
        ("{list: [{scene.friction: 0.3}, {control.step: 0.1}]}", "missing-key", "{list"),
        ("{random: {points: 0, over: {scene.friction: {uniform: [0, 1]}}}}", "out-of-range", "0,"),
        ("{random: {points: 2, over: {scene.friction: {uniform: [1, 0]}}}}", "out-of-range", "{uniform"),
        ("{random: {points: 2, over: {scene.friction: {uniform: [0, 1], choice: [1]}}}}", "wrong-form", "{uniform"),
        ("{random: {points: 2, over: {scene.friction: {normal: [0, -1]}}}}", "out-of-range", "{normal"),
        ("{grid: {a: {from: 0, to: 1, steps: 100}, b: {from: 0, to: 1, steps: 11}}}", "out-of-range", "{grid"),
    ],
)
def test_what_is_no_sweep_is_refused_at_its_place(good: str, sweep: str, code: str, at: str) -> None:
    with pytest.raises(DiagnosticError) as refused:
        load_spec_text(f"{good}sweep: {sweep}\n", "test.yaml")
    [fault] = refused.value.diagnostics
    assert fault.code == code
    assert fault.span
    assert f"sweep: {sweep}"[fault.span.column - 1 :].startswith(at)
    assert fault.hint or "expected" in fault.message


@pytest.mark.parametrize(
    "value",
    [
        1e-07,
        0.30000000000000004,
        12,
        True,
        None,
        "gradient",
        "1e-3",
        "a: b",
        [0.1, 2],
        {"like": "sphere", "held": None},
    ],
)
def test_a_setting_of_a_point_is_read_as_its_value(value: Any) -> None:
    document, faults = apply_overrides(parse_document("a: 1\n", "a"), [setting("a", value)])
    assert faults == []
    assert type(document.data["a"]) is type(value)
    assert document.data["a"] == value
