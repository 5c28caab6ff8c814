"""What of a run is whole, and a run mended as far as what is there allows."""

from __future__ import annotations

import enum
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from graspdsl.compiler.program import Program
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.folders import is_locked, locked, unwritable
from graspdsl.trials.identity import check_origin
from graspdsl.trials.interruption import interruption
from graspdsl.trials.migrations import OF_ONE_TRIAL, migrate
from graspdsl.trials.packs import DamagedPieceError, Piece
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.rows import COLUMNS
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import TABLE, TRAJECTORIES, RunFolder, is_of_earlier_layout, layout_of
from graspdsl.trials.trajectories import DamagedTrajectoryError, Layouts, layouts_of, unpacked

# Drafts of files that a process which was killed had begun, and files of an earlier layout that are in packs by now.
LEFT_OVER = ("*.new", f"{TRAJECTORIES}/*.new", "figures/*.new", f"{TRAJECTORIES}/{OF_ONE_TRIAL}")
REPAIR, RESUME, ANEW = "--repair", "run --resume", "begin a new run"
BOTH, LATER = f"{REPAIR}, then {RESUME}", "see to the rest first"


class Verdict(enum.StrEnum):
    """What is said of a part of a run; a ``note`` is of what does no harm."""

    WHOLE = "whole"
    NOTE = "note"
    FAULT = "fault"


@dataclass(frozen=True, slots=True)
class Finding:
    """What was found of a part of a run, of which ``trials``, by number, and what mends it."""

    part: str
    verdict: Verdict
    says: str
    trials: tuple[int, ...] = ()
    mended_by: str = ""


@dataclass(slots=True)
class Health:
    """What was found of a run, and what can be mended of it: a layout of ``earlier`` versions; ``rows``, by SQLite's
    numbers of them, that no trial has; ``pieces``, by trial, that are damaged or of no trial; ``packs`` with bytes that
    belong to no piece; files ``left`` over."""

    findings: list[Finding] = field(default_factory=list)
    earlier: bool = False
    rows: list[int] = field(default_factory=list)
    pieces: list[int] = field(default_factory=list)
    packs: list[Path] = field(default_factory=list)
    left: list[Path] = field(default_factory=list)

    @property
    def sound(self) -> bool:
        """Whether nothing is wrong."""
        return all(finding.verdict is not Verdict.FAULT for finding in self.findings)

    def whole(self, part: str, says: str) -> None:
        """A part that is as it should be."""
        self.findings.append(Finding(part, Verdict.WHOLE, says))

    def note(self, part: str, says: str, mended_by: str = "") -> None:
        """A part of which something does no harm."""
        self.findings.append(Finding(part, Verdict.NOTE, says, (), mended_by))

    def fault(self, part: str, says: str, mended_by: str, trials: Iterable[int] = ()) -> None:
        """A part that is wrong."""
        self.findings.append(Finding(part, Verdict.FAULT, says, tuple(sorted(trials)), mended_by))


def examined(folder: RunFolder, *, mine: bool = False) -> Health:
    """What of a run is whole, part by part; it may be run meanwhile, and is told as it is now.

    Nothing of a run can be mended whose trials did not come from the spec that it holds: by another spec all that is
    whole would look damaged. mine: whether who asks has the lock of its folder.
    """
    folder.check_whole()
    health, manifest = Health(), folder.manifest
    health.whole("manifest", f"{manifest.name}, seed {manifest.seed}, {manifest.asked} asked for")
    program = _spec(folder, health)
    running = not mine and is_locked(folder.path)
    try:
        with folder.table() as table:
            table.execute("BEGIN")  # so that rows and places are of one moment
            if not _table(table, health):
                return health
            rows = table.execute(f"SELECT rowid, {', '.join(COLUMNS)} FROM trials ORDER BY number").fetchall()
            columns = ", ".join(Piece._fields)
            pieces = [Piece(*row) for row in table.execute(f"SELECT {columns} FROM trajectories ORDER BY number")]
    except sqlite3.Error as error:
        health.fault("table", f"{TABLE} cannot be read: {error}", ANEW)
        return health
    if program is None and manifest.plugins:
        health.note("rows", "not looked at: what they may hold is known once the spec can be read", LATER)
        return health
    believed, doubted = _told_apart(folder, rows)
    layout = _origin(folder, program, believed, health) if program is not None else None
    known = program is not None and health.sound
    _rows(doubted, believed, health, known=known)
    kept = _trajectories(folder, layout, pieces, {record.number for record in believed}, health, known=known)
    if known and not running:  # else the end of a pack, or a draft, is being written
        _bytes_of_nothing(folder, kept, health)
        _left_over(folder, health)
    said = "running" if running else "complete" if len(believed) == manifest.asked else "unfinished"
    health.whole("state", f"{said}: {len(believed)} of {manifest.asked}")
    return health


