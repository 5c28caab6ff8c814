"""Many trials: what is done when one of them, a worker or the user of the results fails."""

from __future__ import annotations

import dataclasses
import multiprocessing
from collections.abc import Iterator
from pathlib import Path

import pytest

from graspdsl.compiler.program import program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.loop import together
from graspdsl.trials.record import Trial
from graspdsl.trials.runner import AHEAD, WorkerEndedError, execute, new_run, program_of_run
from graspdsl.trials.store import RunFolder

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
    def fail(trial: Trial) -> None:
        raise KeyError(trial.record.number)

    with pytest.raises(KeyError):
        execute(folder, workers, fail)
    assert multiprocessing.active_children() == []
    (kept,) = _numbers(folder)
    assert RunFolder.open(folder.path).manifest.wall_s > 0
    execute(folder, workers)
    assert len(_numbers(folder)) == COUNT
    assert kept in _numbers(folder)


def test_a_killed_worker_ends_the_run_in_good_order(folder: RunFolder) -> None:
    def kill(_: Trial) -> None:
        for worker in multiprocessing.active_children()[:1]:
            worker.kill()

    with pytest.raises(WorkerEndedError, match=r"\(SIGKILL\)") as caught:
        execute(folder, 2, kill)
    assert caught.value.from_outside
    assert multiprocessing.active_children() == []
    assert 1 <= len(_numbers(folder)) < COUNT


def test_workers_know_of_few_trials(folder: RunFolder, monkeypatch: pytest.MonkeyPatch) -> None:
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
    folder.add(Trial(record, folder.trajectory(0)))
    versions = {"graspdsl": "0.0.1", "numpy": "1"}
    folder.manifest = dataclasses.replace(folder.manifest, asked=COUNT, versions=versions)
    before = table.read_bytes()
    with pytest.raises(DiagnosticError, match=r"made with graspdsl 0\.0\.1, mujoco of no known version, numpy 1"):
        execute(folder, 1)
    assert table.read_bytes() == before
