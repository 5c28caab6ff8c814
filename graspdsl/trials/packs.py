"""Packs: files that the pieces of many trials are put into, one behind the other."""

from __future__ import annotations

import itertools
import os
import zlib
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO, NamedTuple

EACH = 1000  # trials a pack
SUFFIX = ".npy.gz"


class Piece(NamedTuple):
    """Where a trial's piece is in its pack: the number of the trial, the first byte, how many there are, and their
    checksum (CRC-32)."""

    number: int
    offset: int
    size: int
    checksum: int


def absent(number: int) -> Piece:
    """The piece of a trial that has none, which cannot be read."""
    return Piece(number, 0, -1, 0)


class DamagedPieceError(Exception):
    """A piece that is not as it was written; says why."""


class Packs:
    """The packs in a folder: of trials 0 to 999, 1000 to 1999 and so on. Pieces are only ever put behind others: what a
    process that was killed has not put there whole is cut off by the next that writes. Trials may be numbered from
    ``number`` on."""

    def __init__(self, folder: Path, number: int = 0) -> None:
        self.folder, self._number = folder, number

    def file(self, number: int) -> Path:
        """The pack that a trial's piece is in."""
        return self._file(self._place(number))

    def _place(self, number: int) -> int:
        """Of the pack of a trial among all."""
        return (self._number + number) // EACH

    def _file(self, place: int) -> Path:
        first = place * EACH
        return self.folder / f"{first:06d}-{first + EACH - 1:06d}{SUFFIX}"

    def all(self) -> list[Path]:
        """The packs that there are."""
        return sorted(self.folder.glob(f"*{SUFFIX}"))

    def put(self, number: int, content: bytes) -> Piece:
        """Put a trial's piece behind those there are; nothing is written of an empty one. Raises OSError, and leaves no
        part of it."""
        if not content:
            return Piece(number, 0, 0, 0)
        self.folder.mkdir(exist_ok=True)
        with self.file(number).open("ab", buffering=0) as pack:
            offset = pack.seek(0, os.SEEK_END)
            try:
                left = memoryview(content)
                while left:
                    left = left[pack.write(left) :]
            except BaseException:
                pack.truncate(offset)
                raise
        return Piece(number, offset, len(content), zlib.crc32(content))

    def content(self, piece: Piece) -> bytes:
        """The bytes of a piece. Raises DamagedPieceError where they are not those that were put there."""
        if piece == absent(piece.number):
            raise DamagedPieceError("it is not among those that are kept")
        if not piece.size:
            return b""
        try:
            with self.file(piece.number).open("rb") as pack:
                return _read(pack, piece)
        except OSError as error:
            raise DamagedPieceError(str(error.strerror or error).lower()) from error

    def whole(self, pieces: Iterable[Piece]) -> set[int]:
        """The trials of those pieces that are as they were put there; nothing is unpacked, each pack is opened once."""
        ordered = sorted(pieces)
        found = {piece.number for piece in ordered if not piece.size}
        filled = (piece for piece in ordered if piece.size)
        for place, ones in itertools.groupby(filled, lambda piece: self._place(piece.number)):
            with suppress(OSError), self._file(place).open("rb") as pack:
                for piece in ones:
                    with suppress(DamagedPieceError):
                        _read(pack, piece)
                        found.add(piece.number)
        return found

    def cut(self, pieces: Iterable[Piece]) -> None:
        """Cut off what is behind the last of the pieces there are. Raises OSError."""
        ends = dict[int, int]()
        for piece in pieces:
            place = self._place(piece.number)
            ends[place] = max(ends.get(place, 0), piece.offset + piece.size)
        known = {self._file(place): end for place, end in ends.items()}
        for pack in self.all():
            if pack.stat().st_size > known.get(pack, 0):
                os.truncate(pack, known.get(pack, 0))

    def drafted(self, pack: Path, pieces: Iterable[Piece]) -> tuple[Path, list[Piece]]:
        """Write a pack anew, of these of its pieces alone, into a file beside it; where that is, and where the pieces
        are in it. Raises OSError, DamagedPieceError."""
        draft, moved, end = pack.with_name(f"{pack.name}.new"), list[Piece](), 0
        with draft.open("wb") as file:
            for piece in pieces:
                file.write(self.content(piece))
                moved.append(piece._replace(offset=end))
                end += piece.size
            file.flush()
            os.fsync(file.fileno())
        return draft, moved


def _read(pack: BinaryIO, piece: Piece) -> bytes:
    """The bytes of a piece in its pack. Raises OSError, DamagedPieceError."""
    if pack.seek(0, os.SEEK_END) - piece.offset < piece.size:
        raise DamagedPieceError("it ends too early")
    pack.seek(piece.offset)
    content = pack.read(piece.size)
    if zlib.crc32(content) != piece.checksum:
        raise DamagedPieceError("its checksum is not that of what was written")
    return content
