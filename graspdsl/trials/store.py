"""The folder of a run: manifest, spec, a table row for each finished trial, trajectories."""

from __future__ import annotations

import dataclasses
import json
import math
import os
import sqlite3
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from graspdsl.arrays import Float32Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.spec.files import read_text
from graspdsl.spec.named_files import COPIES, RUN_MANIFEST, NamedFile
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord

MANIFEST, SPEC, TABLE, TRAJECTORIES = RUN_MANIFEST, "spec.yaml", "trials.sqlite", "trajectories"
FILES = COPIES  # of those that the spec names
_FIELDS = tuple(field.name for field in dataclasses.fields(TrialRecord))
_MAPPINGS = ("start", "quality")
_PAIRS = ("contact_forces", "point_error", "normal_error")


@dataclass(frozen=True, slots=True)
class Manifest:
    """What a run is: enough to repeat it. ``overrides`` as given with --set, in order; ``wall_s`` spent so far."""

    name: str
    spec_file: str
    overrides: tuple[str, ...]
    seed: int
    asked: int
    versions: Mapping[str, str]
    wall_s: float = 0.0


class RunFolder:
    """A run on disk. Each finished trial is committed at once, so an interrupted run keeps what it has."""

    def __init__(self, path: Path, manifest: Manifest) -> None:
        self.path, self.manifest = path, manifest

    @classmethod
    def create(cls, path: Path, manifest: Manifest, spec_text: str, files: Sequence[NamedFile] = ()) -> RunFolder:
        """A new run folder, with copies of files. Raises DiagnosticError where one cannot be made."""
        folder = cls(path, manifest)
        with folder._writing():
            path.mkdir(parents=True, exist_ok=True)
            try:
                occupied = any(path.iterdir())
                (path / TRAJECTORIES).mkdir()
            except FileExistsError:  # another run was begun here at the same moment
                occupied = True
            if occupied:
                raise _refused("folder-not-empty", "this folder is not empty", "name another, or go on with --resume")
            (path / SPEC).write_text(spec_text, encoding="utf-8")
            for file in files:
                copy = folder.files / file.kept_as
                copy.parent.mkdir(parents=True, exist_ok=True)
                copy.write_bytes(file.content)
            folder._save_manifest()
            with folder._table() as table:
                table.execute(f"CREATE TABLE trials ({', '.join(_FIELDS)}, PRIMARY KEY (number))")
        return folder

    @classmethod
    def open(cls, path: Path) -> RunFolder:
        """The run in a folder. Raises DiagnosticError when there is none."""
        try:
            manifest = TypeAdapter(Manifest).validate_json(read_text(path / MANIFEST))
        except (DiagnosticError, ValueError) as error:
            hint = "give the folder that 'graspdsl run' made"
            raise _refused("not-a-run", f"this is no run: there is no readable {MANIFEST} in it", hint) from error
        folder = cls(path, manifest)
        folder.records()
        return folder

    @property
    def files(self) -> Path:
        """Where the copies of the files are that the spec names."""
        return self.path / FILES

    @property
    def spec_text(self) -> str:
        """The text of the spec that was run, before overrides. Raises DiagnosticError when it is lost."""
        try:
            return read_text(self.path / SPEC)
        except DiagnosticError as error:
            raise self._damaged(SPEC, error.diagnostics[0].message) from error

    def add(self, trial: Trial) -> None:
        """Keep a finished trial: the trajectory first, then its row, committed. Raises DiagnosticError if it cannot."""
        row = trial.record.as_dict()
        marks = ", ".join("?" for _ in _FIELDS)
        with self._writing():
            self._save_trajectory(trial)
            with self._table() as table:
                values = [_stored(row[name]) for name in _FIELDS]
                table.execute(f"INSERT OR REPLACE INTO trials VALUES ({marks})", values)

    def records(self) -> list[TrialRecord]:
        """The trials in the table, by number. Raises DiagnosticError when it cannot be read."""
        if not (self.path / TABLE).is_file():
            raise self._damaged(TABLE, "there is no such file")
        try:
            with self._table() as table:
                rows = table.execute(f"SELECT {', '.join(_FIELDS)} FROM trials ORDER BY number").fetchall()
            return [_record(dict(zip(_FIELDS, row, strict=True))) for row in rows]
        except (sqlite3.Error, ValueError, TypeError, KeyError) as error:
            raise self._damaged(TABLE, str(error)) from error

    def finished(self) -> list[TrialRecord]:
        """The trials that need not be run again: those in the table whose trajectories are whole."""
        return [record for record in self.records() if zipfile.is_zipfile(self.trajectory_file(record.number))]

    def trajectory_file(self, number: int) -> Path:
        """Where the trajectory of a trial is."""
        return self.path / TRAJECTORIES / f"{number}.npz"

    def trajectory(self, number: int) -> dict[str, Float32Array]:
        """The arrays of a trial's trajectory, one row a tick. Raises DiagnosticError when it cannot be read."""
        file = self.trajectory_file(number)
        try:
            with np.load(file) as arrays:
                return {name: arrays[name] for name in arrays.files}
        except (OSError, ValueError, EOFError, zipfile.BadZipFile, zlib.error) as error:
            raise self._damaged(f"{TRAJECTORIES}/{file.name}", str(error)) from error

    def spend(self, wall_s: float) -> None:
        """Add to the wall time that the run has taken."""
        self.manifest = dataclasses.replace(self.manifest, wall_s=self.manifest.wall_s + wall_s)
        with self._writing():
            self._save_manifest()

    def _save_trajectory(self, trial: Trial) -> None:
        file = self.trajectory_file(trial.record.number)
        file.parent.mkdir(exist_ok=True)
        draft = file.with_suffix(f".{os.getpid()}.new")
        with draft.open("wb") as stream:
            np.savez_compressed(stream, **dict(trial.trajectory))  # type: ignore[arg-type]
        draft.replace(file)

    @contextmanager
    def _writing(self) -> Iterator[None]:
        try:
            yield
        except (OSError, sqlite3.Error) as error:
            reason = (error.strerror if isinstance(error, OSError) else None) or str(error)
            raise _refused("folder-not-writable", f"cannot write to this folder: {reason.lower()}", None) from error

    def _damaged(self, file: str, reason: str) -> DiagnosticError:
        message = f"this run is damaged: its {file} cannot be read: {reason}"
        return _refused("run-damaged", message, f"begin a new run, from its {SPEC} if that is left")

    def _save_manifest(self) -> None:
        text = json.dumps(dataclasses.asdict(self.manifest), indent=2, ensure_ascii=False)
        draft = self.path / f"{MANIFEST}.new"
        draft.write_text(text + "\n", encoding="utf-8")
        draft.replace(self.path / MANIFEST)

    @contextmanager
    def _table(self) -> Iterator[sqlite3.Connection]:
        with closing(sqlite3.connect(self.path / TABLE)) as connection, connection:
            yield connection


