"""The page of a run: what it says, that it needs no other file, and that users' text stays text."""

from __future__ import annotations

import base64
import dataclasses
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from scipy import stats
from stored_runs import stored_run

from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.claims import Claim
from graspdsl.report.drawing import inline_svg, png_of, svg_of
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.figure_data import funnel_of
from graspdsl.report.figures import drawn_funnel
from graspdsl.report.judgements import Verdict
from graspdsl.report.outcomes import representatives
from graspdsl.report.page import drawings_of
from graspdsl.report.page import page as page_of
from graspdsl.report.page import write_report as write_report_of
from graspdsl.report.quality import quality
from graspdsl.report.run_tables import quality_tables
from graspdsl.report.statistics import wilson
from graspdsl.report.summary import plain, summarised
from graspdsl.report.writing import FIGURES, PAGE
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.store import RunFolder
from report.reader import Reader

pytestmark = pytest.mark.slow

SPECS = Path(__file__).resolve().parents[2] / "specs"
FLOATING = SPECS / "compare" / "moment_subject_to_force.yaml"
BULLET = SPECS / "towel_roll_two_contacts.yaml"
PICTURE = b"\x89PNG\r\n\x1a\n and so on"


def of_run(place: Path, spec: Path, *overrides: str, begun: bool = True) -> Evidence:
    """The evidence of a run of a spec; of one that never began where it is not to be run."""
    return evidence_of(stored_run(place, spec, *overrides, begun=begun))


@pytest.fixture(scope="module")
def floating(tmp_path_factory: pytest.TempPathFactory) -> Evidence:
    """A run of floating contacts that mostly converges."""
    return of_run(tmp_path_factory.mktemp("a") / "run", FLOATING, "trials.count=8")


def page(evidence: Evidence, **shown: Any) -> str:
    """The page of a run."""
    summary = summarised(evidence)
    return page_of(evidence, summary, drawings_of(evidence, summary), **shown)


@pytest.fixture(scope="module")
def shown(floating: Evidence) -> str:
    """The page of that run."""
    return page(floating)


def write_report(evidence: Evidence) -> Path:
    """The page of a run and its figures, written."""
    return write_report_of(evidence, summarised(evidence))


def read(text: str) -> Reader:
    """A page, which must be whole: every element closed, every link within it, nothing from elsewhere."""
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert len(set(reader.ids)) == len(reader.ids)
    here = [link for link in reader.links if not link.startswith("data:image/png;base64,")]
    assert all(link.startswith("#") and link[1:] in reader.ids for link in here)
    assert not re.search(r"url\((?!#)|@import|\b(?:src|href)=[\"']?(?:https?:)?//", text)
    reader.text = re.sub(r"\s+", " ", reader.text)
    return reader


def lowered(text: str) -> str:
    """A notation as the text of a page has it, its index an element of its own."""
    return re.sub(r"([ρε])_", r"\1", text)


def test_the_page_says_whether_it_worked_and_where_grasps_ended(floating: Evidence, shown: str) -> None:
    numbers, text = plain(summarised(floating)), read(shown).text
    good = numbers["outcomes"]["converged"]
    low, high = wilson(good, 8)
    assert f"{good} of 8 trials converged: {good / 8:.0%}".replace("%", " %") in text
    assert f"(95 % interval {100 * low:.0f} % to {100 * high:.0f} %)" in text
    for mode in numbers["modes"]:
        assert f"{mode['centre']:.2f}" in text
    for entry in numbers["outcome_table"]:
        assert entry["outcome"] in text
        assert entry["means"] in text
    assert numbers["command"] in text
    assert re.sub(r"\s+", " ", floating.folder.spec_text).strip() in text
    assert all(f"{name} {version}" in text for name, version in numbers["versions"].items())


def test_the_funnel_tells_the_bandwidths_of_its_densities(floating: Evidence, shown: str) -> None:
    """Silverman's rule, by the records alone; contacts that float all touch at the end."""
    told = re.search(r"bandwidth ([\d.]+) rad before and ([\d.]+) rad after", read(shown).text)
    assert told is not None
    for width, field in zip(told.groups(), ("orientation_start", "orientation_end"), strict=True):
        values = np.array([getattr(record, field) for record in floating.records])
        spread = min(np.std(values, ddof=1), stats.iqr(values) / 1.34)
        assert float(width) == pytest.approx(max(0.05, 0.9 * spread * len(values) ** -0.2), abs=5e-4)


def test_sections_come_in_their_order(shown: str) -> None:
    text = shown
    order = ("worked", "funnel-section", "residuals", "outcomes", "sensing", "priorities", "repeat", "trials")
    places = [text.index(f'<section id="{name}">') for name in order]
    assert places == sorted(places)
    assert '<section id="quality">' not in text


