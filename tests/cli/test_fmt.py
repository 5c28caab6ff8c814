"""Specs formatted on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest

from .program import ROOT, SPEC, graspdsl

GOOD = SPEC.read_text("utf-8")
UNTIDY = GOOD.replace("name: towel", "name:   towel").replace("π_close|Γ Γ", "pi_close|G G")


def test_files_are_written_in_their_places(tmp_path: Path) -> None:
    """Formatted ones and faulty ones stay as they are; the others are named, and only written without --check."""
    files = {"good.yaml": GOOD, "untidy.yaml": UNTIDY, "faulty.yaml": UNTIDY.replace("finger-1", "finger-9")}
    for name, text in files.items():
        (tmp_path / name).write_text(text, "utf-8")
    (tmp_path / "untidy.yaml").chmod(0o640)
    (tmp_path / "link.yaml").symlink_to("untidy.yaml")
    checked = graspdsl("fmt", "--check", "good.yaml", "untidy.yaml", cwd=tmp_path)
    assert (checked.returncode, checked.stdout) == (1, "untidy.yaml\n")
    shown = graspdsl("fmt", "--diff", "good.yaml", "untidy.yaml", cwd=tmp_path)
    assert shown.returncode == 0
    assert "-  - run: pi_close|G G\n+  - run: π_close|Γ Γ\n" in shown.stdout
    assert (tmp_path / "untidy.yaml").read_text("utf-8") == UNTIDY
    done = graspdsl("fmt", "good.yaml", "faulty.yaml", "link.yaml", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (1, "link.yaml\n")
    assert "faulty.yaml:16:7: error[unknown-contact]" in done.stderr
    assert (tmp_path / "faulty.yaml").read_text("utf-8") == files["faulty.yaml"]
    assert (tmp_path / "link.yaml").is_symlink()
    assert (tmp_path / "untidy.yaml").read_text("utf-8") == GOOD
    assert (tmp_path / "untidy.yaml").stat().st_mode & 0o777 == 0o640
    assert graspdsl("fmt", "--check", "good.yaml", "untidy.yaml", cwd=tmp_path).returncode == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["faulty.yaml", "good.yaml", "link.yaml", "untidy.yaml"]


@pytest.mark.parametrize(
    ("content", "code", "left"),
    [
        (GOOD.replace("\n", "\r\n").encode(), 0, GOOD.replace("\n", "\r\n").encode()),
        (b"\xef\xbb\xbf" + GOOD.encode(), 0, GOOD.encode()),
        (GOOD.rstrip("\n").encode(), 0, GOOD.encode()),
        (GOOD.replace("  world:", "\tworld:").encode(), 1, None),
        (f"{GOOD}name: again\n".encode(), 1, None),
        (b"\xff\xfe", 1, None),
    ],
    ids=["CRLF", "BOM", "no end", "tab", "twice", "UTF-16"],
)
def test_bytes_that_editors_leave(content: bytes, code: int, left: bytes | None, tmp_path: Path) -> None:
    place = tmp_path / "spec.yaml"
    place.write_bytes(content)
    answer = graspdsl("fmt", "spec.yaml", cwd=tmp_path)
    assert answer.returncode == code, answer.stderr
    assert ("error[" in answer.stderr) is (code == 1)
    assert place.read_bytes() == (content if left is None else left)


def test_only_specs_are_formatted(tmp_path: Path) -> None:
    answer = graspdsl("fmt", ROOT / "graspdsl" / "hands" / "barrett.yaml", "towel-roll-two-contacts", cwd=tmp_path)
    assert answer.returncode == 1
    assert "error[not-a-spec]: this is a hand file" in answer.stderr
    assert "error[file-not-found]" in answer.stderr
