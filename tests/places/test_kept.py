"""What is kept of the package's own files: read back while they are as they were, made anew when one has changed."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from graspdsl.places import kept as module
from graspdsl.places.kept import kept


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of one file of data, whose bytecode may be written."""
    monkeypatch.setattr(module, "PACKAGE", tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", False)
    (tmp_path / "tables").mkdir()
    (tmp_path / "tables" / "data.yaml").write_text("a: 1", encoding="utf-8")
    module._files.cache_clear()
    return tmp_path


def _asked(*makes: Callable[[], object], name: str = "table", version: str = "1") -> list[object]:
    """What is got by each of some processes, one after another."""
    found = []
    for make in makes:
        module._files.cache_clear()
        found.append(kept(name, version, make))
    module._files.cache_clear()
    return found


def test_it_is_made_once(package: Path) -> None:
    assert _asked(lambda: {"a": 1}, lambda: {"a": 2}) == [{"a": 1}] * 2
    assert _asked(lambda: {"b": 3}, name="other") == [{"b": 3}]
    assert len([*(package / "__pycache__").iterdir()]) == 2


def test_it_is_made_anew_of_other_files_and_by_another_version(package: Path) -> None:
    assert _asked(lambda: 1) == [1]
    (package / "tables" / "data.yaml").write_text("a: 22", encoding="utf-8")
    assert _asked(lambda: 2) == [2]
    assert _asked(lambda: 3, version="2") == [3]
    (package / "new.py").touch()
    assert _asked(lambda: 4, version="2") == [4]
    assert len([*(package / "__pycache__").iterdir()]) == 1


def test_what_cannot_be_read_is_made_anew(package: Path) -> None:
    assert _asked(lambda: 1) == [1]
    (file,) = (package / "__pycache__").iterdir()
    file.write_bytes(b"nonsense")
    assert _asked(lambda: 2, lambda: 3) == [2, 2]


def test_nothing_is_written_where_python_writes_no_bytecode(package: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    assert _asked(lambda: 1, lambda: 2) == [1, 2]
    assert not (package / "__pycache__").exists()


def test_where_nobody_may_write_it_is_made_each_time(package: Path) -> None:
    (package / "__pycache__").touch()
    assert _asked(lambda: 1, lambda: 2) == [1, 2]
