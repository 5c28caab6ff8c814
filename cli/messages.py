"""What the command line says: diagnostics with their place, messages on stderr, results on stdout."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping
from typing import Any, TextIO

from graspdsl.cli.encoding import SPELL_OUT, install
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, as_text, has_errors, steers
from graspdsl.trials.interruption import interruption

WRONG_INPUT = 1
_COLOURS = {Severity.ERROR: "\x1b[1;31m", Severity.WARNING: "\x1b[1;33m"}
_PLAIN = "\x1b[0m"


def prepare_streams() -> None:
    """Let stdout and stderr take any text, whatever their encoding, and stand in for those that are closed."""
    install()
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            setattr(sys, name, os.fdopen(nowhere, "w", encoding="utf-8"))
        elif hasattr(stream, "reconfigure"):
            stream.reconfigure(errors=SPELL_OUT)


def say(text: str) -> None:
    """A message, on stderr. Names that a user gave must have been put on one line before."""
    write(sys.stderr, f"{printable(text)}\n")


def if_interrupted(kept: str) -> None:
    """From now on, a program that a signal ends says this of what is kept."""
    after_progress = b"\x1b[?25h\n" if sys.stderr.isatty() else b""  # whose bar hides the cursor
    text = printable(f"interrupted; {kept}\n")
    interruption.words = after_progress + text.encode(sys.stderr.encoding or "utf-8", SPELL_OUT)


def result(text: str) -> None:
    """A result, on stdout. Raises DiagnosticError when it cannot be written."""
    refused = write(sys.stdout, f"{text}\n")
    if refused is not None:
        message = f"cannot write the results to stdout: {(refused.strerror or 'unknown reason').lower()}"
        raise DiagnosticError([Diagnostic("output-not-writable", message)])


def result_json(value: Mapping[str, Any]) -> None:
    """A result as one JSON document, on stdout."""
    unicode = (sys.stdout.encoding or "").lower().startswith("utf")
    text = json.dumps(value, ensure_ascii=not unicode, indent=2, allow_nan=False)
    result("".join(json.dumps(c)[1:-1] if c != "\n" and steers(c) else c for c in text))


def write(stream: TextIO, text: str) -> OSError | None:
    """Write at once. A stream that takes no more text gets none from then on, and the work goes on.

    Returns what went wrong, unless it is only that the reader has seen enough.
    """
    try:
        stream.write(text)
        stream.flush()
    except OSError as error:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, stream.fileno())
        os.close(nowhere)
        return None if isinstance(error, BrokenPipeError) else error
    return None


def printable(text: str) -> str:
    """The text with control characters replaced, so that the name of a file cannot steer a terminal."""
    if text.isprintable():
        return text
    return "".join("\ufffd" if c not in "\t\n" and steers(c) else c for c in text)


def writable(text: str) -> str:
    """The text as stdout will write it, for whoever lays out columns."""
    encoding = sys.stdout.encoding or "utf-8"
    return text.encode(encoding, SPELL_OUT).decode(encoding)


def complain(file: str, source: str, diagnostics: Iterable[Diagnostic], to: TextIO | None = None) -> None:
    """Show diagnostics with their lines and carets, on stderr if not said otherwise; in colour on a terminal."""
    stream = to or sys.stderr
    coloured = stream.isatty() and "NO_COLOR" not in os.environ
    for diagnostic in diagnostics:
        text = printable(as_text(diagnostic, file, source))
        if coloured:
            label = f"{diagnostic.severity.value}[{diagnostic.code}]"
            text = text.replace(label, f"{_COLOURS[diagnostic.severity]}{label}{_PLAIN}", 1)
        write(stream, f"{text}\n")


def as_file_json(path: str, diagnostics: Iterable[Diagnostic]) -> dict[str, Any]:
    """A file's entry of ``validate --json``."""
    listed = list(diagnostics)
    return {
        "path": path,
        "ok": not has_errors(listed),
        "diagnostics": [diagnostic.as_dict() for diagnostic in listed],
    }
