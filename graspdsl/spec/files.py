"""Reads a text file that a user named, within bounds."""

from __future__ import annotations

import codecs
import stat
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint

SIZE_LIMIT = 1024 * 1024  # bytes


def read_text(path: Path) -> str:
    """The text of a UTF-8 file, without its byte order mark and with ``\\n`` for every kind of line end.

    Raises :class:`DiagnosticError` when there is no such file, it cannot be read, is no plain file, is larger than
    ``SIZE_LIMIT``, or is not UTF-8.
    """
    try:
        mode = path.stat()
        if stat.S_ISDIR(mode.st_mode):
            raise _refusal("is-a-directory", "this is a directory, not a file", "name a YAML file in it")
        if not stat.S_ISREG(mode.st_mode):
            # A pipe or a device may never end, or never begin.
            raise _refusal("not-a-file", "this is not a regular file", "save the text to a file first")
        if mode.st_size > SIZE_LIMIT:
            raise too_large(mode.st_size)
        with path.open("rb") as file:
            content = file.read(SIZE_LIMIT + 1)
    except FileNotFoundError:
        raise _refusal("file-not-found", "there is no such file", _neighbours(path)) from None
    except PermissionError:
        raise _refusal("file-not-readable", "no permission to read this file", None) from None
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise _refusal("file-not-readable", f"cannot read this file: {reason}", None) from None
    except ValueError:
        raise _refusal("file-not-found", "this cannot be the name of a file", None) from None
    if len(content) > SIZE_LIMIT:
        raise too_large(len(content))
    return _decoded(content)


def too_large(size: int) -> DiagnosticError:
    """The refusal of a text of ``size`` bytes."""
    return _refusal(
        "file-too-large",
        f"this file is too large: {size} bytes, where a spec may have {SIZE_LIMIT}",
        "check that this is the file you meant",
    )


def with_plain_line_ends(text: str) -> str:
    """The text without a byte order mark at its start and with ``\\n`` for every kind of line end."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _refusal(code: str, message: str, hint: str | None) -> DiagnosticError:
    return DiagnosticError([Diagnostic(code, message, hint=hint)])


def _neighbours(path: Path) -> str | None:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix in {".yaml", ".yml"}]
    except OSError:
        return f"the folder {path.parent.name or path.parent} is not there or cannot be read"
    return known_names_hint(path.name, names[:100], "YAML files")


def _decoded(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise _refusal("not-utf8", "this file is UTF-16, not UTF-8", "save it as UTF-8")
    try:
        return with_plain_line_ends(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        message = f"this file is not UTF-8 text: byte {error.start + 1} is 0x{content[error.start]:02x}"
        hint = "save it as UTF-8, and check that it is a text file"
        raise _refusal("not-utf8", message, hint) from None
