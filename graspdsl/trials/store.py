"""The folder of a run: manifest, spec, a table with a row for each finished trial, packs of trajectories.

The table is SQLite's, with one writer at a time. While a run is held, its table is in write-ahead mode, so that a trial
is committed in a tenth of a millisecond and others may read meanwhile; after that it is one file again, which can be
read where nothing can be written.
"""

from __future__ import annotations

import dataclasses
import json
import os
import re
import shlex
import shutil
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter

from graspdsl.diagnostics import Diagnostic, DiagnosticError, listed
from graspdsl.places.files import COPIES, RUN_MANIFEST, NamedFile, read_text
from graspdsl.plugins.answering import answered_for
from graspdsl.plugins.kinds import Plugin
from graspdsl.spec.trials import MOST_TRIALS
from graspdsl.trials.folders import LOCK, locked, unwritable
from graspdsl.trials.interruption import interruption
from graspdsl.trials.packs import DamagedPieceError, Packs, Piece, absent
from graspdsl.trials.record import Duration, PackedTrial, TrialRecord
from graspdsl.trials.rows import COLUMNS, record_of, row_of
from graspdsl.trials.trajectories import DamagedTrajectoryError, Layout, Rows, unpacked

MANIFEST, SPEC, TABLE, TRAJECTORIES = RUN_MANIFEST, "spec.yaml", "trials.sqlite", "trajectories"
POINTS = "points"  # of a sweep: the folder of their reports
FILES = COPIES  # of those that the spec names
LAYOUT = 2  # of a run's folder; the first had a file for each trajectory, and no number
ADDED = {"touching"}  # columns that trials of earlier versions lack, which can be made up for
_NUMBER = re.compile(r"[0-9]{3,4}", re.ASCII)
PIECES = "number INTEGER PRIMARY KEY, offset INTEGER, size INTEGER, checksum INTEGER"


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a run is: enough to repeat it. ``overrides`` as given with --set, in order; ``wall_s`` spent so far;
    ``plugins``: what it uses of other packages and of its own code; ``points``: of a sweep, those of each point, which
    have equally many of the trials, one point's behind the other's."""

    name: str
    spec_file: str
    overrides: tuple[str, ...]
    seed: Annotated[int, Field(ge=0, le=2**63 - 1)]
    asked: Annotated[int, Field(ge=1, le=MOST_TRIALS)]
    versions: Mapping[str, str]
    wall_s: Duration = 0.0
    plugins: tuple[Plugin, ...] = ()
    points: tuple[tuple[str, ...], ...] = ()

    def as_json(self) -> bytes:
        """The content of its file. Raises DiagnosticError for names that are no text."""
        try:
            return (json.dumps(dataclasses.asdict(self), indent=2, ensure_ascii=False) + "\n").encode("utf-8")
        except UnicodeEncodeError as error:
            raise _refused("not-utf8", "a name in the manifest of this run is not UTF-8 text", "rename it") from error

    @property
    def made_with(self) -> dict[str, str]:
        """The versions of all packages that its trials depend on, those of plug-ins too."""
        return {**self.versions, **{plugin.distribution: plugin.version for plugin in self.plugins if plugin.version}}

    @property
    def settings(self) -> tuple[str, ...]:
        """The overrides but for the number of trials and their seed, which the manifest names."""
        return tuple(word for word in self.overrides if not word.startswith(("trials.count=", "trials.seed=")))


class RunFolder:
    """A run on disk. Each finished trial is committed at once, so an interrupted run keeps what it has.

    ``allow_code``: whether the Python files in it, which its spec names, may be run. ``point``: of a run that is a
    sweep the number of one of its points, ``whole`` then the folder of all. What is read of it are the trials of that
    point alone, numbered from 0, as of a run of its own, whose folder is that of its report.
    """

    def __init__(
        self,
        path: Path,
        manifest: Manifest,
        *,
        allow_code: bool = False,
        point: int | None = None,
        whole: Path | None = None,
    ) -> None:
        self.path, self.manifest, self.allow_code = path, manifest, allow_code
        self.point, self.whole = point, whole or path
        self._first = manifest.asked * (point or 0)  # of its trials, by the numbers in the table
        self.packs = Packs(self.whole / TRAJECTORIES, self._first)
        self._held: os.stat_result | None = None
        self._open: sqlite3.Connection | None = None  # while it is held
        self._believed: dict[int, TrialRecord] = {}  # by hashes of the rows that hold them

    @classmethod
    def create(
        cls,
        path: Path,
        manifest: Manifest,
        spec_text: str,
        files: Sequence[NamedFile] = (),
        *,
        allow_code: bool = False,
    ) -> RunFolder:
        """A new run folder, with copies of files. Raises DiagnosticError where one cannot be made."""
        folder = cls(path, manifest, allow_code=allow_code)
        content = manifest.as_json()  # or refused, before there is anything to leave half made
        with folder._writing():
            path.mkdir(parents=True, exist_ok=True)
            occupied = any(path.iterdir())
            try:
                if not occupied:
                    (path / TRAJECTORIES).mkdir()
            except FileExistsError:  # another run was begun here at the same moment
                occupied = True
            if occupied:
                raise _refused("folder-not-empty", "this folder is not empty", "name another, or go on with --resume")
            try:
                folder._fill(content, spec_text, files)
            except BaseException:  # half a run is none
                shutil.rmtree(path, ignore_errors=True)
                raise
        return folder

    def _fill(self, manifest: bytes, spec_text: str, files: Sequence[NamedFile]) -> None:
        (self.path / SPEC).write_text(spec_text, encoding="utf-8")
        for file in files:
            file.copy_into(self.files)
        (self.path / TABLE).touch()
        with self.table() as table:
            table.execute(f"CREATE TABLE trials ({', '.join(COLUMNS)}, PRIMARY KEY (number))")
            table.execute(f"CREATE TABLE trajectories ({PIECES})")
            table.execute(f"PRAGMA user_version = {LAYOUT}")
        self._save_manifest(manifest)  # last of all, which makes it a run

    @classmethod
    def open(cls, path: Path, *, allow_code: bool = False) -> RunFolder:
        """The run in a folder. Raises DiagnosticError when there is none."""
        folder = cls.at(path, allow_code=allow_code)
        if not folder.manifest.plugins:  # which may have outcomes and grades that are known once the spec is read
            folder.records()
        return folder

    @classmethod
    def at(cls, path: Path, *, allow_code: bool = False) -> RunFolder:
        """The run in a folder, of which nothing but the manifest has been read. Raises DiagnosticError when there is
        none."""
        if (place := _point_at(path)) is not None:
            whole = cls.at(place[0], allow_code=allow_code)
            if place[1] < len(whole.manifest.points):
                return whole.at_point(place[1])
        try:
            manifest = TypeAdapter(Manifest).validate_json(read_text(path / MANIFEST), strict=True)
        except (DiagnosticError, ValueError) as error:
            hint = "give the folder that 'graspdsl run' made"
            if _is_missing(path):
                raise _refused("folder-not-found", "there is no such folder", hint) from error
            raise _refused("not-a-run", f"this is no run: there is no readable {MANIFEST} in it", hint) from error
        return cls(path, manifest, allow_code=allow_code)

    def at_point(self, point: int) -> RunFolder:
        """A point of a sweep as a run, to be read."""
        manifest = self.manifest
        one = dataclasses.replace(
            manifest,
            overrides=manifest.points[point],
            asked=manifest.asked // len(manifest.points),
            points=(),
        )
        path = self.path / POINTS / f"{point:03d}"
        return RunFolder(path, one, allow_code=self.allow_code, point=point, whole=self.path)

    def check_whole(self) -> None:
        """Raises DiagnosticError for a point of a sweep, which is run, mended and removed as a whole."""
        if self.point is not None:
            message = "this is one point of a sweep, which is run, mended and removed as a whole"
            raise _refused("part-of-a-sweep", message, f"name the sweep: {self.whole}")

    @property
    def files(self) -> Path:
        """Where the copies of the files are that the spec names."""
        return self.whole / FILES

    @property
    def spec_text(self) -> str:
        """The text of the spec that was run, before overrides. Raises DiagnosticError when it is lost."""
        try:
            return read_text(self.whole / SPEC)
        except DiagnosticError as error:
            raise self._damaged(SPEC, error.diagnostics[0].message) from error

    @contextmanager
    def held(self) -> Iterator[None]:
        """Within, no other process runs this run's trials. What one that was killed left half written is removed.

        Raises DiagnosticError where another does, or where nothing can be written.
        """
        self.check_whole()
        if self._held is not None:  # by whoever reads what is finished, then executes the rest
            yield
            return
        with ExitStack() as stack:
            with self._writing():
                stack.enter_context(locked(self.path))
                for left in self.path.glob(f"{MANIFEST}.*new"):
                    left.unlink()
                self.packs.cut(self.pieces())
                self._held = (self.path / LOCK).stat()
                stack.callback(self._let_go)
            yield

    def _let_go(self) -> None:
        """Make the table one file again, unless somebody reads it right now."""
        table, self._open, self._held = self._open, None, None
        if table is not None:
            with closing(table), suppress(sqlite3.Error):
                if (self.whole / TABLE).is_file():
                    table.execute("PRAGMA journal_mode = DELETE")

    def add(self, trial: PackedTrial) -> None:
        """Keep a finished trial: the trajectory first, then its row, committed. Raises DiagnosticError if it cannot, or
        where a thing of another package says of it what could not be read again."""
        marks = ", ".join("?" for _ in COLUMNS)
        with answered_for(self.manifest.plugins):
            row = row_of(trial.record)
            if self.manifest.plugins:
                record_of(row)
        with self._writing():
            piece = self.packs.put(trial.record.number, trial.trajectory)
            if self._held is not None and self._open is None:
                self._open = self._connected()
                self._open.execute("PRAGMA journal_mode = WAL")  # or as before where the file system knows no other
                self._open.execute("PRAGMA synchronous = NORMAL")  # what was committed outlives its process
            with self.table() as table:
                table.execute(f"INSERT OR REPLACE INTO trials VALUES ({marks})", row)
                table.execute("INSERT OR REPLACE INTO trajectories VALUES (?, ?, ?, ?)", piece)

    def records(self, number: int | None = None) -> list[TrialRecord]:
        """The trials in the table, by number, or one of them. Raises DiagnosticError when it cannot be read or holds no
        such trials."""
        chosen = "" if number is None else f"AND number = {self._first + number:d} "
        rows = self._rows_of("trials", COLUMNS, f"{chosen}ORDER BY number")
        known = self._believed  # to make a record of a row takes its time, and most rows are as they were
        found = [(key, known.get(key) or self.believed(row)) for key, row in ((hash(row), row) for row in rows)]
        if number is None:
            self._believed = dict(found)
        return [record for _, record in found]

    def outcomes(self) -> dict[str, int]:
        """How many of the trials in the table ended in which way, counted without a look at what else they hold."""
        return dict(self._rows_of("trials", ("outcome", "count(*)"), "GROUP BY outcome"))

    def identities(self) -> dict[int, str]:
        """The identities of the trials in the table, by number."""
        return dict(self._rows_of("trials", ("number", "identity")))

    def pieces(self, number: int | None = None) -> list[Piece]:
        """Where the trajectories of its trials are, or that of one of them."""
        chosen = "" if number is None else f"AND number = {self._first + number:d}"
        rows = self._rows_of("trajectories", Piece._fields, chosen)
        if any(type(value) is not int or value < 0 for row in rows for value in row):
            raise self._damaged(TABLE, "a trajectory has no place")
        return [Piece(*row) for row in rows]

    def _rows_of(self, table: str, columns: Sequence[str], more: str = "") -> list[tuple[Any, ...]]:
        """Of a table those rows that are of its trials, with their own numbers."""
        mine, of_mine = "true", list(columns)
        if self.point is not None:
            mine = f"number BETWEEN {self._first} AND {self._first + self.manifest.asked - 1}"
            of_mine = [f"number - {self._first}" if name == "number" else name for name in columns]
        return self._read(f"SELECT {', '.join(of_mine)} FROM {table} WHERE {mine} {more}")

    def _read(self, statement: str) -> list[tuple[Any, ...]]:
        if not (self.whole / TABLE).is_file():
            raise self._damaged(TABLE, "there is no such file")
        try:
            with self.table() as table:
                self._check_layout(table)
                return table.execute(statement).fetchall()
        except sqlite3.Error as error:
            if getattr(error, "sqlite_errorcode", None) in (sqlite3.SQLITE_BUSY, sqlite3.SQLITE_LOCKED):
                message = f"another program holds this run's {TABLE}"
                raise _refused("run-in-use", message, "try again when it has ended") from error
            raise self._damaged(TABLE, str(error)) from error

    def _check_layout(self, table: sqlite3.Connection) -> None:
        layout, known = layout_of(table)
        if not known:
            raise self._damaged(TABLE, "there is no table of trials in it")
        if layout == LAYOUT and known == set(COLUMNS):
            return
        differing = listed([*([] if layout == LAYOUT else ["its layout"]), *sorted(known ^ set(COLUMNS))])
        message = f"this run was made by another version of graspdsl, whose {TABLE} differs in {differing}"
        hint = "read it with the version that made it, or run its spec again"
        if is_of_earlier_layout(table):
            hint = f"make it one of this version: graspdsl doctor {shlex.quote(str(self.path))} --repair"
        raise _refused("run-differs", message, hint)

    def believed(self, row: Sequence[object]) -> TrialRecord:
        """The trial that a row of the table holds. Raises DiagnosticError for one that no trial of the run has."""
        try:
            record = record_of(row)
            if record.number >= self.manifest.asked:
                raise ValueError(f"number: the run has {self.manifest.asked} trials, from 0 on")
        except ValueError as error:
            named = f"trial {row[0]}: " if isinstance(row[0], int) else "a row without the number of a trial: "
            raise self._damaged(TABLE, f"{named}{error}") from error
        return record

    def finished(self) -> list[TrialRecord]:
        """The trials that need not be run again: those in the table whose trajectories are as they were written, by
        their checksums; nothing is unpacked."""
        whole = self.packs.whole(self.pieces())
        return [record for record in self.records() if record.number in whole]

    def trajectory(self, number: int, layout: Layout | None = None) -> Rows:
        """The arrays of a trial's trajectory, a row a tick that is kept, as of :func:`unpacked`.

        Raises DiagnosticError when they cannot be read or do not fit the layout.
        """
        [piece] = self.pieces(number) or [absent(number)]
        return self.unpacked(piece, layout)

    def unpacked(self, piece: Piece, layout: Layout | None = None) -> Rows:
        """As :meth:`trajectory`, from a place that is known."""
        try:
            return unpacked(self.packs.content(piece), layout)
        except (DamagedPieceError, DamagedTrajectoryError) as error:
            name = f"{TRAJECTORIES}/{self.packs.file(piece.number).name}"
            raise self._damaged(name, f"trial {piece.number}: {error}") from error

    def spend(self, wall_s: float) -> None:
        """Add to the wall time that the run has taken."""
        self.manifest = dataclasses.replace(self.manifest, wall_s=self.manifest.wall_s + wall_s)
        content = self.manifest.as_json()
        with self._writing():
            self._save_manifest(content)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            with interruption.whole():
                self._check_place()
                yield
        except (OSError, sqlite3.Error) as error:
            self._check_place()
            raise unwritable(error) from error

    def _check_place(self) -> None:
        """A run that is being written to must be where it was: not removed, nor another one's by now."""
        if self._held is None:
            return
        if not _is(self.path / LOCK, self._held):
            hint = "if it was moved, go on with --resume and its new name; if not, nothing is kept: begin a new run"
            raise _refused("folder-gone", "this folder was removed or moved while its trials were run", hint)
        if not (self.whole / TABLE).is_file():
            raise self._damaged(TABLE, "there is no such file")

    def _damaged(self, file: str, reason: str) -> DiagnosticError:
        message = f"this run is damaged: its {file} cannot be read: {reason}"
        return _refused("run-damaged", message, f"begin a new run, from its {SPEC} if that is left")

    def _save_manifest(self, content: bytes) -> None:
        draft = self.path / f"{MANIFEST}.new"
        try:
            draft.write_bytes(content)
            draft.replace(self.path / MANIFEST)
        finally:
            draft.unlink(missing_ok=True)

    @contextmanager
    def table(self) -> Iterator[sqlite3.Connection]:
        """The table, for one transaction."""
        if self._open is not None:
            with self._open:
                yield self._open
            return
        with closing(self._connected()) as connection, connection:
            yield connection

    def _connected(self) -> sqlite3.Connection:
        place = f"{(self.whole / TABLE).absolute().as_uri()}?mode=rw"  # which makes none where there is none
        return sqlite3.connect(place, uri=True)


