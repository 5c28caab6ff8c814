"""Files that a user named, or that a spec names, read within bounds."""

from __future__ import annotations

import codecs
import os
import stat
from collections.abc import Sequence
from dataclasses import dataclass, field
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
            raise refusal("is-a-directory", "this is a directory, not a file", "name a YAML file in it")
        if not stat.S_ISREG(mode.st_mode):
            # A pipe or a device may never end, or never begin.
            raise refusal("not-a-file", "this is not a regular file", "save the text to a file first")
        if mode.st_size > SIZE_LIMIT:
            raise too_large(mode.st_size)
        with path.open("rb") as file:
            content = file.read(SIZE_LIMIT + 1)
    except FileNotFoundError:
        raise refusal("file-not-found", "there is no such file", _neighbours(path)) from None
    except PermissionError:
        raise refusal("file-not-readable", "no permission to read this file", None) from None
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise refusal("file-not-readable", f"cannot read this file: {reason}", None) from None
    except ValueError:
        raise refusal("file-not-found", "this cannot be the name of a file", None) from None
    if len(content) > SIZE_LIMIT:
        raise too_large(len(content))
    return _decoded(content)


def too_large(size: int) -> DiagnosticError:
    """The refusal of a text of ``size`` bytes."""
    return refusal(
        "file-too-large",
        f"this file is too large: {size} bytes, where a spec may have {SIZE_LIMIT}",
        "check that this is the file you meant",
    )


def with_plain_line_ends(text: str) -> str:
    """The text without a byte order mark at its start and with ``\\n`` for every kind of line end."""
    return text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")


def _neighbours(path: Path) -> str | None:
    try:
        names = [entry.name for entry in path.parent.iterdir() if entry.suffix in {".yaml", ".yml"}]
    except OSError:
        return f"the folder {path.parent.name or path.parent} is not there or cannot be read"
    return known_names_hint(path.name, names[:100], "YAML files")


def _decoded(content: bytes) -> str:
    if content.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        raise refusal("not-utf8", "this file is UTF-16, not UTF-8", "save it as UTF-8")
    try:
        return with_plain_line_ends(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        message = f"this file is not UTF-8 text: byte {error.start + 1} is 0x{content[error.start]:02x}"
        hint = "save it as UTF-8, and check that it is a text file"
        raise refusal("not-utf8", message, hint) from None


LARGEST = 64 * 1024 * 1024  # bytes
RUN_MANIFEST, MAP_DATA = "run.json", "map.json"  # one of them is in the folder of a run or a map
COPIES = "files"  # of what its spec names, there
KEPT = "absolute-paths"  # where a run keeps its copies of files that a spec names by absolute paths


@dataclass(frozen=True, slots=True)
class NamedFile:
    """A file that was read: its place in a folder of copies, and its content."""

    kept_as: Path
    content: bytes

    def copy_into(self, folder: Path) -> None:
        """Write it to its place in a folder of copies. Raises OSError."""
        copy = folder / self.kept_as
        copy.parent.mkdir(parents=True, exist_ok=True)
        copy.write_bytes(self.content)


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
    import hashlib  # which loads OpenSSL

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
