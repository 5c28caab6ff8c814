"""``graspdsl compare`` and ``graspdsl list``."""

from __future__ import annotations

import json
from collections.abc import Collection
from pathlib import Path

import pytest

from cli.program import graspdsl
from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import prelude
from graspdsl.basis.sensors import SENSORS
from graspdsl.hands.descriptions import mounts
from graspdsl.worlds.kinds import WORLDS
from graspdsl.worlds.touch.sensors import TACTILE_SENSORS

pytestmark = pytest.mark.slow

SPECS = Path(__file__).resolve().parents[2] / "specs" / "compare"


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("potentials", POTENTIALS),
        ("sensors", SENSORS),
        ("effectors", EFFECTORS),
        ("hands", ["barrett", "points", "trio"]),
        ("mounts", mounts()),
        ("sensing", TACTILE_SENSORS),
        ("worlds", WORLDS),
    ],
)
def test_lists_name_what_there_is(kind: str, names: Collection[str], tmp_path: Path) -> None:
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


def test_a_specs_own_controllers_are_listed_and_explained(tmp_path: Path) -> None:
    """With the equation and the words that the spec gives them, beside the prelude's."""
    text = (SPECS / "sliding.yaml").read_text("utf-8")
    own = 'controllers:\n  π_mine|Γ Γ: {is: π_sgx|Γ Γ, equation: "7.1", about: my own way}\n\nprogram:'
    text = text.replace("program:", own).replace("π_s|Γ Γ (π_gx|Γ Γ)", "π_mine|Γ Γ")
    (tmp_path / "own.yaml").write_text(text, encoding="utf-8")
    listed = json.loads(graspdsl("list", "controllers", "own.yaml", "--json", cwd=tmp_path).stdout)["controllers"]
    mine = {
        "controller": "π_mine|Γ Γ",
        "from": "own.yaml",
        "equation": "7.1",
        "stands for": "π_sgx|Γ Γ",
        "use it": "my own way",
    }
    assert [entry for entry in listed if entry["controller"] == "π_mine|Γ Γ"] == [mine]
    assert len(listed) == len(prelude()) + 1
    assert "π_mine|Γ Γ ≡ π_sgx|Γ Γ  (Eq. 7.1) my own way" in graspdsl("explain", "own.yaml", cwd=tmp_path).stdout
    assert graspdsl("list", "hands", "own.yaml", cwd=tmp_path).returncode == 2
    assert graspdsl("list", "controllers", "other.yaml", cwd=tmp_path).returncode == 1


def test_an_unknown_kind_is_wrong_use(tmp_path: Path) -> None:
    """Exit code 2 names the kinds there are."""
    done = graspdsl("list", "robots", cwd=tmp_path)
    assert done.returncode == 2
    assert "potentials" in done.stderr


def test_runs_are_compared(tmp_path: Path) -> None:
    """Differences and ratios with intervals, as text, as data and as a page; a run that is not finished and one that
    stands there twice are compared too."""
    folders = ["moment_subject_to_force", "cstar"]
    for name in folders:
        made = graspdsl("run", str(SPECS / f"{name}.yaml"), "--trials", "6", "--out", name, cwd=tmp_path)
        assert made.returncode == 0
    done = graspdsl("compare", *folders, folders[0], "--out", "<b>&", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    numbers = json.loads(done.stdout)
    assert [run["finished"] for run in numbers["runs"]] == [6, 6, 6]
    other, same = numbers["against_first"]
    assert other["pairs"] == same["pairs"] == 6
    assert other["converged"]["value"] < 0.0 == same["converged"]["value"]
    place = tmp_path / "<b>&"
    assert json.loads((place / "compare.json").read_text("utf-8"))["runs"] == numbers["runs"]
    assert {file.name for file in place.iterdir()} == {"compare.html", "compare.json"} | {
        f"{figure}.{kind}" for figure in ("orientation", "residuals", "convergence") for kind in ("svg", "png")
    }
    refused = graspdsl("compare", *folders, "--out", "<b>&", cwd=tmp_path)
    assert (refused.returncode, "folder-not-empty" in refused.stderr) == (1, True)
    said = graspdsl("compare", *folders, cwd=tmp_path)
    assert "tactile samples" in said.stdout
    assert "Newcombe 1998" in said.stdout
    assert "report: runs/compare-001/compare.html" in said.stderr


def test_one_run_or_no_run_is_not_a_comparison(tmp_path: Path) -> None:
    """One folder is wrong use; a folder without a run is wrong input."""
    assert graspdsl("compare", str(tmp_path), cwd=tmp_path).returncode == 2
    refused = graspdsl("compare", str(tmp_path), str(tmp_path), cwd=tmp_path)
    assert refused.returncode == 1
    assert "not-a-run" in refused.stderr
