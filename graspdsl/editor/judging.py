"""Every complaint about a text that is being written, of a spec, a hand file or a mount file."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from graspdsl.compiler.program import examine, missing_engine
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.hand_files import hand_in
from graspdsl.hands.mount_files import mount_in
from graspdsl.places.files import SpecFolder, folder_of_files
from graspdsl.places.folders import HAND_FILE, MOUNT_FILE

MOST_POINTS = 20  # of a sweep, which are looked at while one writes


def judged(text: str, path: Path, *, allow_code: bool = False) -> tuple[Diagnostic, ...]:
    """The complaints about a text, as of the file at a path, whatever that has on the disk; in reading order.

    Other files that it names are read as they are on the disk. ``allow_code``: whether a spec's Python files are run.
    """
    if HAND_FILE.match(text) is None and MOUNT_FILE.match(text) is None:
        examination = examine(text, path.name, (), folder_of_files(path), allow_code, MOST_POINTS)
        missing = missing_engine(examination.program) if examination.program else None
        return (*examination.diagnostics, *([missing] if missing else []))
    read = hand_in if HAND_FILE.match(text) else mount_in
    try:
        return read(_Written(path.parent, name=path.name, text=text), path.name).warnings
    except (DescriptionFileError, DiagnosticError) as error:
        return error.diagnostics


@dataclass(slots=True)
class _Written(SpecFolder):
    """A folder with a file that is being written: what is read of that one is its text."""

    name: str = ""
    text: str = ""

    def read(self, name: str) -> bytes:
        return self.text.encode("utf-8", errors="replace") if name == self.name else SpecFolder.read(self, name)


_TELLING = re.compile(r"^(scene|program|resources|trials|controllers)\s*:", re.MULTILINE)
_OURS = re.compile(r"^graspdsl\s*:|^#.*\$schema=\S*graspdsl", re.MULTILINE)


def is_ours(text: str) -> bool:
    """Whether a YAML text is meant for graspdsl: a spec, which may lack its first line, a hand file or a mount file."""
    if HAND_FILE.match(text) or MOUNT_FILE.match(text) or _OURS.search(text):
        return True
    return len({key.group(1) for key in _TELLING.finditer(text)}) > 1
