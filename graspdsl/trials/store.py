"""The folder of a run: manifest, spec, a table row for each finished trial, trajectories."""

from __future__ import annotations

import dataclasses
import json
import math
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.arrays import Float32Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import Trial, TrialRecord

MANIFEST, SPEC, TABLE, TRAJECTORIES = "run.json", "spec.yaml", "trials.sqlite", "trajectories"
_FIELDS = tuple(field.name for field in dataclasses.fields(TrialRecord))
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
    def create(cls, path: Path, manifest: Manifest, spec_text: str) -> RunFolder:
        """A new run folder. Raises DiagnosticError where one cannot be made."""
        try:
            path.mkdir(parents=True, exist_ok=True)
            if any(path.iterdir()):
                raise _refused("folder-not-empty", f"{path} is not empty", "name a new folder, or go on with --resume")
            (path / TRAJECTORIES).mkdir()
            (path / SPEC).write_text(spec_text, encoding="utf-8")
        except OSError as error:
            raise _refused("folder-not-writable", f"cannot write to {path}: {error.strerror}", None) from error
        folder = cls(path, manifest)
        folder._save_manifest()
        with folder._table() as table:
            table.execute(f"CREATE TABLE trials ({', '.join(_FIELDS)}, PRIMARY KEY (number))")
        return folder

    @classmethod
    def open(cls, path: Path) -> RunFolder:
        """The run in a folder. Raises DiagnosticError when there is none."""
        try:
            raw = json.loads((path / MANIFEST).read_text("utf-8"))
            manifest = Manifest(**{**raw, "overrides": tuple(raw["overrides"])})
            with closing(sqlite3.connect(f"{(path / TABLE).resolve().as_uri()}?mode=ro", uri=True)) as table:
                table.execute(f"SELECT {', '.join(_FIELDS)} FROM trials LIMIT 1")
        except (OSError, ValueError, TypeError, KeyError, sqlite3.Error) as error:
            hint = "give the folder that 'graspdsl run' made; it holds run.json and trials.sqlite"
            raise _refused("not-a-run", f"{path} holds no readable run", hint) from error
        return cls(path, manifest)

    @property
    def spec_text(self) -> str:
        """The text of the spec that was run, before overrides."""
        return (self.path / SPEC).read_text("utf-8")

    def add(self, trial: Trial) -> None:
        """Keep a finished trial: the trajectory first, then its row, committed."""
        np.savez_compressed(self.trajectory_file(trial.record.number), **dict(trial.trajectory))  # type: ignore[arg-type]
        row = trial.record.as_dict()
        with self._table() as table:
            marks = ", ".join("?" for _ in _FIELDS)
            table.execute(f"INSERT OR REPLACE INTO trials VALUES ({marks})", [_stored(row[name]) for name in _FIELDS])

    def records(self) -> list[TrialRecord]:
        """The finished trials by number."""
        with self._table() as table:
            rows = table.execute(f"SELECT {', '.join(_FIELDS)} FROM trials ORDER BY number").fetchall()
        return [_record(dict(zip(_FIELDS, row, strict=True))) for row in rows]

    def trajectory_file(self, number: int) -> Path:
        """Where the trajectory of a trial is."""
        return self.path / TRAJECTORIES / f"{number}.npz"

    def trajectory(self, number: int) -> dict[str, Float32Array]:
        """The arrays of a trial's trajectory, one row a tick."""
        with np.load(self.trajectory_file(number)) as arrays:
            return {name: arrays[name] for name in arrays.files}

    def spend(self, wall_s: float) -> None:
        """Add to the wall time that the run has taken."""
        self.manifest = dataclasses.replace(self.manifest, wall_s=self.manifest.wall_s + wall_s)
        self._save_manifest()

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
    """A folder of this name and the next free number: ``parent/name-001``."""
    number = 1
    while (parent / f"{name}-{number:03d}").exists():
        number += 1
    return parent / f"{name}-{number:03d}"


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
    return TrialRecord(**{**row, "outcome": Outcome(row["outcome"]), "start": json.loads(row["start"])})
