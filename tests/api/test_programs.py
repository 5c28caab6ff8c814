"""Specs are loaded as the command line reads them, and refused with its words."""

from __future__ import annotations

import subprocess
import warnings
from pathlib import Path

import pytest
from cli.program import PROGRAM, ROOT, SPEC

import graspdsl as g

FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"


def test_a_spec_is_loaded_with_settings() -> None:
    program = g.load(FLOATING, set=["trials.count=5", "trials.seed=9"])
    assert (program.spec.trials.count, program.spec.trials.seed) == (5, 9)
    assert g.load(str(FLOATING), set="trials.count=5").spec.trials.count == 5
    assert repr(program).startswith("<Program grasp-cartesian, floating: ")


def test_a_text_is_as_good_as_a_file() -> None:
    text = FLOATING.read_text("utf-8")
    assert g.loads(text).spec == g.load(FLOATING).spec
    assert g.loads(text, set=["trials.count=5"]).spec.trials.count == 5


def test_files_of_a_text_are_in_its_folder(tmp_path: Path) -> None:
    text = FLOATING.read_text("utf-8").replace("points", "mine.yaml")
    with pytest.raises(g.DiagnosticError, match=r"there is no file mine\.yaml"):
        g.loads(text, folder=tmp_path)
    (tmp_path / "mine.yaml").write_text("hand: mine\ncontacts: {}\n", "utf-8")
    with pytest.raises(g.DiagnosticError, match=r"mine\.yaml:2:11"):
        g.loads(text, folder=tmp_path)


FAULTS = {
    "a formula": ("π_s|Γ Γ (π_gx|Γ Γ)", "π_s|Γ Γ (π_g|Γ Γ)"),
    "a value": ("friction: 0.4", "friction: -1"),
    "two of them": ("friction: 0.4", "friction: -1\n  colour: red"),
    "YAML": ("parameters:", "parameters: {"),
}


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_the_text_of_an_error_is_what_the_command_line_prints(fault: str, tmp_path: Path) -> None:
    old, new = FAULTS[fault]
    faulty = tmp_path / "faulty.yaml"
    faulty.write_text(SPEC.read_text("utf-8").replace(old, new), "utf-8")
    printed = subprocess.run([PROGRAM, "validate", faulty], capture_output=True, encoding="utf-8", check=False)
    with pytest.raises(g.DiagnosticError) as refusal:
        g.load(faulty)
    assert f"{refusal.value}\n" == printed.stdout
    assert all(isinstance(found, g.Diagnostic) for found in refusal.value.diagnostics)


def test_a_file_that_is_not_there_is_refused() -> None:
    with pytest.raises(g.DiagnosticError, match=r"^nowhere\.yaml: error\[file-not-found\]: there is no such file"):
        g.load("nowhere.yaml")


def test_a_warning_is_one_of_pythons_that_says_where_it_was_asked_for(tmp_path: Path) -> None:
    with pytest.warns(g.SpecWarning, match=r"^spec\.yaml:\d+:\d+: warning\[leading-zero\]: 010 is read as 10") as told:
        g.loads(FLOATING.read_text("utf-8").replace("count: 20", "count: 010"))
    assert [warning.filename for warning in told] == [__file__]
    with pytest.warns(g.SpecWarning, match="leading-zero") as told:
        g.load(FLOATING, set=["trials.count=010"])
    assert [warning.filename for warning in told] == [__file__]
    odd = tmp_path / "spec.yaml"
    odd.write_text(FLOATING.read_text("utf-8").replace("count: 20", "count: 010"), "utf-8")
    with pytest.warns(g.SpecWarning, match="leading-zero") as told:
        g.run(odd, trials=1, progress=False)
    assert [warning.filename for warning in told] == [__file__]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        g.load(FLOATING)
