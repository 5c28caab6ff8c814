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
from graspdsl.reference.kinds import KINDS
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
        "in ASCII": "pi_sgx|G G",
        "use it": "my own way",
    }
    assert [entry for entry in listed if entry["controller"] == "π_mine|Γ Γ"] == [mine]
    assert len(listed) == len(prelude()) + 1
    assert "π_mine|Γ Γ ≡ π_sgx|Γ Γ  (Eq. 7.1) my own way" in graspdsl("explain", "own.yaml", cwd=tmp_path).stdout
    assert graspdsl("list", "hands", "own.yaml", cwd=tmp_path).returncode == 2
    assert graspdsl("list", "controllers", "other.yaml", cwd=tmp_path).returncode == 1


def test_bare_list_says_what_can_be_listed(tmp_path: Path) -> None:
    """Every kind, with how many there are and a line; each can be listed, in the terminal and as data."""
    kinds = json.loads(graspdsl("list", "--json", cwd=tmp_path).stdout)["kinds"]
    assert [kind["kind"] for kind in kinds] == [*KINDS]
    assert all(int(kind["count"]) > 0 and kind["about"] for kind in kinds)
    shown = graspdsl("list", cwd=tmp_path).stdout
    assert all(name in shown for name in KINDS)
    for kind in kinds:
        rows = json.loads(graspdsl("list", kind["kind"], "--json", cwd=tmp_path).stdout)[kind["kind"]]
        assert len(rows) == int(kind["count"])


def test_hands_are_listed_with_what_resources_may_name(tmp_path: Path) -> None:
    """Contacts and joint sets; of a hand file in the folder its name alone. What else a kind is called is heard."""
    (tmp_path / "mine.yaml").write_text("hand: mine\n", "utf-8")
    shown = graspdsl("list", "hands", cwd=tmp_path).stdout
    assert all(name in shown for name in ("finger-1", "flexion", "distals", "mine.yaml"))
    assert (
        graspdsl("list", "touch", cwd=tmp_path).stdout.splitlines()[1:]
        == (graspdsl("list", "sensing", cwd=tmp_path).stdout.splitlines()[1:])
    )


def test_a_code_is_explained_by_its_examples(tmp_path: Path) -> None:
    """As text and as data; the rule of a contract by what it asks; what is no code is a formula."""
    told = graspdsl("explain", "wrong-sensor", cwd=tmp_path).stdout
    assert all(text in told for text in ("error[wrong-sensor]", "φ_fr|τ_frx(Γ) σ_mr(Γ)", "φ_fr|τ_frx(Γ) σ_fr(Γ)"))
    data = json.loads(graspdsl("explain", "wrong-sensor", "--json", cwd=tmp_path).stdout)["diagnostic"]
    assert (data["code"], data["right"]) == ("wrong-sensor", "φ_fr|τ_frx(Γ) σ_fr(Γ)")
    assert "central differences" in graspdsl("explain", "contract-gradient", cwd=tmp_path).stdout
    refused = graspdsl("explain", "wrong-senor", cwd=tmp_path)
    assert (refused.returncode, "unexpected-word" in refused.stderr) == (1, True)


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
    kinds, figures = ("svg", "png", "csv", "units.json"), ("orientation", "residuals", "convergence")
    of_figures = {f"{figure}.{kind}" for figure in figures for kind in kinds}
    assert {file.name for file in place.iterdir()} == {"compare.html", "compare.json"} | of_figures
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
