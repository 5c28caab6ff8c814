"""The files that a spec names, an object's or a hand's, read within its folder and within bounds."""

from __future__ import annotations

import hashlib
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError

LARGEST = 64 * 1024 * 1024  # bytes
RUN_MANIFEST, MAP_DATA = "run.json", "map.json"  # one of them is in the folder of a run or a map
COPIES = "files"  # of what its spec names, there
KEPT = "absolute-paths"  # where a run keeps its copies of files that a spec names by absolute paths


@dataclass(frozen=True, slots=True)
class NamedFile:
    """A file that was read: its place in a folder of copies, and its content."""

    kept_as: Path
    content: bytes


@dataclass(slots=True)
class SpecFolder:
    """Where the files that a spec names are looked for, and those that have been read.

    A relative path may not leave the folder, through ``..`` or through a link; an absolute one names any file. In the
    folder of a run, which holds copies, the copy of a file with an absolute path comes before the file itself.
    """

    path: Path
    files: list[NamedFile] = field(default_factory=list)

    def read(self, name: str) -> bytes:
        """The content of a file. Raises DiagnosticError when there is none, or it is no plain file of moderate size."""
        place = self.place(name)
        try:
            mode = place.stat()
            if stat.S_ISDIR(mode.st_mode):
                raise refusal("is-a-directory", f"{name} is a directory, not a file", "name a file in it")
            if not stat.S_ISREG(mode.st_mode):
                # A pipe or a device may never end, or never begin.
                raise refusal("not-a-file", f"{name} is not a regular file", None)
            if mode.st_size <= LARGEST:
                with place.open("rb") as file:
                    content = file.read(LARGEST + 1)
            if mode.st_size > LARGEST or len(content) > LARGEST:
                size = max(mode.st_size, LARGEST + 1)
                message = f"{name} is too large: {size} bytes, where a file may have {LARGEST}"
                raise refusal("file-too-large", message, "simplify it")
        except FileNotFoundError:
            raise refusal("file-not-found", f"there is no file {name}", _looked_in(name)) from None
        except PermissionError:
            raise refusal("file-not-readable", f"no permission to read {name}", None) from None
        except OSError as error:
            reason = (error.strerror or "unknown reason").lower()
            raise refusal("file-not-readable", f"cannot read {name}: {reason}", None) from None
        self.files.append(NamedFile(_kept_as(name), content))
        return content

    @property
    def digest(self) -> str:
        """A hash of all that has been read; empty when nothing has."""
        return digest_of(self.files) if self.files else ""

    def place(self, name: str) -> Path:
        """Where a file is. Raises DiagnosticError for a name that leads out of the folder."""
        try:
            kept = _kept_as(name)
            if Path(name).is_absolute():
                copy = self.path / kept
                return copy if copy.is_file() else Path(name)
            place, folder = (self.path / name).resolve(), self.path.resolve()
        except RuntimeError:
            raise refusal("link-loop", f"{name} is a symbolic link that leads back to itself", None) from None
        except (OSError, ValueError):
            raise refusal("file-not-found", "this cannot be the name of a file", None) from None
        if kept.parts[:1] == ("..",) or not place.is_relative_to(folder):
            message = f"{name} leads out of the folder of the spec"
            raise refusal("outside-of-folder", message, "move the file beside the spec, or write its absolute path")
        return place


def folder_of_files(spec: Path) -> Path:
    """Where the files are that a spec names by relative paths: beside it; of the spec of a run or map, the copies."""
    copies = spec.parent / COPIES
    kept = copies.is_dir() and any((spec.parent / name).is_file() for name in (RUN_MANIFEST, MAP_DATA))
    return copies if kept else spec.parent


def digest_of(files: Sequence[NamedFile]) -> str:
    """A hash of the contents of files."""
    each = "".join(hashlib.sha256(file.content).hexdigest() for file in files)
    return hashlib.sha256(each.encode()).hexdigest()


def _kept_as(name: str) -> Path:
    plain = Path(os.path.normpath(name))
    return Path(KEPT, *plain.parts[1:]) if plain.is_absolute() else plain


def _looked_in(name: str) -> str | None:
    if name.startswith("~"):
        return "~ stands for no folder here: write the whole path"
    return None if Path(name).is_absolute() else "a relative path starts at the folder of the spec"


def refusal(code: str, message: str, hint: str | None) -> DiagnosticError:
    """One complaint, without a place."""
    return DiagnosticError([Diagnostic(code, message, hint=hint)])
