"""Starts on a grid: each trial a cell, all else at the middle of its distribution."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
import yaml

from graspdsl.compiler.program import Program, examine, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.spec.distributions import Choice, Normal
from graspdsl.spec.trials import Trials
from graspdsl.trials.maps import WantedAxis, axes_of, cells_of, grid_settings, middle
from graspdsl.trials.runner import execute, new_run

SPEC = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
TEXT = SPEC.read_text("utf-8")
AXES = [WantedAxis("roll", None, 3), WantedAxis("height", (0.08, 0.12), 2)]


def program(*overrides: str) -> Program:
    """The towel roll."""
    return program_of(TEXT, SPEC.name, overrides)


def test_cells_lie_side_by_side_along_the_first_axis() -> None:
    trials = program(*grid_settings(program(), AXES)).spec.trials
    starts = [trials.start_of(number) for number in range(trials.count)]
    assert [start.roll for start in starts] == pytest.approx([-1.0, 0.0, 1.0] * 2)
    assert [start.height for start in starts] == pytest.approx([0.09] * 3 + [0.11] * 3)
    assert {start.standoff for start in starts} == {0.07}
    assert trials.start_of(6) == starts[0]
    x, y = axes_of(program(*grid_settings(program(), AXES)).spec)
    assert (x.parameter, x.unit, y.parameter, y.unit) == ("roll", "rad", "height", "m")
    assert list(x.middles) == pytest.approx([-1.0, 0.0, 1.0])


def test_without_a_grid_nothing_changes() -> None:
    trials = program().spec.trials
    assert trials.start_of(5) == trials.start


def test_the_middle_of_a_distribution() -> None:
    assert middle(0.3) == 0.3
    assert middle(Normal(normal=(0.2, 9.0))) == 0.2
    assert middle(Choice(choice=(5.0, 1.0, 2.0))) == 2.0
    assert middle(Choice(choice=(4.0, 1.0))) == 1.0


@pytest.mark.parametrize(
    ("axis", "settings", "code", "said"),
    [
        (WantedAxis("rol", None, 2), (), "unknown-start-parameter", "did you mean roll"),
        (WantedAxis("yaw", None, 2), (), "no-bounds", "--over yaw=LOW:HIGH"),
        (WantedAxis("yaw", (0.0, 7.0), 2), (), "out-of-range", "radians"),
        (WantedAxis("standoff", (-0.1, 0.1), 2), (), "out-of-range", "metres"),
        (WantedAxis("height", None, 2), ("trials.start.approach=top",), "no-effect", "another"),
    ],
)
def test_axes_that_cannot_be_are_refused(axis: WantedAxis, settings: tuple[str, ...], code: str, said: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        grid_settings(program(*settings), [AXES[0], axis])
    [diagnostic] = caught.value.diagnostics
    assert diagnostic.code == code
    assert said in (diagnostic.hint or "")


ROLL = {"parameter": "roll", "low": -1.0, "high": 1.0, "cells": 4}


@pytest.mark.parametrize(
    ("grid", "code"),
    [
        ([{**ROLL, "parameter": "rol"}], "unknown-value"),
        ([{**ROLL, "high": -1.0}], "out-of-range"),
        ([{**ROLL, "high": 10.0}], "out-of-range"),
        ([{**ROLL, "cells": 0}], "out-of-range"),
        ([ROLL, ROLL], "declared-twice"),
        ([{**ROLL, "cells": 1000}, {**ROLL, "parameter": "yaw", "cells": 101}], "out-of-range"),
        ([], "wrong-length"),
    ],
)
def test_a_wrong_grid_in_a_spec_is_one_complaint(grid: list[dict[str, object]], code: str) -> None:
    data = yaml.safe_load(TEXT)
    data["trials"]["grid"] = grid
    [diagnostic] = examine(yaml.safe_dump(data, allow_unicode=True), "spec.yaml").diagnostics
    assert diagnostic.code == code
    assert diagnostic.span is not None


def test_a_grid_is_passed_over_where_contacts_float() -> None:
    text = (SPEC.parent / "chapter" / "cstar.yaml").read_text("utf-8")
    grid = json.dumps([ROLL])
    [warning] = examine(text, "spec.yaml", (f"trials.grid={grid}",)).diagnostics
    assert warning.code == "no-effect"
    assert "roll" in warning.message


def test_a_run_that_is_no_map_is_refused() -> None:
    with pytest.raises(DiagnosticError, match="no map"):
        axes_of(program().spec)
    one = json.dumps([ROLL])
    with pytest.raises(DiagnosticError, match="no map"):
        axes_of(program(f"trials.grid={one}", "trials.count=4").spec)


@pytest.mark.slow
def test_a_start_that_cannot_be_is_a_class_of_its_own(tmp_path: Path) -> None:
    """In one cell of two the hand stands in the table: it is infeasible at once, the other runs from where it lies."""
    axes = [WantedAxis("roll", (-0.2, 0.2), 1), WantedAxis("height", (-0.2, 0.2), 2)]
    overrides = (*grid_settings(program(), axes), "program.1.limit=0.1")
    made = program(*overrides)
    folder = new_run(tmp_path / "map", made)
    execute(folder, workers=1)
    cells = cells_of(made.spec, folder.records())
    below, above = folder.records()
    assert cells.outcomes == ("infeasible-start", above.outcome.value)
    assert (len(below.rejected), below.start) == (1, {})
    assert "not feasible" in below.detail
    assert above.start["height"] == pytest.approx(0.1)


def test_trials_of_a_model_know_their_cells() -> None:
    """Six axes at most, in any order."""
    trials = Trials.model_validate({"grid": [{**ROLL, "cells": 2}, {**ROLL, "parameter": "tilt", "cells": 2}]})
    assert [(trials.start_of(n).roll, trials.start_of(n).tilt) for n in range(4)] == [
        (-0.5, -0.5),
        (0.5, -0.5),
        (-0.5, 0.5),
        (0.5, 0.5),
    ]
