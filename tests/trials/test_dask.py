"""Trials on a Dask cluster: what they are, and what becomes of them where parts of it are lost, or are not as here."""

from __future__ import annotations

import dataclasses
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import pytest
from compiler.specs import floating
from plugins.packages import HUBER

from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials import dask_crew
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.workers import Dask, sharing

from .test_runner import HARM

pytestmark = pytest.mark.slow

THREE = "{γ1, γ2, γ3}"
SPEC = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    """Two processes on this machine that know nothing of this one."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=":0", memory_limit=None) as two:
        yield two


def floats(count: int) -> Program:
    """A program of trials that take a moment."""
    return program_of(floating() + f"trials: {{count: {count}}}\n", "spec.yaml")


def numbers(folder: RunFolder) -> dict[int, tuple[str, bytes]]:
    """All that is kept of each trial but for the time that it took, by numbers."""
    content = {piece.number: folder.packs.content(piece) for piece in folder.pieces()}
    records = {record.number: repr(dataclasses.replace(record, wall_s=0.0)) for record in folder.records()}
    return {number: (record, content[number]) for number, record in records.items()}


def by_one(folder: RunFolder, program: Program) -> dict[int, tuple[str, bytes]]:
    """What a run is by one process, here."""
    whole = new_run(folder.path.with_name("whole"), program)
    execute(whole, 1)
    return numbers(whole)


@pytest.mark.parametrize("world", ["floating", "mujoco"])
def test_numbers_are_those_of_one_process(world: str, cluster: Any, tmp_path: Path) -> None:
    short = ("trials.count=3", "scene.world=mujoco", "program.1.limit=0.5", "evaluate=[]")
    program = floats(40) if world == "floating" else program_of(SPEC.read_text("utf-8"), SPEC.name, short)
    folder, seen = new_run(tmp_path / "run", program), list[TrialRecord]()
    execute(folder, Dask(cluster.scheduler_address), seen.append)
    assert numbers(folder) == by_one(folder, program)
    assert len(seen) == program.spec.trials.count


def test_a_trial_that_ends_or_stops_its_process_has_crashed(cluster: Any, tmp_path: Path) -> None:
    """It is run twice; all others are what they are without it. Code of a spec's own comes along."""
    (tmp_path / "harm.py").write_text(f"{HUBER}\n{HARM}", "utf-8")
    text = floating(f"φ_h|τ_frx({THREE}) σ_fr({THREE})", until="force_residual: 0.05")
    text += "code: [harm.py]\ntrials: {count: 12, wall_limit: 1.5}\n"
    program = program_of(text, "spec.yaml", (), tmp_path, allow_code=True)
    folder = new_run(tmp_path / "run", program)
    execute(folder, Dask(cluster.scheduler_address))
    found, whole = numbers(folder), by_one(folder, program)
    crashed = {record.number: record.detail for record in folder.records() if record.outcome is Outcome.CRASHED}
    assert crashed.keys() == {3, 11}
    assert re.fullmatch(r"its process ended, 2 times: the Dask worker tcp://\S+ is lost", crashed[3])
    assert crashed[11] == "its process ended, 2 times: after more than 1.5 s, trials.wall_limit"
    assert all(found[number] == whole[number] for number in whole if number not in crashed)


def test_a_scheduler_that_goes_away_leaves_what_is_finished(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("graspdsl.trials.dask_crew.most_together", lambda _: 10)
    place = tmp_path / "scheduler.json"
    options = ("--scheduler-file", str(place), "--no-dashboard", "--host", "127.0.0.1")
    program, dask = floats(60), (sys.executable, "-m", "dask")
    folder = new_run(tmp_path / "run", program)
    scheduler = subprocess.Popen([*dask, "scheduler", "--port", "0", *options], stderr=subprocess.DEVNULL)
    worker = subprocess.Popen([*dask, "worker", "--nthreads", "1", *options], stderr=subprocess.DEVNULL)
    try:
        while not place.exists():
            assert scheduler.poll() is None
        with pytest.raises(DiagnosticError, match=r"^the Dask scheduler tcp://\S+ has gone away$"):
            execute(folder, Dask(str(place)), lambda _: os.kill(scheduler.pid, signal.SIGKILL))
    finally:
        for process in (scheduler, worker):
            process.kill()
            process.wait()
    kept = numbers(folder)
    assert 0 < len(kept) < 60
    execute(folder, 1)
    assert numbers(folder) == by_one(folder, program)


@pytest.mark.parametrize("late", [False, True], ids=["there", "joins later"])
def test_workers_with_other_versions_are_refused(
    late: bool, cluster: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = new_run(tmp_path / "run", floats(4))
    wanted = {"numpy": metadata.version("numpy"), "kit_of_nobody": "2"}
    monkeypatch.setattr(dask_crew, "versions", lambda _: {"graspdsl": metadata.version("graspdsl"), **wanted})
    if late:
        monkeypatch.setattr(dask_crew.DaskCrew, "_check_versions", lambda _: None)
    with pytest.raises(DiagnosticError) as caught:
        execute(folder, Dask(cluster.scheduler_address))
    (said,) = caught.value.diagnostics
    assert said.code == "workers-differ"
    assert re.fullmatch(r"the Dask worker tcp://\S+ has no kit_of_nobody; here there is kit_of_nobody 2", said.message)
    assert said.hint == "install there: kit_of_nobody==2"
    assert folder.records() == []


def test_without_distributed_it_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(DiagnosticError, match=r"^Dask needs distributed$") as caught:
        execute(new_run(tmp_path / "run", floats(4)), Dask(workers=1))
    assert caught.value.diagnostics[0].hint == "pip install 'graspdsl[dask]'; or leave --engine out"


def test_who_shares_trials() -> None:
    assert sharing(2, "local", None) == 2
    assert sharing(2, "dask", None) == Dask(workers=2)
    assert sharing(None, "dask", "tcp://there:8786") == Dask("tcp://there:8786")
    for given in ((None, "local", "tcp://there:8786"), (2, "dask", "tcp://there:8786"), (None, "slurm", None)):
        with pytest.raises(ValueError, match=r"scheduler|engine"):
            sharing(*given)
