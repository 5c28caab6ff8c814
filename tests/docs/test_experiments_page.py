"""The page on the experiments has the claims that the code has, each with how it could fail and what seeds say."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

from graspdsl.report.experiment_runs import largest_tilt
from graspdsl.report.judgements import Verdict
from graspdsl.report.points import EXPERIMENTS

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "experiments.md").read_text("utf-8")
BLOCKS = dict(re.findall(r"<!-- (\w+) -->\n(.*?)<!-- end -->", PAGE, flags=re.S))
SAID = [point.says for points in EXPERIMENTS.values() for point in points]


def test_the_claims_are_those_of_the_code() -> None:
    """Run docs/render_experiments.py where they are not."""
    script = runpy.run_path(str(DOCS / "render_experiments.py"))
    assert script["filled"](PAGE, {"claims": script["claims_table"]()}) == PAGE


def test_every_claim_has_a_verdict_at_three_seeds() -> None:
    rows = [line.strip("| ").split(" | ") for line in BLOCKS["results"].splitlines() if line.startswith("|")]
    claims = [row for row in rows if row[0] in SAID]
    assert [row[0] for row in claims] == SAID
    marks = tuple(verdict.mark for verdict in Verdict)
    assert all(len(row) == 5 and all(cell.startswith(marks) for cell in row[2:]) for row in claims)
    heads = [row for row in rows if row[0] == "the chapter says"]
    assert len({tuple(re.findall(r"seed \d+", " ".join(row))) for row in heads}) == 1


def test_controllers_that_cannot_do_it_are_told_from_the_one_that_can() -> None:
    """Where trials are few, what is not told is not taken to agree."""
    rows = [line for line in BLOCKS["changed"].splitlines() if any(says in line for says in SAID)]
    assert len(rows) == len(EXPERIMENTS["experiment-1"])


def test_the_tilt_that_the_bounds_leave_is_what_the_page_says() -> None:
    assert f"{largest_tilt(0.1, 0.005, 0.1):.3f} rad of perpendicular" in " ".join(PAGE.split())
