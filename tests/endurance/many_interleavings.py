"""Many more of what tests/trials/test_interleavings.py has a few of, others each time: ``make endurance``."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings
from trials.test_interleavings import (
    FEW,
    SESSIONS,
    Session,
    Study,
    cluster,
    on_a_dask_cluster,
    on_processes_of_its_own,
    quick,
    study,
)

__all__ = ["cluster", "quick", "study"]  # fixtures


@settings(max_examples=200, deadline=None)
@given(sessions=SESSIONS, deadly=FEW)
def test_on_processes_of_its_own(study: Study, quick: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_processes_of_its_own(study, quick, sessions, deadly)


@settings(max_examples=40, deadline=None)
@given(sessions=SESSIONS, deadly=FEW)
def test_on_a_dask_cluster(study: Study, cluster: Any, sessions: list[Session], deadly: frozenset[int]) -> None:
    on_a_dask_cluster(study, cluster, sessions, deadly)
