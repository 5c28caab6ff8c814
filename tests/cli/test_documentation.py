"""The command that opens the documentation."""

from __future__ import annotations

from pathlib import Path

import pytest

from .program import ROOT, graspdsl


def test_it_says_where_the_pages_lie(tmp_path: Path) -> None:
    assert graspdsl("docs", "--path", cwd=tmp_path).stdout == f"{ROOT / 'docs'}\n"


@pytest.mark.slow
def test_it_makes_a_site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for display in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(display, raising=False)
    (tmp_path / "mkdocs.py").write_text("raise SystemExit('of the folder one is in')", "utf-8")
    done = graspdsl("docs", "--out", "the site #1", cwd=tmp_path)
    assert done.stdout == f"{(tmp_path / 'the site #1' / 'index.html').as_uri()}\n", done.stderr
    assert "<math" in (tmp_path / "the site #1" / "chapter.html").read_text("utf-8")


def test_a_folder_with_something_in_it_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").touch()
    done = graspdsl("docs", "--out", ".", cwd=tmp_path)
    assert done.returncode == 1
    assert "error[folder-not-empty]" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["thesis.txt"]


def test_a_folder_that_cannot_be_one_is_told(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = graspdsl("docs", "--out", "file/site", cwd=tmp_path)
    assert done.returncode == 1
    assert "error[site-not-made]" in done.stderr
    assert "Traceback" not in done.stderr