def _point_at(path: Path) -> tuple[Path, int] | None:
    """The folder of a sweep and the number of its point, if a folder looks like that of one."""
    place = path if len(path.parts) > 2 else path.absolute()
    run = place.parent.parent
    if place.parent.name != POINTS or not _NUMBER.fullmatch(place.name) or not (run / MANIFEST).is_file():
        return None
    return run, int(place.name)


def layout_of(table: sqlite3.Connection) -> tuple[int, set[str]]:
    """The number of a table's layout, and the names of the columns of its trials; none where there is no such table."""
    [(layout,)] = table.execute("PRAGMA user_version")
    return layout, {name for _, name, *_ in table.execute("PRAGMA table_info(trials)")}


def is_of_earlier_layout(table: sqlite3.Connection) -> bool:
    """Whether the table is of a run that can be made one of the present layout."""
    layout, known = layout_of(table)
    return layout <= LAYOUT and known == set(COLUMNS) - ADDED


def _is(path: Path, known: os.stat_result) -> bool:
    try:
        return os.path.samestat(path.stat(), known)
    except OSError:
        return False


def _is_missing(path: Path) -> bool:
    try:
        path.stat()
    except FileNotFoundError:
        return True
    except (OSError, ValueError):  # something that may not be looked at, or a name that nothing can have
        return False
    return False


def _refused(code: str, message: str, hint: str) -> DiagnosticError:
    return DiagnosticError([Diagnostic(code, message, hint=hint)])
