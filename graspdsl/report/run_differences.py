"""What differs between two runs before any trial: their specs, key by key, versions, plug-ins and files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from graspdsl.compiler.program import Program
from graspdsl.reference.keys import parts
from graspdsl.report.tables import Column, Format, Table
from graspdsl.trials.store import RunFolder

SPEC, VERSION, PLUGIN, FILE = "spec", "version", "plug-in", "file"
DIGITS = 12  # of a hash


@dataclass(frozen=True, slots=True)
class Difference:
    """What is not the same: of which part, under which key, what each run has, None of nothing, and the unit of it.
    Keys of a spec are as ``--set`` takes them."""

    part: str
    key: str
    first: Any
    second: Any
    unit: str = ""


def differences(first: tuple[RunFolder, Program], second: tuple[RunFolder, Program]) -> list[Difference]:
    """What differs between two runs, each a folder and its program; of specs with overrides made and defaults filled
    in, the number of trials and the seed among the rest."""
    found, units = list[Difference](), _units()
    for part, *both in zip(_PARTS, _told(*first), _told(*second), strict=True):
        one, other = both
        for key in dict.fromkeys((*one, *other)):
            if one.get(key) != other.get(key):
                unit = units.get(_plain(key), "") if part == SPEC else ""
                found.append(Difference(part, key, one.get(key), other.get(key), unit))
    return found


_PARTS = (SPEC, VERSION, PLUGIN, FILE)


def _told(folder: RunFolder, program: Program) -> tuple[Mapping[str, Any], ...]:
    """What each of the parts of a run has under its keys."""
    spec = program.spec.model_dump(mode="json", by_alias=True, warnings=False)  # of keys that came since
    plugins = {f"{plugin.kind} {plugin.name}": f"{plugin.by}, {plugin.digest}" for plugin in folder.manifest.plugins}
    files = {str(file.kept_as): hashlib.sha256(file.content).hexdigest()[:DIGITS] for file in program.files}
    return dict(_leaves(spec)), folder.manifest.made_with, plugins, files


def _leaves(part: Any, within: str = "") -> Iterator[tuple[str, Any]]:
    """The values of a spec by their dotted keys; lists of numbers and names are values."""
    below: Iterator[tuple[Any, Any]] | None = None
    if isinstance(part, Mapping):
        below = iter(part.items())
    elif isinstance(part, list) and any(isinstance(one, Mapping | list) for one in part):
        below = iter(enumerate(part))
    if below is None:
        yield within, part
        return
    for key, value in below:
        yield from _leaves(value, f"{within}.{key}" if within else str(key))


def _units() -> dict[str, str]:
    return {
        f"{part.place}.{key.name}".lstrip("."): key.unit
        for part in parts()
        for key in part.keys
        if key.unit not in ("", "1")
    }


def _plain(key: str) -> str:
    """A key without places in lists, of bounds that of what they are the bounds of."""
    return ".".join(word for word in key.split(".") if not word.isdigit()).removesuffix(".uniform")


def differences_table(found: Sequence[Difference], runs: Sequence[str]) -> Table:
    """What differs, a row each."""
    rows = tuple((one.part, one.key, *(_said(value, one.unit) for value in (one.first, one.second))) for one in found)
    return Table("What differs", (Column("of the"), Column("key"), *(Column(run, _AS_SAID) for run in runs)), rows)


_AS_SAID = Format(str, words=True)


def _said(value: Any, unit: str) -> str | None:
    """A value as a spec has it, with its unit."""
    if value is None:
        return None
    text = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    return f"{text} {unit}" if unit and not isinstance(value, str | bool) else text