def _spec(folder: RunFolder, health: Health) -> Program | None:
    try:
        program = program_of_run(folder)
    except DiagnosticError as error:
        health.fault("spec", error.diagnostics[0].message, "put its own back, or " + ANEW)
        return None
    health.whole("spec", folder.manifest.spec_file)
    return program


def _table(table: sqlite3.Connection, health: Health) -> bool:
    """Whether there is more to be read from it."""
    found = [said for (said,) in table.execute("PRAGMA integrity_check")]
    if found != ["ok"]:
        health.fault("table", f"{TABLE} is damaged: {found[0]}", ANEW)
    elif is_of_earlier_layout(table):
        health.earlier = True
        health.fault("table", "this run was made by an earlier version, which kept its trials otherwise", REPAIR)
    elif layout_of(table)[1] != {*COLUMNS}:
        health.fault("table", "this run was made by another version, whose trials have other columns", ANEW)
    else:
        health.whole("table", TABLE)
        return True
    return False


def _told_apart(
    folder: RunFolder, rows: Sequence[Sequence[Any]]
) -> tuple[list[TrialRecord], list[tuple[Sequence[Any], str]]]:
    """The trials that rows hold, and the rows that hold none, with why; each row begins with SQLite's number of it."""
    believed, doubted = list[TrialRecord](), list[tuple[Sequence[Any], str]]()
    for row in rows:
        try:
            believed.append(folder.believed(row[1:]))
        except DiagnosticError as error:
            doubted.append((row, error.diagnostics[0].message.rpartition("cannot be read: ")[2]))
    return believed, doubted


def _origin(folder: RunFolder, program: Program, believed: Sequence[TrialRecord], health: Health) -> Layouts | None:
    """The layouts of its trajectories, where its trials are known to be the program's."""
    try:
        warnings = check_origin(folder, program, {record.number: record.identity for record in believed})
    except DiagnosticError as error:
        health.fault("origin", error.diagnostics[0].message, error.diagnostics[0].hint or "")
        return None
    for warning in warnings:
        health.note("origin", warning.message)
    if not warnings:
        health.whole("origin", "its trials came from this spec, these files and this seed")
    return None if warnings else layouts_of(program)


def _rows(
    doubted: Sequence[tuple[Sequence[Any], str]], believed: Sequence[TrialRecord], health: Health, *, known: bool
) -> None:
    if not doubted:
        health.whole("rows", str(len(believed)))
        return
    numbers = [row[1] for row, _ in doubted if isinstance(row[1], int)]
    said = f"{len(doubted)} that no trial has; the first: {doubted[0][1]}"
    health.fault("rows", said, BOTH if known else LATER, numbers)
    health.rows = [row[0] for row, _ in doubted] if known else []


def _trajectories(
    folder: RunFolder,
    layout: Layouts | None,
    pieces: Sequence[Piece],
    numbers: set[int],
    health: Health,
    *,
    known: bool,
) -> list[Piece]:
    """The pieces that are whole and of a trial."""
    kept, damaged, reasons = list[Piece](), list[int](), list[str]()
    placed = {piece.number for piece in pieces}
    absent, of_none = numbers - placed, placed - numbers
    for piece in pieces:
        if piece.number in of_none:
            continue
        try:
            if any(type(value) is not int or value < 0 for value in piece):
                raise DamagedPieceError("it has no place")
            unpacked(folder.packs.content(piece), layout and layout(piece.number))
        except (DamagedPieceError, DamagedTrajectoryError) as error:
            damaged.append(piece.number)
            reasons.append(str(error))
        else:
            kept.append(piece)
    if damaged:
        said = f"{len(damaged)} damaged; the first: {reasons[0]}"
        health.fault("trajectories", said, BOTH if known else LATER, damaged)
    if absent:
        health.fault("trajectories", f"{len(absent)} not there", RESUME if known else LATER, absent)
    if not damaged and not absent:
        health.whole("trajectories", str(len(kept)))
    if of_none:
        health.note("trajectories", f"{len(of_none)} of no trial", REPAIR if known else LATER)
    health.pieces = [*damaged, *of_none] if known else []
    return kept


