"""Specs formatted in their places, or compared with how they would be."""

from __future__ import annotations

import difflib
import os
from collections.abc import Iterable
from pathlib import Path

from graspdsl.cli.inputs import judged
from graspdsl.cli.messages import WRONG_INPUT, complain, printable, result, say
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, on_one_line, reading
from graspdsl.places.files import read_text
from graspdsl.report.writing import replace
from graspdsl.spec.formatting import formatted, refuse_others


def format_specs(paths: Iterable[Path], *, check: bool, diff: bool, in_ascii: bool, allow_code: bool) -> int:
    """Format specs, unless they are only checked or their changes shown; faulty ones are told and stay as they are.

    Returns the exit code: that of wrong input where a spec has errors, or a checked one is not formatted.
    """
    code, changed, same = 0, 0, 0
    for path in paths:
        source, diagnostics = _judged(path, allow_code=allow_code)
        if has_errors(diagnostics):
            complain(str(path), source, diagnostics)
            code = WRONG_INPUT
            continue
        before = path.read_bytes()
        text = formatted(source, in_ascii=in_ascii)
        after = (text.replace("\n", "\r\n") if before.partition(b"\n")[0].endswith(b"\r") else text).encode()
        if before == after:
            same += 1
            continue
        changed += 1
        if diff:
            result(_difference(str(path), source, text))
        if check:
            code = WRONG_INPUT
        if check and not diff:
            result(on_one_line(str(path)))
        if not check and not diff:
            _write(path, after)
            result(on_one_line(str(path)))
    what = "would be formatted" if check or diff else "formatted"
    say(f"{changed} {'file' if changed == 1 else 'files'} {what}, {same} as {'it is' if same == 1 else 'they are'}")
    return code


def _judged(path: Path, *, allow_code: bool) -> tuple[str, tuple[Diagnostic, ...]]:
    try:
        refuse_others(read_text(path))
    except DiagnosticError as error:
        return "", error.diagnostics
    return judged(path, allow_code=allow_code)


def _difference(name: str, before: str, after: str) -> str:
    lines = difflib.unified_diff(before.splitlines(), after.splitlines(), name, f"{name} (formatted)", lineterm="")
    return printable("\n".join(lines)) or on_one_line(f"{name}: line ends, or a mark of byte order")


def _write(path: Path, content: bytes) -> None:
    """Write a file in the place of another one, with its mode; a link stays one."""
    place = Path(os.path.realpath(path))
    mode = place.stat().st_mode
    with reading(str(path)):
        replace(place.parent, {place.name: content})
        try:
            place.chmod(mode)
        except OSError as error:
            raise DiagnosticError([Diagnostic("output-not-writable", str(error))]) from None
