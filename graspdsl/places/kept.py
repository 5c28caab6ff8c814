"""What is made of the package's own files alone, kept beside its bytecode, and made anew when one of them changes."""

from __future__ import annotations

import os
import pickle
import sys
import zlib
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import TypeVar

T = TypeVar("T")

PACKAGE = Path(__file__).parents[1]
MADE_OF = (".py", ".yaml", ".lark")


def kept(name: str, version: str, make: Callable[[], T]) -> T:
    """What ``make`` makes of the package's own files, read back where it has been made before.

    ``version``: of the library that it is made with. Nothing of what a user gives may go into it.
    """
    tag = f"{name}.{sys.implementation.cache_tag}"
    key = zlib.crc32(repr((version, _files())).encode())
    place = PACKAGE / "__pycache__" / f"{tag}.{key:08x}.pickle"
    with suppress(Exception), place.open("rb") as file:  # not there, or none that can be read: then it is made
        found: T = pickle.load(file)
        return found
    made = make()
    if not sys.dont_write_bytecode:
        with suppress(OSError):  # nobody may write there
            place.parent.mkdir(exist_ok=True)
            own = place.with_suffix(f".{os.getpid()}")
            own.write_bytes(pickle.dumps(made, pickle.HIGHEST_PROTOCOL))
            own.replace(place)
            for other in {*place.parent.glob(f"{tag}.*.pickle")} - {place}:
                other.unlink(missing_ok=True)
    return made


@cache
def _files() -> tuple[tuple[str, int, int], ...]:
    """The files that the package is made of, each with the time of its last change and its size, as for bytecode."""
    return tuple(sorted(_files_in(str(PACKAGE))))


def _files_in(folder: str) -> Iterator[tuple[str, int, int]]:
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.name.endswith(MADE_OF):
                status = entry.stat()
                yield entry.path, status.st_mtime_ns, status.st_size
            elif entry.is_dir() and entry.name != "__pycache__":
                yield from _files_in(entry.path)
