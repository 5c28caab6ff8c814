"""What is told of the trials in a folder, whether of one run or of a sweep: tables, and the files that they become."""

from __future__ import annotations

import shutil
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy.typing as npt

from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, reading
from graspdsl.report.data_files import CSV, format_of, units_of, write_columns, write_tables
from graspdsl.report.exports import ALL, TRIALS
from graspdsl.report.wording import counted
from graspdsl.trials.columns import Column
from graspdsl.trials.folders import LOCK, unwritable
from graspdsl.trials.store import RunFolder

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

Place = str | PathLike[str]


class Columns(dict[str, npt.NDArray[Any]]):
    """Arrays (n,) by name, a value for each of n trials; ``units``: the SI unit of each, empty for words."""

    def __init__(self, arrays: Mapping[str, npt.NDArray[Any]], units: Mapping[str, str]) -> None:
        super().__init__(arrays)
        self.units = dict(units)

    def __missing__(self, name: str) -> npt.NDArray[Any]:
        raise KeyError(f"there is no {name!r}; {known_names_hint(name, self, 'columns')}")

    def __repr__(self) -> str:
        count = len(next(iter(self.values()), ()))
        told = (f"{name} [{unit}]" if unit else name for name, unit in self.units.items())
        rows = counted(count, "trial", "trials") if "identity" in self else counted(count, "row", "rows")
        return f"<Columns of {rows}: {', '.join(told)}>"


class Told(ABC):
    """What is told of the trials of a program in a folder. What is asked for is worked out when it is first asked
    for."""

    def __init__(self, folder: RunFolder, program: Program) -> None:
        self.folder, self.program = folder, program

    @property
    def path(self) -> Path:
        """Its folder."""
        return self.folder.path

    @property
    def name(self) -> str:
        """The name of its spec."""
        return self.folder.manifest.name

    @abstractmethod
    def _of_trials(self) -> Mapping[str, Column]: ...

    @cached_property
    @abstractmethod
    def _shown(self) -> Mapping[str, Callable[[], Mapping[str, Column]]]: ...

    @cached_property
    @abstractmethod
    def _drawn(self) -> Mapping[str, Callable[[], Figure]]: ...

    def columns(self) -> Columns:
        """The records as arrays, a value a trial, with their ``units``; see :func:`graspdsl.trials.columns.columns_of`.

        ``columns()["outcome"]``, ``["force_residual_end"]``, ``["start.roll"]``; NaN where there was no number.
        """
        return self.table()

    def to_dataframe(self) -> DataFrame:
        """The columns as a pandas DataFrame, with their units in ``attrs["units"]``.

        Raises ImportError where pandas is not installed.
        """
        try:
            from pandas import DataFrame
        except ImportError as error:
            raise ImportError('to_dataframe needs pandas: pip install "graspdsl[pandas]"') from error
        columns = self.columns()
        frame = DataFrame(dict(columns))
        frame.attrs["units"] = columns.units
        return frame

    @property
    def tables(self) -> list[str]:
        """The names of its tables: ``trials``, and all that its report shows."""
        return [TRIALS, *self._shown]

    def table(self, name: str = TRIALS) -> Columns:
        """A table of its report as arrays, a value a row, with their ``units``, which are those of the page;
        ``trials`` are its :meth:`columns`. Raises DiagnosticError for a name that is not among ``tables``."""
        found = self.columns_for(name)
        return Columns({name: column.values for name, column in found.items()}, units_of(found))

    def export(self, path: Place, what: str = TRIALS, *, form: str | None = None) -> Path:
        """Write one of its tables into a file, in the place of an earlier one; gives back where it is.

        what: one of ``tables``, or ``all``, every table as a file of its own in the folder ``path``, which is new or
        empty. form: csv, jsonl, parquet or npz, by default what the name ends with, of ``all`` csv. Units are in the
        metadata of parquet's columns, where ``pandas.read_parquet`` finds them as those of :meth:`to_dataframe`; beside
        other files as JSON, ``trials.units.json``.

        Raises DiagnosticError where there is no such table or format, or the file cannot be written; ImportError where
        parquet is asked for and pyarrow is not installed.
        """
        place = Path(path)
        form = format_of(place, (form or CSV) if what == ALL else form)
        with reading(str(place)):
            if what == ALL:
                return write_tables(place, {name: self.columns_for(name) for name in self.tables}, form)
            return write_columns(place, self.columns_for(what), form)

    @property
    def figures(self) -> list[str]:
        """The names of its figures."""
        return [*self._drawn]

    def figure(self, name: str) -> Figure:
        """A figure of its report, drawn anew. Raises DiagnosticError for a name that is not among ``figures``."""
        if name not in self._drawn:
            message, hint = f"this run has no figure {name!r}", known_names_hint(name, self._drawn, "figures")
            raise DiagnosticError([Diagnostic("unknown-figure", message, hint=hint)], str(self.path))
        return self._drawn[name]()

    def columns_for(self, name: str) -> Mapping[str, Column]:
        """What :meth:`export` writes under a name."""
        if name == TRIALS:
            return self._of_trials()
        if name not in self._shown:
            message, hint = f"this run has no table {name!r}", known_names_hint(name, self.tables, "tables")
            raise DiagnosticError([Diagnostic("unknown-table", message, hint=hint)], str(self.path))
        return self._shown[name]()

    def save(self, path: Place) -> Self:
        """Copy it into a folder that is not there or is empty, where it stays; gives back what is there.

        Raises DiagnosticError where that cannot be.
        """
        place = Path(path)
        with reading(str(place)):
            self.folder.check_whole()
            try:
                if place.exists() and any(place.iterdir()):
                    hint = "name another"
                    raise DiagnosticError([Diagnostic("folder-not-empty", "this folder is not empty", hint=hint)])
                shutil.copytree(self.path, place, ignore=shutil.ignore_patterns(LOCK), dirs_exist_ok=True)
            except OSError as error:
                raise unwritable(error) from error
            return type(self)(RunFolder.open(place, allow_code=self.folder.allow_code), self.program)
