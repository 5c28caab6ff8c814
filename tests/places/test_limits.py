"""Files that cannot be read, and texts made to exhaust the reader."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.places.document import Document, parse_document
from graspdsl.places.files import read_text

MEBI = 1024 * 1024


def read_document(path: Path) -> Document:
    """The document of a file."""
    return parse_document(read_text(path), path.name)


def only(path: Path) -> Diagnostic:
    """The one complaint about a file."""
    with pytest.raises(DiagnosticError) as caught:
        read_document(path)
    [diagnostic] = caught.value.diagnostics
    return diagnostic


def test_missing_file_names_its_neighbours(tmp_path: Path) -> None:
    (tmp_path / "towel.yaml").touch()
    diagnostic = only(tmp_path / "towl.yaml")
    assert (diagnostic.code, diagnostic.message, diagnostic.hint) == (
        "file-not-found",
        "there is no such file",
        "did you mean towel.yaml?",
    )


@pytest.mark.parametrize(("name", "code"), [("a\0b", "file-not-found"), ("x" * 5000, "file-not-readable")])
def test_impossible_names(tmp_path: Path, name: str, code: str) -> None:
    assert only(tmp_path / name).code == code


def test_missing_folder(tmp_path: Path) -> None:
    assert only(tmp_path / "no" / "towel.yaml").hint == "the folder no is not there or cannot be read"


def test_directory(tmp_path: Path) -> None:
    assert only(tmp_path).code == "is-a-directory"


def test_a_pipe_does_not_make_the_reader_wait(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert only(tmp_path / "pipe").code == "not-a-file"


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_no_permission(tmp_path: Path) -> None:
    path = tmp_path / "closed.yaml"
    path.write_text("a: 1")
    path.chmod(0)
    assert only(path).message == "no permission to read this file"


@pytest.mark.parametrize(
    ("content", "code", "message"),
    [
        (b"", "empty-file", "there is nothing in this file"),
        (b"a: 1\nb: \xff\xfe", "not-utf8", "this file is not UTF-8 text: byte 9 is 0xff"),
        (b"\x7fELF\x02\x01\x01\x00\x00", "bad-character", "the character U+007F cannot stand in a YAML file"),
        ("a: 1".encode("utf-16"), "not-utf8", "this file is UTF-16, not UTF-8"),
        (b"[" * (10 * MEBI), "file-too-large", "this file is too large: 10485760 bytes, where a spec may have 1048576"),
    ],
)
def test_content(tmp_path: Path, content: bytes, code: str, message: str) -> None:
    path = tmp_path / "spec.yaml"
    path.write_bytes(content)
    diagnostic = only(path)
    assert (diagnostic.code, diagnostic.message) == (code, message)


@pytest.mark.slow
def test_a_file_of_the_full_size_is_read(tmp_path: Path) -> None:
    path = tmp_path / "spec.yaml"
    path.write_text("a: " + "b" * (MEBI - 3))
    assert len(str(read_document(path).data["a"])) == MEBI - 3


LAUGHS = "a0: &a0 [ha, ha, ha]\n" + "".join(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 30))
MERGES = "a0: &a0 {b: 1}\n" + "".join(f"a{n}: &a{n} {{<<: [*a{n - 1}, *a{n - 1}]}}\n" for n in range(1, 38))
LONG_CHAIN = "a0: &a0 [1]\n" + "".join(f"a{n}: &a{n} [*a{n - 1}]\n" for n in range(1, 90))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "code"),
    [
        (LAUGHS, "too-many-values"),
        (MERGES, "too-many-values"),
        (LONG_CHAIN, "too-deep"),
        ("[" * (MEBI - 1), "too-deep"),
        ("a: " + "{a: " * (MEBI // 4 - 1), "too-deep"),
        ("- " * (MEBI // 2), "too-deep"),
        ("? " * (MEBI // 2), "too-deep"),
        ("a:\n" + "".join(" " * n + "a:\n" for n in range(1, 1400)), "too-deep"),
        ("a: [" + "1," * (MEBI // 2 - 3) + "]", "too-many-values"),
        ("a: 1\n" * (MEBI // 5), "too-many-values"),
        ('a: "' + "\\n" * (MEBI // 2 - 3), "open-quote"),
        ("#" * (MEBI - 1), "empty-file"),
        ("a: " + "&" * (MEBI - 3), "unquoted-text"),
    ],
)
def test_texts_made_to_exhaust_the_reader(text: str, code: str) -> None:
    begin = time.perf_counter()
    with pytest.raises(DiagnosticError) as caught:
        parse_document(text, "test.yaml")
    assert [diagnostic.code for diagnostic in caught.value.diagnostics] == [code]
    assert time.perf_counter() - begin < 10


def test_as_deep_as_it_may_be() -> None:
    assert parse_document("a: " + "[" * 39 + "]" * 39, "test.yaml").data["a"]
    with pytest.raises(DiagnosticError, match="40 levels"):
        parse_document("a: " + "[" * 40 + "]" * 40, "test.yaml")