def _bytes_of_nothing(folder: RunFolder, kept: Sequence[Piece], health: Health) -> None:
    sizes = dict.fromkeys(folder.packs.all(), 0)
    for piece in kept:
        if piece.size:
            sizes[folder.packs.file(piece.number)] += piece.size
    dead = {pack: pack.stat().st_size - size for pack, size in sizes.items()}
    health.packs = [pack for pack, size in sizes.items() if dead[pack] > 0 or not size]
    if health.packs:
        health.note("packs", f"{sum(dead.values())} bytes in {len(health.packs)} of them belong to nothing", REPAIR)
    else:
        health.whole("packs", str(len(sizes)))


def _left_over(folder: RunFolder, health: Health) -> None:
    health.left = sorted(file for pattern in LEFT_OVER for file in folder.path.glob(pattern) if file.is_file())
    if health.left:
        others = f" and {len(health.left) - 1} others" if len(health.left) > 1 else ""
        health.note("files", f"left over: {health.left[0].relative_to(folder.path)}{others}", REPAIR)


def mended(folder: RunFolder) -> list[str]:
    """Mend what can be of a run: an earlier layout becomes the present one; rows that no trial has and trajectories
    that are damaged go, so that resuming the run runs these trials again; so do bytes in packs and files that belong to
    nothing. Returns what was done, in words.

    Raises DiagnosticError where another process has the run, or its folder cannot be written to.
    """
    folder.check_whole()
    with locked(folder.path):
        try:
            return list(_mended(folder))
        except (OSError, sqlite3.Error) as error:
            raise unwritable(error) from error


def _mended(folder: RunFolder) -> Iterator[str]:
    health = examined(folder, mine=True)
    if health.earlier:
        whole, damaged = migrate(folder)
        yield f"trials of an earlier version: {whole}" + (f"; damaged, to be run again: {damaged}" if damaged else "")
        health = examined(folder, mine=True)
    if any(finding.part == "table" and finding.verdict is Verdict.FAULT for finding in health.findings):
        return
    for file in health.left:  # before packs have drafts again
        file.unlink()
    if health.left:
        yield f"files removed: {len(health.left)}"
    if health.rows or health.pieces:
        with folder.table() as table:
            table.execute("BEGIN")
            table.executemany("DELETE FROM trials WHERE rowid = ?", [(row,) for row in health.rows])
            table.executemany("DELETE FROM trajectories WHERE number = ?", [(number,) for number in health.pieces])
        yield f"rows removed: {len(health.rows)}; trajectories removed: {len(health.pieces)}"
    if health.packs:
        pieces = folder.pieces()
        before = sum(pack.stat().st_size for pack in health.packs)
        for pack in health.packs:
            _rewrite(
                folder, pack, [piece for piece in pieces if piece.size and folder.packs.file(piece.number) == pack]
            )
        after = sum(pack.stat().st_size for pack in health.packs if pack.exists())
        yield f"bytes removed from packs: {before - after}"
    with suppress(sqlite3.OperationalError), folder.table() as table:  # which somebody may be reading right now
        table.execute("PRAGMA journal_mode = DELETE")  # one file again, where a process that wrote it was killed


def _rewrite(folder: RunFolder, pack: Path, pieces: Sequence[Piece]) -> None:
    """A pack without bytes of nothing. Whoever is killed between the two steps at the end loses its trajectories, whose
    trials are then run again."""
    draft, moved = folder.packs.drafted(pack, pieces)
    with interruption.whole():
        with folder.table() as table:
            table.execute("BEGIN")
            table.executemany("REPLACE INTO trajectories VALUES (?, ?, ?, ?)", moved)
        draft.replace(pack)
        if not pieces:
            pack.unlink()
