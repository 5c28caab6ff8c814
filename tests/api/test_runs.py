"""Runs in Python: made, saved, opened, gone on with; and what is known of one, of whatever kind it is."""

from __future__ import annotations

import gc
import io
import json
import re
import sqlite3
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest
import rich.console
from matplotlib.figure import Figure

import graspdsl as g
from graspdsl.report.page import drawings_of
from graspdsl.report.summary import plain
from graspdsl.trials.store import TABLE, TRAJECTORIES
from graspdsl.trials.trajectories import CHANNELS

ROOT = Path(__file__).resolve().parents[2]
FLOATING = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
TRIALS = 4


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> g.Run:
    """A finished run of floating contacts; not to be changed."""
    place = tmp_path_factory.mktemp("api") / "run"
    return g.run(FLOATING, trials=TRIALS, seed=7, workers=1, out=place, progress=False)


# Made


def test_it_is_the_run_that_the_command_line_makes(run: g.Run, tmp_path: Path) -> None:
    program = Path(sys.executable).with_name("graspdsl")
    words = ["run", FLOATING, "--trials", str(TRIALS), "--seed", "7", "--workers", "1", "--out", "run", "--json"]
    done = subprocess.run([program, *words], cwd=tmp_path, capture_output=True, encoding="utf-8", check=True)
    of_command, of_python = json.loads(done.stdout), plain(run.summary)
    for summary in (of_command, of_python):
        for record in summary["records"]:
            record["wall_s"] = 0.0
        summary |= {"wall_s": 0.0, "run": "", "command": ""}
    assert of_command == json.loads(json.dumps(of_python))
    manifests = [json.loads((folder / "run.json").read_text("utf-8")) for folder in (run.path, tmp_path / "run")]
    assert manifests[0] | {"wall_s": 0.0} == manifests[1] | {"wall_s": 0.0}


def test_trials_and_seed_stand_in_for_those_of_the_program(run: g.Run) -> None:
    program = g.load(FLOATING, set=["trials.count=3"])
    assert len(g.run(program, progress=False).trials) == 3
    two = g.run(program, trials=np.int64(2), seed=7, progress=False)
    assert [trial.identity for trial in two.trials] == [trial.identity for trial in list(run.trials)[:2]]
    with pytest.raises(g.DiagnosticError, match=r"^4_30_grasp_cartesian\.yaml.*trials\.count=0"):
        g.run(program, trials=0)


@pytest.mark.parametrize("workers", [0, -1, 1025])
def test_less_than_one_worker_is_refused_before_there_is_a_folder(run: g.Run, tmp_path: Path, workers: int) -> None:
    with pytest.raises(ValueError, match=f"workers: expected from 1 to 1024 processes, found {workers}"):
        g.run(FLOATING, workers=workers, out=tmp_path / "run", progress=False)
    assert not (tmp_path / "run").exists()
    with pytest.raises(ValueError, match="workers: "):
        g.resume(run.path, workers=workers, progress=False)


def test_nothing_is_left_of_a_run_without_a_folder() -> None:
    kept = g.run(FLOATING, trials=1, progress=False)
    path = kept.path
    assert (path / "run.json").exists()
    del kept
    gc.collect()
    assert not path.parent.exists()


def test_nothing_is_left_of_one_that_could_not_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def fail(_: object) -> None:
        raise KeyError

    with pytest.raises(KeyError):
        g.run(FLOATING, trials=1, progress=fail)
    assert list(tmp_path.iterdir()) == []


def test_a_run_can_be_saved(tmp_path: Path) -> None:
    passing = g.run(FLOATING, trials=2, progress=False)
    passing.report()
    saved = passing.save(tmp_path / "runs" / "x")
    del passing
    gc.collect()
    assert saved.path == tmp_path / "runs" / "x"
    assert (saved.path / "report.html").exists()
    assert len(g.open_run(saved.path).trials) == 2
    assert saved.trajectory(1)["time"].shape == saved.trajectory(1)["phase"].shape
    with pytest.raises(g.DiagnosticError, match=r"folder-not-empty"):
        saved.save(tmp_path / "runs" / "x")
    (tmp_path / "file").touch()
    with pytest.raises(g.DiagnosticError, match=r"^\S+file: error\[folder-not-writable\]"):
        saved.save(tmp_path / "file")


