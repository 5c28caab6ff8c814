"""Runs on disk, for tests of what is made from them."""

from __future__ import annotations

from pathlib import Path

from graspdsl.compiler.program import program_of
from graspdsl.trials.runner import execute, new_run
from graspdsl.trials.store import RunFolder


def stored_run(place: Path, spec: Path, *overrides: str, begun: bool = True) -> RunFolder:
    """A run of a spec in a new folder, by one process; without any trial where it is not to have begun."""
    text = spec.read_text("utf-8")
    folder = new_run(place, program_of(text, spec.name, overrides))
    if begun:
        execute(folder, workers=1)
    return folder


def lose_trajectory(folder: RunFolder, number: int) -> None:
    """Turn a bit in the middle of what is kept of a trial's trajectory."""
    [piece] = [piece for piece in folder.pieces() if piece.number == number]
    file = folder.packs.file(number)
    content = bytearray(file.read_bytes())
    content[piece.offset + piece.size // 2] ^= 1
    file.write_bytes(content)
