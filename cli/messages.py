"""What the command line says: diagnostics with their place, messages on stderr, JSON on stdout."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Mapping
from typing import Any, TextIO

from graspdsl.diagnostics import Diagnostic, Severity, as_text

_COLOURS = {Severity.ERROR: "\x1b[1;31m", Severity.WARNING: "\x1b[1;33m"}
_PLAIN = "\x1b[0m"


def say(text: str) -> None:
    """A message, on stderr."""
    print(text, file=sys.stderr)


def result(text: str) -> None:
    """A result, on stdout."""
    print(text)


def result_json(value: Mapping[str, Any]) -> None:
    """A result as one JSON document, on stdout."""
    print(json.dumps(value, ensure_ascii=False, indent=2, allow_nan=False))


def complain(file: str, source: str, diagnostics: Iterable[Diagnostic], to: TextIO | None = None) -> None:
    """Show diagnostics with their lines and carets; in colour on a terminal."""
    stream = to or sys.stderr
    coloured = stream.isatty() and "NO_COLOR" not in os.environ
    for diagnostic in diagnostics:
        text = as_text(diagnostic, file, source)
        if coloured:
            label = f"{diagnostic.severity.value}[{diagnostic.code}]"
            text = text.replace(label, f"{_COLOURS[diagnostic.severity]}{label}{_PLAIN}", 1)
        print(text, file=stream)


def as_file_json(path: str, diagnostics: Iterable[Diagnostic]) -> dict[str, Any]:
    """A file's entry of ``validate --json``."""
    listed = list(diagnostics)
    return {
        "path": path,
        "ok": not any(diagnostic.severity is Severity.ERROR for diagnostic in listed),
        "diagnostics": [diagnostic.as_dict() for diagnostic in listed],
    }