def test_a_folder_that_is_taken_is_refused(run: g.Run) -> None:
    with pytest.raises(g.DiagnosticError, match=rf"^{re.escape(str(run.path))}: error\[folder-not-empty\]"):
        g.run(FLOATING, out=run.path)


def test_progress_is_said_on_stderr(capsys: pytest.CaptureFixture[str]) -> None:
    g.run(FLOATING, trials=2)
    said = capsys.readouterr()
    assert said.out == ""
    assert [line.split()[1] for line in said.err.splitlines()] == ["1/2", "2/2"]
    g.run(FLOATING, trials=2, progress=False)
    assert capsys.readouterr().err == ""


def test_progress_may_be_told_to_a_function() -> None:
    told: list[tuple[int, str]] = []
    run = g.run(FLOATING, trials=3, progress=lambda record: told.append((record.number, record.outcome)))
    assert sorted(told) == [(record.number, record.outcome) for record in run.trials]


def _stopped_after(count: int, place: Path) -> None:
    """A run that the user stops after so many trials."""

    def stop(record: object) -> None:
        told.append(record)
        if len(told) == count:
            raise KeyboardInterrupt

    told: list[object] = []
    g.run(FLOATING, trials=TRIALS, seed=7, workers=1, out=place, progress=stop)


def test_an_interrupted_run_goes_on(run: g.Run, tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt) as stopped:
        _stopped_after(2, tmp_path / "run")
    [note] = stopped.value.__notes__
    assert note == f"finished trials are kept; to go on: graspdsl.resume({str(tmp_path / 'run')!r})"
    assert len(g.open_run(tmp_path / "run").trials) == 2
    whole = g.resume(tmp_path / "run", progress=False)
    assert [trial.identity for trial in whole.trials] == [trial.identity for trial in run.trials]
    np.testing.assert_array_equal(whole.trajectory(3)["points"], run.trajectory(3)["points"])
    assert len(g.resume(tmp_path / "run", progress=False).trials) == TRIALS


