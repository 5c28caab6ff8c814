"""Many more of what tests/trials/test_interleavings.py has a few of, others each time: ``make endurance``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from trials.test_interleavings import (
    COUNT,
    FEW,
    METHOD,
    SESSIONS,
    Session,
    Study,
    cluster,
    on_a_dask_cluster,
    on_processes_of_its_own,
    quick,
    study,
)

from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.workers import Dask

__all__ = ["cluster", "quick", "study"]  # fixtures


@settings(max_examples=200, deadline=None)
@given(sessions=SESSIONS, deadly=FEW)
def test_on_processes_of_its_own(study: Study, quick: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_processes_of_its_own(study, quick, sessions, deadly)


@settings(max_examples=40, deadline=None)
@given(sessions=SESSIONS, deadly=FEW)
def test_on_a_dask_cluster(study: Study, cluster: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_a_dask_cluster(study, cluster, sessions, deadly)


def test_a_dask_cluster_of_ours_never_gives_its_last_process_up(study: Study, quick: Any, tmp_path: Path) -> None:
    """Dask would close one for good that is not back a while after it was lost: 15 s as a rule, here at once."""
    folder = new_run(tmp_path / "run", study.program)
    study.order(frozenset({6}))
    at_once = {"distributed.deploy.lost-worker-timeout": "1 ms"}
    with pytest.importorskip("dask").config.set({**at_once, METHOD: quick.get_start_method()}):
        execute(folder, Dask(workers=1))
    assert [record.number for record in folder.records() if record.outcome is Outcome.CRASHED] == [6]
    assert len(folder.finished()) == COUNT
