"""One server for the tests of a module: to start it takes longer than they do."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from .client import Editor


@pytest.fixture(scope="module")
def editor() -> Iterator[Editor]:
    """An editor with its server, which ends well when the tests are done and has met no bug."""
    started = Editor()
    yield started
    assert started.end() == 0
    assert started.log == []
