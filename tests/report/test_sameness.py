"""Which runs are the same, point by point: to the last bit, but for rounding, or not; for every pair, and why."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from stored_runs import lose_trajectory, stored_run

from graspdsl.compiler.alike import SAME_PROGRAM
from graspdsl.report.comparison import Comparison, comparison, comparison_tables
from graspdsl.report.evidence import evidence_of
from graspdsl.report.sameness import Sameness, parting, said_of, sameness_table
from graspdsl.report.summary import plain, summarised
from graspdsl.report.wording import NOTHING
from graspdsl.trials.trajectories import Rows

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"
TICKS = 7


def trajectory(ticks: int = TICKS) -> Rows:
    """One of two contacts; the second touches from the third tick on."""
    random = np.random.default_rng(5)
    forces = random.normal(size=(ticks, 2, 3)).astype(np.float32)
    forces[:2, 1] = np.nan
    points, axes = random.normal(scale=0.1, size=(2, ticks, 2, 3)).astype(np.float32)
    return {
        "tick": np.arange(ticks, dtype=np.float32),
        "time": np.arange(ticks, dtype=np.float32),
        "points": points,
        "normals": axes,
        "forces": forces,
        "joints": np.zeros((ticks, 0), dtype=np.float32),
        "object_position": np.zeros((ticks, 3), dtype=np.float32),
        "object_rotation": np.tile(np.eye(3, dtype=np.float32), (ticks, 1, 1)),
    }


def test_what_is_the_same_to_the_last_bit_never_parts() -> None:
    parts, largest = parting(trajectory(), trajectory())
    assert parts is None
    assert set(largest) == {"m", "1", "N"}
    assert not any(largest.values())
    assert parting({}, {}) == (None, {})


def test_neighbouring_numbers_are_the_same_but_for_rounding() -> None:
    """One float of 32 bits further is rounding; three are not."""
    for floats, parts in ((1, None), (3, 4)):
        moved, place = trajectory(), np.unravel_index(np.argmax(np.abs(trajectory()["points"][4])), (2, 3))
        value = np.abs(moved["points"]).max()
        moved["points"][4][place] += floats * np.spacing(value)
        found, largest = parting(trajectory(), moved)
        assert found == parts
        assert 0.0 < largest["m"] < 1e-6


def test_trials_part_where_one_goes_another_way_loses_touch_or_ends() -> None:
    elsewhere, lost = trajectory(), trajectory()
    elsewhere["normals"][5, 0, 0] += 0.1
    lost["forces"][3, 0] = np.nan
    assert parting(trajectory(), elsewhere)[0] == 5
    assert parting(lost, trajectory())[0] == 3
    assert parting(trajectory(), trajectory(TICKS - 2))[0] == 0  # other random numbers
    shorter = {name: rows[:-2] for name, rows in trajectory().items()}
    assert parting(trajectory(), shorter)[0] == TICKS - 2
    assert parting(trajectory(), {})[0] == 0


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> Comparison:
    """Of a few trials: the composite twice, its order exchanged, the force alone, C*, φ_w, and another seed."""
    place, few = tmp_path_factory.mktemp("runs"), ("trials.count=3", "program.0.limit=4")
    names = ["moment_subject_to_force", "moment_subject_to_force", "force_subject_to_moment", "force_alone", "cstar"]
    settings: list[tuple[str, ...]] = [()] * 6 + [("trials.seed=7",)]
    folders = [
        stored_run(place / str(number), SPECS / f"{name}.yaml", *few, *more)
        for number, (name, more) in enumerate(
            zip([*names, "naive_wrench", "moment_subject_to_force"], settings, strict=True), 1
        )
    ]
    return comparison([(evidence, summarised(evidence)) for evidence in map(evidence_of, folders)])


@pytest.mark.slow
def test_every_pair_is_told(found: Comparison) -> None:
    verdicts = {pair.runs: pair.verdict for pair in found.sameness}
    assert len(verdicts) == 21
    assert verdicts[1, 2] == "identical"
    assert {verdicts[pair] for pair in ((1, 3), (2, 3), (1, 6), (2, 6), (3, 6))} == {"same to rounding"}
    assert {verdicts[one, other] for one, other in verdicts if other == 7} == {"no equal trials"}
    assert all(verdicts[pair] == "different" for pair in ((1, 4), (3, 4), (1, 5), (4, 5), (5, 6)))
    assert all(pair.trials == 3 for pair in found.sameness if 7 not in pair.runs)


@pytest.mark.slow
def test_it_says_which_are_the_same_by_how_much_and_why(found: Comparison) -> None:
    [said] = said_of(found.sameness)
    assert said.startswith("Runs 1, 2, 3 and 6 are the same, point by point, but for rounding, in 3 equal trials.")
    assert "F·(F × M) = 0" in said
    assert "−k ∇ε_w" in said
    same = [pair for pair in found.sameness if pair.is_same]
    assert 0.0 < max(gap for pair in same for gap in pair.largest.values()) < 1e-6
    together = [pair for pair in found.sameness if pair.runs == (4, 5)]
    assert together[0].parts_at is not None
    assert together[0].parts_at > 3  # C* begins with the force alone


@pytest.mark.slow
def test_the_square_has_a_cell_for_every_pair(found: Comparison) -> None:
    made = sameness_table(found.sameness, [str(number) for number in range(1, 8)])
    cells = [[cell.text for cell in row] for row in made.cells()]
    assert cells[0] == ["1", "identical", "same", "100 %, tick 1", "100 %, tick 1", "same", "none equal"]
    assert [row[1:].count("") for row in cells] == list(range(6))


@pytest.mark.slow
def test_rows_in_which_no_run_has_a_number_are_left_out(found: Comparison) -> None:
    """In JSON, too: where no trial converged there are no costs."""
    for made in comparison_tables(found):
        assert all(any(cell.text not in (NOTHING, "") for cell in row[1:]) for row in made.cells())
    numbers: Any = plain(found)
    assert len(numbers["sameness"]) == 21
    for name in numbers["measures"]:
        assert any(run["medians"][name] is not None for run in numbers["runs"])


@pytest.mark.slow
def test_costs_of_runs_that_never_converge_are_not_there(tmp_path: Path) -> None:
    folders = [
        stored_run(tmp_path / name, SPECS / f"{name}.yaml", "trials.count=2", "program.0.limit=2")
        for name in ("force_alone", "cstar")
    ]
    made = comparison([(evidence, summarised(evidence)) for evidence in map(evidence_of, folders)])
    assert not {"world_s", "samples", "ticks"} & set(made.measures)
    assert not made.against_first[0].ratios


@pytest.mark.slow
def test_trials_whose_trajectories_are_lost_are_not_called_unequal(tmp_path: Path) -> None:
    """Those that are left are held against one another; of none, it says that they are lost."""
    few = ("trials.count=2", "program.0.limit=2")
    whole, one, none = (stored_run(tmp_path / name, SPECS / "cstar.yaml", *few) for name in ("whole", "one", "none"))
    lose_trajectory(one, 1)
    for number in range(2):
        lose_trajectory(none, number)
    made = comparison([(evidence, summarised(evidence)) for evidence in map(evidence_of, (whole, one, none))])
    assert [(pair.verdict, pair.trials, pair.lost) for pair in made.sameness] == [
        ("identical", 1, 1),
        ("no trajectories", 0, 2),
        ("no trajectories", 0, 2),
    ]
    said = "Runs 1 and 2 are the same, point by point, to the last bit, in 1 equal trial. They must be: "
    assert said_of(made.sameness) == [f"{said}{SAME_PROGRAM}."]
    square = sameness_table(made.sameness, ["1", "2", "3"])
    assert [cell.text for cell in square.cells()[0]] == ["1", "identical", "lost"]
    assert "lost: " in square.note


def test_one_program_that_did_two_things_is_not_explained_by_rounding() -> None:
    pair = Sameness((1, 2), "different", 3, 1, 0, 7.0, 0, {"m": 0.1}, SAME_PROGRAM)
    assert said_of([pair]) == [f"Runs 1 and 2 part in 2 of 3 equal trials, though {SAME_PROGRAM}."]
    [said] = said_of([replace(pair, by_law="a law")])
    assert "where rounding has grown" in said


@pytest.mark.slow
def test_runs_without_a_finished_trial_have_no_empty_tables(tmp_path: Path) -> None:
    evidence = replace(evidence_of(stored_run(tmp_path / "run", SPECS / "cstar.yaml", "trials.count=1")), records=())
    made = comparison([(evidence, summarised(evidence))] * 2)
    assert all(table.rows for table in comparison_tables(made))
