"""Columns as files that other programs read: csv, jsonl, parquet and numpy's npz."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, listed
from graspdsl.report.writing import prepare, replace
from graspdsl.trials.columns import Column

Columns = Mapping[str, Column]
CSV, JSONL, PARQUET, NPZ = "csv", "jsonl", "parquet", "npz"
TEXTS = (CSV, JSONL)  # which can go to stdout


def format_of(path: Path, said: str | None = None) -> str:
    """The format that is said, else that of a file's suffix. Raises DiagnosticError where that is none."""
    form = path.suffix.removeprefix(".").lower() if said is None else said
    if form in FORMATS:
        return form
    message = f"a file of the kind {form!r} cannot be written" if form else "its name does not say what to write"
    hint = (
        known_names_hint(form, FORMATS, "formats")
        if form
        else f"end it with {listed(map('.{}'.format, FORMATS), 'or')}"
    )
    raise DiagnosticError([Diagnostic("unknown-format", message, hint=hint)], str(path))


def write_columns(path: Path, columns: Columns, form: str) -> Path:
    """Write columns into a file in the place of an earlier one, with their units: see :func:`files_of`.

    Raises DiagnosticError where it cannot be written, ImportError where the format needs what is not installed.
    """
    replace(path.parent, files_of(path.name, columns, form))
    return path


def write_tables(folder: Path, tables: Mapping[str, Columns], form: str) -> Path:
    """Write tables into a new or empty folder, a file each. Raises as :func:`write_columns`."""
    files: dict[str, str | bytes] = {}
    for name, columns in tables.items():
        files |= files_of(f"{name}.{form}", columns, form)
    prepare(folder, files)
    return folder


def files_of(name: str, columns: Columns, form: str) -> dict[str, str | bytes]:
    """Columns as a file of this name. The units are in parquet's own metadata; of the other formats, which have none
    that readers know, in a JSON file beside it: ``trials.units.json`` of ``trials.csv``.

    Raises ImportError where the format needs what is not installed.
    """
    files: dict[str, str | bytes] = {name: FORMATS[form](columns)}
    if form != PARQUET:
        units = json.dumps(units_of(columns), ensure_ascii=False, indent=2)
        files[Path(name).with_suffix(".units.json").name] = f"{units}\n"
    return files


def units_of(columns: Columns) -> dict[str, str]:
    """The units of columns, empty for words."""
    return {name: column.unit for name, column in columns.items()}


def as_csv(columns: Columns) -> str:
    """A line of names, then a line a row; nothing for what is missing; numbers with all their digits."""
    text = io.StringIO()
    lines = csv.writer(text, lineterminator="\n")
    lines.writerow(columns)
    lines.writerows(zip(*map(_values, columns.values()), strict=True))  # which writes nothing of None
    return text.getvalue()


def as_jsonl(columns: Columns) -> str:
    """A JSON object a row, a line each; null for what is missing or is no finite number."""
    rows = (map(_finite, row) for row in zip(*map(_values, columns.values()), strict=True))
    records = (dict(zip(columns, row, strict=True)) for row in rows)
    return "".join(f"{json.dumps(record, ensure_ascii=False)}\n" for record in records)


def as_parquet(columns: Columns) -> bytes:
    """A Parquet file; null for what is missing. The unit of a column is the ``unit`` of its field's metadata, and those
    of all are what pandas reads as ``attrs["units"]``. Raises ImportError where pyarrow is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise ImportError('parquet needs pyarrow: pip install "graspdsl[parquet]"') from error
    arrays = [pyarrow.array(_values(column), _kind(column.values)) for column in columns.values()]
    fields = [
        pyarrow.field(name, array.type, metadata={"unit": columns[name].unit} if columns[name].unit else None)
        for name, array in zip(columns, arrays, strict=True)
    ]
    attributes = json.dumps({"units": units_of(columns)}, ensure_ascii=False)
    table = pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields, metadata={"PANDAS_ATTRS": attributes}))
    stream = io.BytesIO()
    pyarrow.parquet.write_table(table, stream)
    return stream.getvalue()


def as_npz(columns: Columns) -> bytes:
    """Numpy's file of arrays by name."""
    stream = io.BytesIO()
    arrays: dict[str, Any] = {name: column.values for name, column in columns.items()}
    np.savez_compressed(stream, **arrays)
    return stream.getvalue()


FORMATS: Mapping[str, Callable[[Columns], str | bytes]] = {
    CSV: as_csv,
    JSONL: as_jsonl,
    PARQUET: as_parquet,
    NPZ: as_npz,
}


def _kind(values: Any) -> str:
    """The type of a column in Parquet."""
    return {"i": "int64", "f": f"float{8 * values.dtype.itemsize}"}.get(values.dtype.kind, "string")


def _values(column: Column) -> list[Any]:
    """The values as Python's own, None for NaN; those of 32 bits with the digits that they have, and no more."""
    short = column.values.dtype == np.float32
    values = map(float, column.values.astype(np.str_)) if short else column.values.tolist()
    return [None if isinstance(value, float) and math.isnan(value) else value for value in values]


def _finite(value: Any) -> Any:
    return None if isinstance(value, float) and math.isinf(value) else value
