"""One run that many tests look at."""

from __future__ import annotations

import json

import pytest

from cli.program import SPEC, TRIALS, FinishedRun, graspdsl


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Whoever looks at the run waits for it."""
    for item in items:
        if "finished" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> FinishedRun:
    """A run of TRIALS trials; not to be changed."""
    place = tmp_path_factory.mktemp("finished")
    answer = graspdsl("run", SPEC, "--trials", str(TRIALS), "--workers", "1", "--out", "run", "--json", cwd=place)
    assert answer.returncode == 0
    return FinishedRun(place / "run", json.loads(answer.stdout), answer.stderr)