def test_every_trial_has_a_row_with_what_it_sorts_by(floating: Evidence, shown: str) -> None:
    rows = re.findall(r"<tr>(.*?)</tr>", shown.split('<section id="trials">')[1], re.DOTALL)[1:]
    assert len(rows) == len(floating.records)
    for row, record in zip(rows, floating.records, strict=True):
        keys = [float(key) for key in re.findall(r'data-key="([^"]*)"', row)]
        assert keys[0] == record.number
        assert keys[1:3] == pytest.approx([record.orientation_start, record.orientation_end])


def test_files_take_the_place_of_earlier_ones(floating: Evidence) -> None:
    folder = floating.folder.path
    assert write_report(floating) == folder / PAGE
    before = {file.name: file.read_bytes() for file in (folder / FIGURES).iterdir()}
    assert {"funnel.svg", "funnel.png", "residuals-mode-1.svg", "convergence.png"} <= set(before)
    (folder / FIGURES / "residuals-mode-9.svg").write_text("of an earlier report", "utf-8")
    (folder / PAGE).write_text("an earlier report", "utf-8")
    write_report(floating)
    assert {file.name: file.read_bytes() for file in (folder / FIGURES).iterdir()} == before
    assert (folder / PAGE).read_text("utf-8") == page(floating)
    assert not list(folder.rglob("*.new"))


def test_a_folder_that_cannot_be_written_to_keeps_what_it_had(tmp_path: Path) -> None:
    evidence = of_run(tmp_path / "run", FLOATING, "trials.count=1")
    (evidence.folder.path / FIGURES).write_text("no folder", "utf-8")
    with pytest.raises(DiagnosticError, match="cannot write to this folder"):
        write_report(evidence)
    assert not (evidence.folder.path / PAGE).exists()


def test_a_run_that_never_began_has_a_page(tmp_path: Path) -> None:
    text = read(page(of_run(tmp_path / "run", FLOATING, "trials.count=3", begun=False))).text
    assert "No trial has finished, so nothing is known." in text
    assert "Only 0 of 3 trials are finished." in text
    assert "<svg" not in page(evidence_of(RunFolder.open(tmp_path / "run")))


def test_one_trial_has_a_page(tmp_path: Path) -> None:
    evidence = of_run(tmp_path / "run", FLOATING, "trials.count=1")
    assert "of 1 trial converged" in read(page(evidence)).text


def test_a_single_contact_has_no_orientation_but_residuals(tmp_path: Path) -> None:
    settings = ('resources.Γ="{γ1}"', "trials.count=2", "program.0.limit=1.0")
    evidence = of_run(tmp_path / "run", FLOATING, *settings)
    assert not np.isfinite([record.orientation_end for record in evidence.records]).any()
    text = read(page(evidence)).text
    assert "No grasp had an orientation" in text
    assert "2 trials (the grasp has no orientation, as one contact alone has none)" in text
    assert "All trials: 2 trials. Line: mean over trials" in text


def test_trials_that_could_not_begin(floating: Evidence) -> None:
    """All of them, and then some of them."""
    never = {"outcome": Outcome.INFEASIBLE_START, "samples": 0, "ticks": 0, "ticks_to_converge": None}
    lost = [dataclasses.replace(record, touching=(), **never) for record in floating.records]
    text = read(page(dataclasses.replace(floating, records=tuple(lost), courses={}))).text
    assert "None of 8 trials could begin" in text
    assert "8 trials (no start was feasible)" in text
    courses = {number: course for number, course in floating.courses.items() if number >= 2}
    some = (*lost[:2], *floating.records[2:])
    assert (
        "2 trials could not begin; of the other 6,"
        in read(page(dataclasses.replace(floating, records=some, courses=courses))).text
    )


def test_a_contact_that_does_not_touch_at_the_end_leaves_a_trial_out(floating: Evidence) -> None:
    off, unknown, *others = floating.records
    off, unknown = (dataclasses.replace(off, touching=(True, False, True)), dataclasses.replace(unknown, touching=()))
    evidence = dataclasses.replace(floating, records=(off, unknown, *others))
    text = read(page(evidence)).text
    assert "1 trial (a contact did not touch at the end)" in text
    assert "1 trial (nothing was recorded of the end, or its trajectory cannot be read)" in text
    found = funnel_of(evidence, summarised(evidence))
    assert found is not None
    assert "settled after it, 6 trials" in drawn_funnel(found).svg


def test_a_run_on_a_grid_shows_its_map(tmp_path: Path) -> None:
    axes = "[{parameter: roll, low: -0.2, high: 0.2, cells: 2}, {parameter: height, low: 0.1, high: 0.12, cells: 1}]"
    settings = (f"trials.grid={axes}", "trials.count=2", "program.1.limit=0.5")
    evidence = of_run(tmp_path / "run", BULLET, *settings)
    text = read(page(evidence)).text
    assert "Starts lie on a grid and are not drawn at random" in text
    assert "The starts on the run's grid" in text
    unfinished = dataclasses.replace(evidence, records=evidence.records[:1])
    assert "The starts on the run's grid" not in read(page(unfinished)).text