def fresh_folder(parent: Path, name: str) -> Path:
    """Makes an empty folder of this name and the next free number, ``parent/name-001``, that no other run gets.

    Raises DiagnosticError where it cannot be made.
    """
    number = 1
    try:
        parent.mkdir(parents=True, exist_ok=True)
        while True:
            folder = parent / f"{name}-{number:03d}"
            try:
                folder.mkdir()
            except FileExistsError:
                number += 1
            else:
                return folder
    except OSError as error:
        reason = (error.strerror or "unknown reason").lower()
        raise _refused("folder-not-writable", f"cannot write to this folder: {reason}", None) from error


def _refused(code: str, message: str, hint: str | None) -> DiagnosticError:
    return DiagnosticError([Diagnostic(code, message, hint=hint)])


def _stored(value: object) -> object:
    if isinstance(value, dict | tuple):
        return json.dumps(value)
    return None if isinstance(value, float) and math.isnan(value) else value


def _record(row: dict[str, Any]) -> TrialRecord:
    for name in _PAIRS:
        row[name] = tuple(json.loads(row[name]))
    for name, kind in TrialRecord.__annotations__.items():
        if kind == "float" and row[name] is None:
            row[name] = math.nan
    return TrialRecord(
        **{**row, "outcome": Outcome(row["outcome"]), **{name: json.loads(row[name]) for name in _MAPPINGS}}
    )
