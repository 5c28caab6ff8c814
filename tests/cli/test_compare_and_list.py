"""``graspdsl compare`` and ``graspdsl list``."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from cli.program import graspdsl
from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.sensors import SENSORS
from graspdsl.compiler.definitions import prelude

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"


@pytest.mark.parametrize(
    ("kind", "names"),
    [("potentials", POTENTIALS), ("sensors", SENSORS), ("effectors", EFFECTORS), ("hands", ["barrett", "points"])],
)
def test_lists_name_what_there_is(kind: str, names: list[str], tmp_path: Path) -> None:
    """Every entry of a table is listed, on a terminal and as data."""
    listed = json.loads(graspdsl("list", kind, "--json", cwd=tmp_path).stdout)[kind]
    assert sorted(entry["name"] for entry in listed) == sorted(names)
    text = graspdsl("list", kind, cwd=tmp_path).stdout
    assert all(name in text for name in names)


def test_controllers_are_listed_with_equation_and_use(tmp_path: Path) -> None:
    """The prelude, each with its equation number and one line on when to use it."""
    listed = json.loads(graspdsl("list", "controllers", "--json", cwd=tmp_path).stdout)["controllers"]
    assert len(listed) == len(prelude())
    assert all(entry["equation"] and entry["use it"] and entry["stands for"] for entry in listed)


def test_an_unknown_kind_is_wrong_use(tmp_path: Path) -> None:
    """Exit code 2 names the kinds there are."""
    done = graspdsl("list", "robots", cwd=tmp_path)
    assert done.returncode == 2
    assert "potentials" in done.stderr


def test_two_runs_are_compared(tmp_path: Path) -> None:
    """Ratios with intervals, as text and as data."""
    for name in ("moment_subject_to_force", "force_subject_to_moment"):
        made = graspdsl(
            "run", str(SPECS / f"{name}.yaml"), "--trials", "4", "--out", str(tmp_path / name), cwd=tmp_path
        )
        assert made.returncode == 0
    folders = [str(tmp_path / "moment_subject_to_force"), str(tmp_path / "force_subject_to_moment")]
    numbers = json.loads(graspdsl("compare", *folders, "--json", cwd=tmp_path).stdout)
    assert [run["finished"] for run in numbers["runs"]] == [4, 4]
    text = graspdsl("compare", *folders, cwd=tmp_path).stdout
    assert "tactile samples" in text
    assert "Ratios to run 1" in text


def test_one_run_or_no_run_is_not_a_comparison(tmp_path: Path) -> None:
    """One folder is wrong use; a folder without a run is wrong input."""
    assert graspdsl("compare", str(tmp_path), cwd=tmp_path).returncode == 2
    refused = graspdsl("compare", str(tmp_path), str(tmp_path), cwd=tmp_path)
    assert refused.returncode == 1
    assert "not-a-run" in refused.stderr
