"""What a report says of priorities: which level was disturbed, how far, when and by what."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from stored_runs import stored_run

from graspdsl.compiler.explain import explained
from graspdsl.compiler.program import Program, program_of, program_of_expression
from graspdsl.report.evidence import evidence_of
from graspdsl.report.page import drawings_of, page
from graspdsl.report.priorities import LevelSummary, Worst, priorities_table
from graspdsl.report.summary import plain, summarised
from graspdsl.trials.runner import execute, new_run

SPEC = Path(__file__).parents[2] / "specs" / "compare" / "moment_subject_to_force.yaml"
VIRTUAL = 'resources.Γ="{γ1, <γ2, γ3>}"'


def reported(folder: Path, *overrides: str) -> tuple[Program, dict[str, object], str, set[str]]:
    """A run of three trials: its program, what JSON has of its priorities, its page and the names of its figures."""
    program = program_of(SPEC.read_text("utf-8"), SPEC.name, ("trials.count=3", "program.0.limit=1.0", *overrides))
    run = new_run(folder / "run", program)
    execute(run, workers=1)
    evidence = evidence_of(run)
    summary, drawings = summarised(evidence), drawings_of(evidence, summarised(evidence))
    told = json.loads(json.dumps(plain(summary)["priorities"]))
    largest = max(record.priorities[0].observed.size for record in evidence.records)
    assert told["levels"][0]["observed"]["largest"] == largest
    rows = run.trajectory(told["levels"][0]["observed"]["trial"])["observed_disturbance"]
    assert np.nanmax(rows) == pytest.approx(largest, rel=1e-6)
    return program, told["levels"], page(evidence, summary, drawings), {drawing.name for drawing in drawings}


@pytest.mark.slow
def test_a_run_says_which_level_was_disturbed(tmp_path: Path) -> None:
    _, (level,), text, figures = reported(tmp_path, VIRTUAL)
    assert (level["level"], level["stage"], level["plain_sum"], level["trials"]) == ("φ_fr", 0, False, 3)
    assert f"in trial {level['observed']['trial']} after" in text
    assert "one direction of what it moves" in text
    assert "priorities" in figures


@pytest.mark.slow
def test_of_a_plain_sum_there_is_nothing_to_certify(tmp_path: Path) -> None:
    _, (level,), text, figures = reported(tmp_path)
    assert level["plain_sum"]
    assert "there is nothing to certify" in text
    assert "was disturbed by" not in text
    assert "priorities" not in figures


def test_a_sentence_has_its_units() -> None:
    seen = Worst(0.312, "N", 12, 170, 3.4, "a contact lost or found", 0.021)
    command = Worst(1.2e-5, "m", 3, 9, 0.2, "lower priorities", 1e-6)
    level = LevelSummary(1, 0, "φ_f", "contact forces", "", False, 7, 58, command, seen, 900.0)
    assert level.said("tick") == (
        "φ_f (contact forces) was disturbed by up to 0.31 N in one tick, in trial 12 after 3.4 s, by a contact lost or "
        "found; in the median trial by up to 0.021 N. By its Jacobian the command disturbs it by up to 0.012 mm of "
        "pressing, mostly by lower priorities."
    )


@pytest.mark.slow
def test_levels_of_one_symbol_are_told_apart_by_their_stages(tmp_path: Path) -> None:
    chain = "φ_mr|τ_mrx(Γ_τ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ_τ) σ_fr(Γ)"
    few = (
        "trials.count=1",
        "program.0.until={contact: all, hold: 0.2}",
        "resources.Γ_τ='{γ1, γ2}'",
        f"program.0.run={chain} then {chain}",
    )
    folder = stored_run(tmp_path / "run", SPEC.with_name("cstar.yaml"), *few)
    levels = summarised(evidence_of(folder)).priorities
    assert [level.name for level in levels.levels] == ["φ_fr in stage 1", "φ_fr in stage 2"]
    assert [row[0] for row in priorities_table(levels).rows[::2]] == ["φ_fr in stage 1", "φ_fr in stage 2"]
    assert levels.levels[1].said("tick").startswith("φ_fr in stage 2 (net unit force) was disturbed")


@pytest.mark.parametrize(("nullspace", "said"), [("gradient", "one direction"), ("task", "all that it senses")])
def test_explain_says_what_is_protected_and_what_is_measured(nullspace: str, said: str) -> None:
    text = SPEC.with_name("sliding.yaml").read_text("utf-8")
    program = program_of(text, "sliding.yaml", (f"control.nullspace={nullspace}",))
    explanation = explained(program)[-1]
    assert [line.partition(" is kept")[0] for line in explanation.protected()] == ["of φ_fr", "of φ_f"]
    assert all(said in line for line in explanation.protected())
    assert explanation.as_dict()["priorities"] == explanation.protected()
    certified = [line for line in explanation.text().splitlines() if "certified:" in line]
    assert [line.split()[1].rstrip(",") for line in certified] == ["φ_fr", "φ_f"]
    assert "does not reach" not in explanation.text()


def test_explain_of_one_level_has_no_priority() -> None:
    [explanation] = explained(program_of_expression("π_close|Γ Γ"))
    assert explanation.protected() == []
    assert "certified" not in explanation.text()