def test_an_interrupted_run_without_a_folder_says_that_nothing_is_kept() -> None:
    def stop(_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        g.run(FLOATING, trials=2, progress=stop)
    assert stopped.value.__notes__ == ["nothing is kept: name a folder, out=…, to be able to go on"]


# Opened


def test_what_is_no_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(g.DiagnosticError, match=r"nowhere: error\[folder-not-found\]"):
        g.open_run(tmp_path / "nowhere")
    with pytest.raises(g.DiagnosticError, match=r"error\[not-a-run\]"):
        g.open_run(tmp_path)
    with pytest.raises(g.DiagnosticError, match=r"error\[folder-not-found\]"):
        g.resume(tmp_path / "nowhere")


def test_a_run_of_another_version_is_warned_of(run: g.Run, tmp_path: Path) -> None:
    old = run.save(tmp_path / "old")
    manifest = json.loads((old.path / "run.json").read_text("utf-8"))
    manifest["versions"]["graspdsl"] = "0.0.1"
    (old.path / "run.json").write_text(json.dumps(manifest), "utf-8")
    with pytest.warns(g.SpecWarning, match=r"warning\[run-unchecked\]: this run was made by graspdsl 0\.0\.1") as told:
        g.open_run(old.path)
    assert [warning.filename for warning in told] == [__file__]


# What is known of one


def test_trials_are_found_by_number(run: g.Run, tmp_path: Path) -> None:
    assert (len(run.trials), [trial.number for trial in run.trials]) == (TRIALS, list(range(TRIALS)))
    assert run.trials[3].number == 3
    assert run.trials[3].outcome == "converged"
    part = run.save(tmp_path / "part")
    with sqlite3.connect(part.path / TABLE) as table:
        table.execute("DELETE FROM trials WHERE number = 1")
    part = g.open_run(part.path)
    assert part.trials[3].number == 3
    assert (3 in part.trials, 1 in part.trials) == (True, False)
    assert repr(part.trials) == "<Trials: 0 converged, 2 converged, 3 converged>"
    for look in (part.trials.__getitem__, part.trajectory):
        with pytest.raises(IndexError, match="trial 1 is not among the 3 that are finished"):
            look(1)


def test_a_trajectory_is_arrays_with_units(run: g.Run) -> None:
    found = run.trajectory(3)
    assert found["force_residual"].shape == found["time"].shape
    assert (found.units["force_residual"], found.units["moment_residual"], found.units["forces"]) == ("1", "m", "N")
    assert found.units.keys() == found.about.keys() == found.axes.keys() == {*found} == CHANNELS.keys()
    assert len(found) == len(CHANNELS)
    sizes = {"ticks": len(found["time"]), "contacts": 8, "joints": 0, "levels": 1}
    for name, axes in found.axes.items():
        assert found[name].shape == tuple(sizes[axis] if isinstance(axis, str) else axis for axis in axes)
    with pytest.raises(ValueError, match="read-only"):
        found["time"][0] = 1.0
    assert "forces (" in repr(found)
    with pytest.raises(KeyError, match="there is no 'force_residul'; did you mean force_residual"):
        found["force_residul"]


def test_columns_are_arrays_with_units(run: g.Run) -> None:
    found = run.columns()
    assert found.units.keys() == found.keys()
    assert {array.shape for array in found.values()} == {(TRIALS,)}
    assert found["outcome"].tolist() == [trial.outcome for trial in run.trials]
    np.testing.assert_array_equal(found["force_residual_end"], [trial.force_residual_end for trial in run.trials])
    assert isinstance(found, dict)
    assert repr(found).startswith(f"<Columns of {TRIALS} trials: number [1], identity, outcome, ")
    with pytest.raises(KeyError, match="there is no 'outcom'; did you mean outcome"):
        found["outcom"]


def test_columns_are_a_dataframe(run: g.Run) -> None:
    frame, columns = run.to_dataframe(), run.columns()
    assert list(frame.columns) == list(columns)
    assert frame.attrs["units"] == columns.units
    np.testing.assert_array_equal(frame["moment_residual_end"].to_numpy(), columns["moment_residual_end"])
    assert frame.groupby("outcome").size()["converged"] == TRIALS


def test_without_pandas_it_is_said_what_to_install(run: g.Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)  # as Python has it where there is none
    with pytest.raises(ImportError, match=r'to_dataframe needs pandas: pip install "graspdsl\[pandas\]"'):
        run.to_dataframe()


@pytest.mark.slow
def test_figures_have_names(run: g.Run) -> None:
    assert run.figures == [drawing.name for drawing in drawings_of(run.evidence, run.summary)]
    assert "funnel" in run.figures
    first, second = run.figure("funnel"), run.figure("funnel")
    assert isinstance(first, Figure)
    assert first is not second
    first.savefig(io.BytesIO(), format="png")
    assert first._repr_png_().startswith(b"\x89PNG")  # what a notebook asks for
    with pytest.raises(g.DiagnosticError, match=r"has no figure 'funel'\n  hint: did you mean funnel\?"):
        run.figure("funel")
    with pytest.raises(g.DiagnosticError, match=r"hint: known figures: convergence, funnel, residuals-mode-1"):
        run.figure("picture")


def test_figures_need_no_pyplot() -> None:
    code = (
        "import graspdsl as g, sys; g.open_run(sys.argv[1]).figure('funnel'); "
        "sys.exit('matplotlib.pyplot' in sys.modules or 'matplotlib' not in sys.modules)"
    )
    place = g.run(FLOATING, trials=1, progress=False)
    done = subprocess.run([sys.executable, "-c", code, str(place.path)], check=False)
    assert done.returncode == 0


def test_the_report_is_written_beside_it(run: g.Run) -> None:
    page = run.report()
    assert page == run.path / "report.html"
    assert run.name in page.read_text("utf-8")
    assert run.claims == []


def test_the_summary_nests_as_its_json_does(run: g.Run) -> None:
    data = plain(run.summary)["converged"]
    assert data["share"] == run.summary.converged.share == 1.0
    assert data["interval"] == list(run.summary.converged.interval)
    assert run.summary.outcomes == {"converged": TRIALS}


# Shown


def _shown(run: g.Run) -> str:
    """What every way to show it says, without tags."""
    console = rich.console.Console(file=io.StringIO(), width=120)
    console.print(run)
    assert isinstance(console.file, io.StringIO)
    return " ".join([repr(run), console.file.getvalue(), re.sub(r"<[^>]*>", " ", run._repr_html_())])


def test_a_run_is_shown(run: g.Run) -> None:
    assert repr(run) == f"<Run grasp-cartesian, seed 7: 4 of 4 trials finished, 4 converged; {run.path}>"
    said = _shown(run)
    assert said.count("4 of 4 trials converged: 100 %") == 2
    assert run.summary.command in " ".join(said.split())
    html = run._repr_html_()
    assert '<img alt="' in html
    assert "data:image/svg+xml;base64," in html


@pytest.mark.slow
def test_a_run_without_trials_is_shown(tmp_path: Path) -> None:
    def stop(_: object) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        g.run(FLOATING, trials=3, seed=7, workers=1, out=tmp_path / "run", progress=stop)
    with sqlite3.connect(tmp_path / "run" / TABLE) as table:
        table.execute("DELETE FROM trials")
    empty = g.open_run(tmp_path / "run")
    assert "0 of 3 trials finished" in _shown(empty)
    assert "No trial has finished" in _shown(empty)
    assert (empty.figures, empty.summary.converged.share) == ([], None)
    assert {array.shape for array in empty.columns().values()} == {(0,)}
    assert empty.columns().units.keys() >= {"outcome", "wall_s"}
    assert empty.to_dataframe().shape[0] == 0
    assert empty.report().exists()
    with pytest.raises(g.DiagnosticError, match="there are no known figures here"):
        empty.figure("funnel")


@pytest.mark.slow
def test_an_interrupted_run_is_shown(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        _stopped_after(2, tmp_path / "run")
    part = g.open_run(tmp_path / "run")
    assert "2 of 4 trials finished" in _shown(part)
    assert "Only 2 of 4 trials are finished." in _shown(part)


@pytest.mark.slow
def test_a_run_of_one_trial_is_shown() -> None:
    assert "1 of 1 trial converged" in _shown(g.run(FLOATING, trials=1, progress=False))


@pytest.mark.slow
def test_a_run_with_lost_trajectories_is_shown(run: g.Run, tmp_path: Path) -> None:
    lost = run.save(tmp_path / "lost")
    for file in (lost.path / TRAJECTORIES).iterdir():
        file.write_bytes(b"lost")
    lost = g.open_run(lost.path)
    assert "4 of 4 trials converged" in _shown(lost)
    assert lost.columns()["outcome"].tolist() == ["converged"] * TRIALS
    with pytest.raises(g.DiagnosticError, match=r"error\[run-damaged\]: .* trajectories/000000-000999\.npy\.gz"):
        lost.trajectory(2)


@pytest.mark.slow
def test_what_a_name_holds_is_escaped(tmp_path: Path) -> None:
    """A folder may be called anything."""
    place = tmp_path / "<b>[red]run"
    run = g.run(FLOATING, trials=1, out=place, progress=False)
    assert "<b>" not in run._repr_html_()
    console = rich.console.Console(file=io.StringIO(), width=500)
    console.print(run)
    assert isinstance(console.file, io.StringIO)
    assert "<b>[red]run" in console.file.getvalue()
