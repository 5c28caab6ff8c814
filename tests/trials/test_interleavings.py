"""Whatever becomes of a run, in whatever order, on whichever engine: at the end it is the run that nothing happened to.

Trials end their process once or whenever they run, processes are lost, who looks on interrupts, bytes of a trial that
was never committed are left behind, and the run is gone on with, until all trials are there.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import forkserver
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from compiler.specs import floating
from hypothesis import Phase, example, given, settings
from hypothesis import strategies as st
from plugins.packages import HUBER

from graspdsl.compiler.program import Program, program_of
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.workers import Dask, Workers

from .test_dask import THREE, numbers

pytestmark = pytest.mark.slow

COUNT = 16
METHOD = "distributed.worker.multiprocessing-method"
# A trial ends its worker as it begins, others being in the middle beside it, where a file asks for it.
ORDERS = """
import multiprocessing, os, signal
from pathlib import Path
from graspdsl.trials import loop

drawn = loop.generator

def generator(seed, number):
    if multiprocessing.parent_process():
        try:
            (Path({orders!r}) / f"once {{number}}").unlink()
            ends = True
        except FileNotFoundError:
            ends = (Path({orders!r}) / f"always {{number}}").exists()
        if ends:
            os.kill(os.getpid(), signal.SIGKILL)
    return drawn(seed, number)

loop.generator = generator
"""


@dataclass(frozen=True)
class Session:
    """What happens while a run is gone on with: ``once``, trials that end their process the first time; after how many
    records it is interrupted, and a process is killed; whether bytes of no trial are left behind."""

    workers: int
    once: frozenset[int]
    interrupted: int | None
    lost: int | None
    torn: bool


@dataclass
class Study:
    """A program whose trials heed orders, and what it is when there are none."""

    program: Program
    orders: Path
    whole: dict[int, tuple[str, bytes]]

    def order(self, always: frozenset[int], once: frozenset[int] = frozenset()) -> None:
        """From now on these trials, and no others, end their process."""
        for order in self.orders.iterdir():
            order.unlink()
        for order in (*(f"always {number}" for number in always), *(f"once {number}" for number in once)):
            (self.orders / order).touch()


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """Trials of floating contacts, each of some milliseconds."""
    place = tmp_path_factory.mktemp("study")
    (place / "orders").mkdir()
    (place / "orders.py").write_text(f"{HUBER}\n{ORDERS.format(orders=str(place / 'orders'))}", "utf-8")
    text = floating(f"φ_h|τ_frx({THREE}) σ_fr({THREE})", until="force_residual: 0.05")
    text += f"code: [orders.py]\ntrials: {{count: {COUNT}}}\n"
    program = program_of(text, "spec.yaml", (), place, allow_code=True)
    folder = new_run(place / "whole", program)
    execute(folder, 1)
    return Study(program, place / "orders", numbers(folder))


@pytest.fixture(scope="module")
def quick() -> Any:
    """How processes are begun: forked from one that has imported everything."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["distributed", "graspdsl.trials.workers", "trials.warmed"])
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PYTHONPATH", str(Path(__file__).parents[1]))  # CPython 3.11 has it import from nowhere else
        forkserver.ensure_running()
    return context


@pytest.fixture(scope="module")
def cluster(quick: Any) -> Iterator[Any]:
    """Three processes that know nothing of this one."""
    distributed, dask = pytest.importorskip("distributed"), pytest.importorskip("dask")
    never_given_up = {"distributed.deploy.lost-worker-timeout": "365 days"}
    quickly_begun = {METHOD: quick.get_start_method()}
    options = {"threads_per_worker": 1, "dashboard_address": ":0", "memory_limit": None, "silence_logs": 60}
    with (
        dask.config.set({**never_given_up, **quickly_begun}),
        distributed.LocalCluster(n_workers=3, **options) as three,
    ):
        yield three


NUMBER, AFTER = st.integers(0, COUNT - 1), st.none() | st.integers(1, COUNT)
FEW = st.frozensets(NUMBER, max_size=2)
SESSIONS = st.lists(st.builds(Session, st.integers(1, 3), FEW, AFTER, AFTER, st.booleans()), max_size=3)
TO_ITS_END = Session(2, frozenset(), None, None, torn=False)