def test_probes_are_called_probes(tmp_path: Path) -> None:
    evidence = of_run(tmp_path / "run", SPECS / "compare" / "probing.yaml", "trials.count=1", "program.1.limit=4.0")
    text = read(page(evidence)).text
    assert "a tick is a probe" in text
    assert "probes since the controller took over" in text
    assert "controller ticks" not in text


def test_text_of_users_stays_text(tmp_path: Path) -> None:
    settings = ("about=<script>alert(1)</script> $x$", "scene.object.name=<script>alert(2)</script>", "trials.count=1")
    evidence = of_run(tmp_path / "<b>", FLOATING, *settings)
    detailed = dataclasses.replace(evidence.records[0], detail="<script>alert(3)</script>")
    whole = page(dataclasses.replace(evidence, records=(detailed,)))
    assert whole.count("<script") == 1
    text = read(whole).text
    assert all(f"<script>alert({place})</script>" in text for place in (1, 2, 3))


def test_a_picture_of_a_trial_for_each_outcome(floating: Evidence) -> None:
    (outcome, record), *others = representatives(floating.records).items()
    whole = page(floating, frames={outcome: PICTURE, "no-such-outcome": PICTURE})
    assert whole.count("<img") == 1
    assert f'src="data:image/png;base64,{base64.b64encode(PICTURE).decode()}"' in whole
    assert f"{outcome}: trial {record.number} at its end" in read(whole).text
    assert len(others) == len(summarised(floating).outcomes) - 1


def test_claims_are_shown_with_what_was_measured(floating: Evidence, shown: str) -> None:
    said = ("<1> one mode", "Fig. 1", "all", "90 %", "so", "two")
    row = Claim("experiment-1", *said, Verdict.DIFFERS, None, "friction", "slippery")
    text = read(page(floating, claims=[dataclasses.replace(row, verdict=verdict) for verdict in Verdict])).text
    cells = (said[0], said[2], said[3], said[5], Verdict.DIFFERS.mark, "friction")
    assert re.search(r"\s*".join(map(re.escape, cells)), text)
    assert all(verdict.mark in text and verdict.mark not in shown for verdict in Verdict)


def test_quality_is_shown_side_by_side(floating: Evidence) -> None:
    """Of the first grasps all are graded: some have closure, some were dropped, for a reason that users may write."""
    good = {"closed": True, "margin": {"value": 0.1, "reason": ""}, "reason": ""}
    bad = {"closed": False, "margin": {"value": None, "reason": ""}, "reason": "<no contact>"}
    kept, dropped = (
        {"kept": not reason, "reason": reason, "borne": {"value": None if reason else 1.0, "reason": reason}}
        for reason in ("", "slipped")
    )
    grades = [(good, kept), (good, dropped), (good, kept), (bad, dropped)]
    records = tuple(
        dataclasses.replace(record, quality={"force-closure": closure, "lift": lift})
        for record, (closure, lift) in zip(floating.records, grades, strict=False)
    )
    counted = quality(records)
    verdicts, margins, borne, together, by_outcome = quality_tables(counted)
    assert [[cell.text for cell in row] for row in margins.cells()] == [["margin", "0.1", "0.1 … 0.1", "3"]]
    assert [[cell.text for cell in row][:3] for row in verdicts.cells()] == [
        ["force closure", "3", "4"],
        ["lift", "2", "4"],
    ]
    assert [row[-1].text for row in verdicts.cells()] == ["<no contact> (1)", "slipped (2)"]
    assert [cell.text for cell in borne.cells()[0]] == ["weight borne by the contacts when lifted", "1", "1 … 1", "2"]
    assert sum(int(row[-1].text) for row in together.cells()) == 4
    assert {row[1].text + row[2].text for row in together.cells()} == {"yesyes", "yesno", "nono"}
    assert sum(int(row[1].text) for row in by_outcome.cells()) == 4
    text = read(page(dataclasses.replace(floating, records=records))).text
    assert "Quality of the final grasps" in text
    assert "<no contact> (1)" in text


def test_what_was_not_graded_has_no_table() -> None:
    assert quality_tables(quality([])) == []


def test_users_text_in_figures_is_no_notation() -> None:
    """Dollars, digits, colours and quotes of a label come out as they went in; so they do in the picture."""
    said = 'cost $5$ 0.12345 #ffffff id="x" <b>'
    figure = Figure((3.0, 1.0))
    figure.text(0.1, 0.5, said, parse_math=False)
    figure.text(0.1, 0.1, "‖ρ$_f$‖")
    reader = Reader()
    reader.feed(inline_svg(svg_of(figure, "a"), "a", r"a label \1"))
    assert said in reader.text
    assert lowered("‖ρ_f‖") in reader.text
    assert png_of(figure) == png_of(figure)
    assert figure.texts[0].get_text() == said
