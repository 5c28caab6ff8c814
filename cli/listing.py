"""What there is to write with, of graspdsl and of other packages: the kinds of things, and the things of a kind."""

from __future__ import annotations

from pathlib import Path

import typer

from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import complain, result, result_json
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.diagnostics import listed
from graspdsl.places.folders import HAND_FILE, MOUNT_FILE, begins_as
from graspdsl.plugins.adoption import adopted_all
from graspdsl.plugins.kinds import KINDS as OFFERED
from graspdsl.reference.kinds import KINDS, OTHER_NAMES, Rows, controllers
from graspdsl.report.tables import Column, Table

TABLES = {"sensing": "touch"}  # where the table of a kind has another name


def show_kinds(as_json: bool) -> None:
    """Print the kinds of things that can be listed: how many there are of each, and a line on it."""
    complain("graspdsl", "", adopted_all(OFFERED))
    rows = [{"kind": kind, "count": str(len(_rows(kind))), "about": of.about} for kind, of in KINDS.items()]
    _show("kinds", rows, as_json)
    if not as_json:
        result("List one of them: graspdsl list KIND")


def show_list(kind: str, as_json: bool, spec: Path | None = None, *, allow_code: bool = False) -> None:
    """Print the entries of one kind; of controllers also those that a spec has of its own.

    What other packages offer and cannot be used is told on stderr. What is too wide for a terminal is in the document.
    """
    if kind not in {*KINDS, *OTHER_NAMES}:
        raise typer.BadParameter(f"there is no kind {kind!r}, but {listed(KINDS)}", param_hint="KIND")
    name = OTHER_NAMES.get(kind, kind)
    if spec is not None and name != "controllers":
        raise typer.BadParameter("only controllers are a spec's own", param_hint="SPEC")
    complain("graspdsl", "", adopted_all([each for each in [TABLES.get(name, name)] if each in OFFERED]))
    if spec is None:
        rows = _rows(name)
    else:
        program = sound(spec, allow_code=allow_code)
        rows = controllers(program.definitions, program.source.name)
    wide = () if as_json else KINDS[name].wide
    _show(kind, [{column: text for column, text in row.items() if column not in wide} for row in rows], as_json)


def _rows(kind: str) -> Rows:
    return [*KINDS[kind].rows(), *_files_here(kind)]


def _show(name: str, rows: Rows, as_json: bool) -> None:
    if as_json:
        result_json({name: rows})
        return
    result(text_of([laid_out(Table(name, tuple(map(Column, rows[0])), tuple(tuple(row.values()) for row in rows)))]))


def _files_here(kind: str) -> Rows:
    """Hand or mount files in this folder and in the folder hands or mounts below it."""
    begins = {"hands": HAND_FILE, "mounts": MOUNT_FILE}.get(kind)
    found: Rows = []
    if begins is None:
        return found
    columns = dict.fromkeys(KINDS[kind].rows()[0], "")
    for path in sorted([*Path().glob("*"), *Path(kind).glob("*")]):
        if begins_as(begins, path):
            about = f"a {kind.removesuffix('s')} file found here"
            found.append({**columns, "name": str(path), "from": "this folder", "about": about})
    return found