@dataclass
class Onlooker:
    """Is told of each trial that has ended, and does what a session says."""

    session: Session
    lose: Callable[[], object]
    told: int = 0

    def __call__(self, _: TrialRecord) -> None:
        self.told += 1
        if self.told == self.session.lost:
            self.lose()
        if self.told == self.session.interrupted:
            raise KeyboardInterrupt


def check(
    study: Study,
    sessions: list[Session],
    deadly: frozenset[int],
    shared_by: Callable[[int], Workers],
    lose: Callable[[], object],
) -> None:
    """Let all of it happen to a new run, then finish that. ``deadly``: trials that always end their process."""
    with TemporaryDirectory() as place:
        folder, found = new_run(Path(place) / "run", study.program), dict[int, tuple[str, bytes]]()
        for session in (*sessions, TO_ITS_END):
            study.order(deadly, session.once)
            onlooker, before = Onlooker(session, lose), found
            with suppress(KeyboardInterrupt):
                execute(folder, shared_by(session.workers), onlooker)
            folder = RunFolder.open(folder.path, allow_code=True)
            found = numbers(folder)
            assert len(folder.finished()) == len(found) == len(before) + onlooker.told
            assert before.items() <= found.items()
            if session.torn:
                folder.packs.put(0, b"of a trial that was never committed")
        crashed = {record.number for record in folder.records() if record.outcome is Outcome.CRASHED}
        # One that ends its process once, or that is alone in a process that is lost, may have lost one beside others.
        without_reason = crashed.difference(deadly, *(session.once for session in sessions))
        assert len(without_reason) <= sum(session.lost is not None for session in sessions)
        assert found.keys() == study.whole.keys()
        assert all(found[number] == study.whole[number] for number in found if number not in crashed)


# All that can happen, and nothing.
EVERYTHING = example(
    sessions=[Session(2, frozenset({1}), 5, None, torn=True), Session(3, frozenset(), None, 3, torn=False)],
    deadly=frozenset({6}),
)


@EVERYTHING
@settings(max_examples=2, deadline=None, derandomize=True)
@given(sessions=SESSIONS, deadly=FEW)
def test_on_processes_of_its_own(study: Study, quick: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_processes_of_its_own(study, quick, sessions, deadly)


@EVERYTHING
@settings(phases=[Phase.explicit], deadline=None)  # which takes seconds; make endurance has others
@given(sessions=SESSIONS, deadly=FEW)
def test_on_a_dask_cluster(study: Study, cluster: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_a_dask_cluster(study, cluster, sessions, deadly)


def test_a_dask_cluster_of_ours_is_told_never_to_give_a_process_up(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What it is for takes long to see: tests/endurance/many_interleavings.py."""
    dask, told = pytest.importorskip("dask"), list[str]()

    def cluster(**_: object) -> None:
        told.append(dask.config.get("distributed.deploy.lost-worker-timeout"))
        raise OSError("seen enough")

    monkeypatch.setattr("distributed.LocalCluster", cluster)
    with pytest.raises(OSError, match="seen enough"):
        execute(new_run(tmp_path / "run", study.program), Dask(workers=1))
    assert told == ["365 days"]


def on_processes_of_its_own(study: Study, quick: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("graspdsl.trials.workers.multiprocessing.get_context", lambda _: quick)
        check(study, sessions, deadly, lambda workers: workers, lose_process)


def on_a_dask_cluster(study: Study, cluster: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    def lose() -> None:
        nanny = next(iter(cluster.workers.values()))
        if nanny.pid is not None:  # else it is just being renewed
            os.kill(nanny.pid, signal.SIGKILL)

    check(study, sessions, deadly, lambda _: Dask(cluster.scheduler_address), lose)


def lose_process() -> None:
    """Kill one of the local engine's, if there is any."""
    for process in multiprocessing.active_children()[:1]:
        process.kill()
