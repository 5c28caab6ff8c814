"""What of a run is read for what is said of it: its records once, and no trajectory for its summary."""

from __future__ import annotations

from pathlib import Path

import pytest
from stored_runs import lose_trajectory, stored_run
from typer.testing import CliRunner

from graspdsl.api.runs import opened
from graspdsl.cli.app import app
from graspdsl.report.evidence import MOST_COURSES, evidence_of
from graspdsl.report.writing import PAGE
from graspdsl.trials import store
from graspdsl.trials.record import PackedTrial
from graspdsl.trials.replay import Replay
from graspdsl.trials.store import RunFolder

SPEC = Path(__file__).parents[2] / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
COUNT = 4


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """A finished run; not to be changed."""
    return stored_run(tmp_path_factory.mktemp("made") / "run", SPEC, f"trials.count={COUNT}")


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What is made of rows and of packs, one after the other."""
    found: list[str] = []
    for name in ("record_of", "unpacked"):
        does = getattr(store, name)
        monkeypatch.setattr(store, name, lambda *given, name=name, does=does: (found.append(name), does(*given))[1])
    return found


def test_a_finished_run_is_summed_up_by_its_records_alone_each_made_once(made: RunFolder, read: list[str]) -> None:
    run, _ = opened(made.path)
    assert len(run.folder.finished()) == run.summary.finished == run.summary.modes[0].of == COUNT
    assert read == ["record_of"] * COUNT
    assert len(run.evidence.courses) == read.count("unpacked") == COUNT


def test_a_record_that_has_changed_is_made_anew(tmp_path: Path) -> None:
    folder = stored_run(tmp_path / "run", SPEC, "trials.count=2")
    before = folder.records()
    with folder.table() as table:
        table.execute("UPDATE trials SET detail = 'changed' WHERE number = 1")
    assert [record.detail for record in folder.records()] == ["", "changed"]
    assert folder.records()[0] is before[0]


def test_a_picture_takes_one_record(made: RunFolder, read: list[str]) -> None:
    with Replay(RunFolder.at(made.path), 2) as replay:
        assert replay.record.number == 2
    assert read == ["record_of", "unpacked"]


def test_trials_that_are_lost_are_known_without_unpacking_any(tmp_path: Path, read: list[str]) -> None:
    folder = stored_run(tmp_path / "run", SPEC, "trials.count=3")
    lose_trajectory(folder, 1)
    evidence = evidence_of(folder)
    assert evidence.lost == {1}
    assert "unpacked" not in read
    assert evidence.courses.keys() == {0, 2}


def test_of_very_many_trials_some_courses_are_read(made: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
    assert MOST_COURSES >= COUNT
    monkeypatch.setattr("graspdsl.report.evidence.MOST_COURSES", COUNT // 2)
    assert list(evidence_of(made).courses) == [0, 2]


def test_the_page_of_a_finished_run_is_made_anew_only_where_trials_have_come_since(tmp_path: Path) -> None:
    folder = stored_run(tmp_path / "run", SPEC, "trials.count=2")
    page, words = folder.path / PAGE, ["run", "--resume", str(folder.path)]
    for left in (False, True):
        page.write_text("as it was left", "utf-8")
        if not left:
            folder.add(PackedTrial(folder.records()[1], folder.packs.content(folder.pieces(1)[0])))
        answer = CliRunner().invoke(app, words)
        assert answer.stderr.endswith(f"report: {page}\n")
        assert (page.read_text("utf-8") == "as it was left") is left
