"""Many trials: what is done when one of them, a worker or the user of the results fails."""

from __future__ import annotations

import dataclasses
import multiprocessing
import re
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest
from compiler.specs import floating
from plugins.packages import HUBER

from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.report.evidence import evidence_of
from graspdsl.report.summary import summarised
from graspdsl.trials.loop import together
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord
from graspdsl.trials.runner import execute, new_run, program_of_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.workers import AHEAD, WorkerEndedError

pytestmark = pytest.mark.slow

SPEC = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
COUNT = 3


@pytest.fixture
def folder(tmp_path: Path) -> RunFolder:
    """A run that has not begun."""
    text, overrides = SPEC.read_text(encoding="utf-8"), (f"trials.count={COUNT}", "scene.world=mujoco")
    return new_run(tmp_path / "run", program_of(text, SPEC.name, overrides))


def _numbers(folder: RunFolder) -> list[str]:
    return [repr(dataclasses.replace(record, wall_s=0.0)) for record in folder.records()]


@pytest.mark.parametrize("workers", [1, 2])
def test_what_fails_after_a_trial_leaves_it_kept(folder: RunFolder, workers: int) -> None:
    def fail(record: TrialRecord) -> None:
        raise KeyError(record.number)

    with pytest.raises(KeyError):
        execute(folder, workers, fail)
    assert multiprocessing.active_children() == []
    (kept,) = _numbers(folder)
    assert RunFolder.open(folder.path).manifest.wall_s > 0
    execute(folder, workers)
    assert len(_numbers(folder)) == COUNT
    assert kept in _numbers(folder)


def test_a_killed_worker_costs_no_trial(folder: RunFolder, tmp_path: Path) -> None:
    killed: list[int | None] = []

    def kill(_: TrialRecord) -> None:
        if not killed:
            worker = multiprocessing.active_children()[0]
            killed.append(worker.pid)
            worker.kill()

    execute(folder, 2, kill)
    assert len(killed) == 1
    assert multiprocessing.active_children() == []
    undisturbed = new_run(tmp_path / "undisturbed", program_of_run(folder))
    execute(undisturbed, 1)
    assert _numbers(folder) == _numbers(undisturbed)


def test_workers_that_end_one_after_the_other_end_the_run(folder: RunFolder) -> None:
    stop = threading.Event()

    def kill() -> None:
        while not stop.wait(0.05):
            for worker in multiprocessing.active_children():
                worker.kill()

    killing = threading.Thread(target=kill)
    killing.start()
    try:
        with pytest.raises(WorkerEndedError, match="10 worker processes ended") as caught:
            execute(folder, 2)
    finally:
        stop.set()
        killing.join()
    assert caught.value.from_outside
    assert multiprocessing.active_children() == []
    assert _numbers(folder) == []


# What a spec's own code does in workers alone, to trials by their numbers.
HARM = """
import multiprocessing, os, signal, time
from graspdsl.trials import loop

if multiprocessing.parent_process():
    drawn = loop.generator

    def generator(seed, number):
        if number == 3:
            os.kill(os.getpid(), signal.SIGSEGV)
        if number == 11:
            time.sleep(1000.0)
        return drawn(seed, number)

    loop.generator = generator
"""


def test_a_trial_that_ends_or_stops_its_process_has_crashed(tmp_path: Path) -> None:
    """It is run twice; all others are what they are without it."""
    (tmp_path / "harm.py").write_text(f"{HUBER}\n{HARM}", "utf-8")
    three = "{γ1, γ2, γ3}"
    text = (
        floating(f"φ_h|τ_frx({three}) σ_fr({three})", until="force_residual: 0.05")
        + "code: [harm.py]\ntrials: {count: 24, wall_limit: 1.5}\n"
    )
    program = program_of(text, "spec.yaml", (), tmp_path, allow_code=True)
    harmed, whole = (new_run(tmp_path / name, program) for name in ("harmed", "whole"))
    execute(harmed, 2)
    execute(whole, 1)
    crashed = {record.number: record for record in harmed.records() if record.outcome is Outcome.CRASHED}
    assert crashed.keys() == {3, 11}
    assert re.fullmatch(r"its process ended, 2 times: SIGSEGV(, with \d+ MB)?", crashed[3].detail)
    assert crashed[11].detail == "its process ended, 2 times: after more than 1.5 s, trials.wall_limit"
    assert all(record.has_begun for record in crashed.values())
    others = [line for number, line in enumerate(_numbers(harmed)) if number not in crashed]
    assert others == [line for number, line in enumerate(_numbers(whole)) if number not in crashed]
    assert len(harmed.finished()) == 24
    summary = summarised(evidence_of(harmed))
    assert summary.count(Outcome.CRASHED) == 2


def test_workers_know_of_few_trials(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a trial costs this process does not depend on how many wait: it gives out as many as run side by side."""
    given: list[int] = []

    class Pending(list[int]):
        def __iter__(self) -> Iterator[int]:
            for number in super().__iter__():
                given.append(number)
                yield number

    def look(_: Trial) -> None:
        seen.append(len(given))
        if len(seen) == COUNT:
            raise KeyError

    seen: list[int] = []
    short = (f"trials.count={COUNT}", "scene.world=mujoco", "program.1.limit=1.0")
    folder = new_run(tmp_path / "run", program_of(SPEC.read_text("utf-8"), SPEC.name, short))
    monkeypatch.setattr("graspdsl.trials.runner.pending", lambda *_: Pending(range(100_000)))
    with pytest.raises(KeyError):
        execute(folder, 2, look)
    most = together(program_of_run(folder))
    assert min(seen) > 0
    assert all(known <= 2 * (most + AHEAD) + trial + 1 for trial, known in enumerate(seen))


def test_nothing_left_to_run(folder: RunFolder) -> None:
    folder.manifest = dataclasses.replace(folder.manifest, asked=1)
    execute(folder, 1)
    seen: list[Trial] = []
    execute(folder, 2, seen.append)
    assert seen == []


def test_results_of_other_versions_are_not_mixed(folder: RunFolder) -> None:
    folder.manifest = dataclasses.replace(folder.manifest, asked=1)
    execute(folder, 1)
    table = folder.path / "trials.sqlite"
    record = dataclasses.replace(folder.records()[0], identity="of another version")
    folder.add(Trial(record, folder.trajectory(0)).packed())
    versions = {"graspdsl": "0.0.1", "numpy": "1"}
    folder.manifest = dataclasses.replace(folder.manifest, asked=COUNT, versions=versions)
    before = table.read_bytes()
    with pytest.raises(DiagnosticError, match=r"made with graspdsl 0\.0\.1, mujoco of no known version, numpy 1"):
        execute(folder, 1)
    assert table.read_bytes() == before
