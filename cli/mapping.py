"""Maps of the domain of attraction on the command line: what was asked, the trials, the files."""

from __future__ import annotations

import math
import re
from pathlib import Path

import typer
from rich.console import RenderableType
from rich.text import Text

from graspdsl.api.programs import program_in
from graspdsl.api.runs import Run
from graspdsl.cli.inputs import sound
from graspdsl.cli.messages import complain, if_interrupted, result, result_json, say
from graspdsl.cli.running import RUNS, begin, carried_on, keeping, kept, opened, resuming
from graspdsl.cli.tables import laid_out, text_of
from graspdsl.compiler.program import Program, examine
from graspdsl.diagnostics import on_one_line, reading
from graspdsl.places.files import COPIES
from graspdsl.report.attraction import (
    FILES,
    AttractionMap,
    as_data,
    attraction_map,
    map_of_run,
    repeating,
)
from graspdsl.report.run_tables import SHARES, reasons_table
from graspdsl.report.statistics import wilson
from graspdsl.report.tables import COUNT, Column, Table
from graspdsl.report.wording import percent, percents
from graspdsl.report.writing import prepare, replace
from graspdsl.trials.folders import fresh_folder
from graspdsl.trials.interruption import interruption
from graspdsl.trials.maps import Cells, WantedAxis, axes_of, floating_cells, grid_settings, refused
from graspdsl.trials.store import SPEC
from graspdsl.trials.workers import Dask, Workers

MOST_CELLS, MOST_ALONG = 100_000, 1000
_AXIS = re.compile(r"(?P<name>[^=,:]+)(?:=(?P<low>[^:]+):(?P<high>[^:]+))?")
_GRID = re.compile(r"([0-9]{1,9})[x×]([0-9]{1,9})")
_DECIMAL = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?")
USUAL_GRID = "40x40"


def wanted_axes(over: str, grid: str) -> list[WantedAxis]:
    """The two axes that ``--over`` and ``--grid`` ask for. Raises typer.BadParameter."""
    sizes = _GRID.fullmatch(grid.strip().lower())
    if sizes is None:
        raise typer.BadParameter(f"expected COLUMNSxROWS, found {grid!r}; for example 40x40", param_hint="--grid")
    columns, rows = int(sizes[1]), int(sizes[2])
    if not (1 <= columns <= MOST_ALONG and 1 <= rows <= MOST_ALONG and columns * rows <= MOST_CELLS):
        message = f"expected 1 to {MOST_ALONG} cells a side and at most {MOST_CELLS} in all, found {columns}x{rows}"
        raise typer.BadParameter(message, param_hint="--grid")
    parts = over.split(",")
    if len(parts) != 2:
        message = f"expected two parameters, found {len(parts)}; for example roll,height or roll=-1.5:1.5,height"
        raise typer.BadParameter(message, param_hint="--over")
    axes = [_wanted(part.strip(), cells) for part, cells in zip(parts, (columns, rows), strict=True)]
    if axes[0].parameter == axes[1].parameter:
        raise typer.BadParameter(f"{axes[0].parameter} is named twice; name two", param_hint="--over")
    return axes


def _wanted(part: str, cells: int) -> WantedAxis:
    found = _AXIS.fullmatch(part)
    if found is None:
        raise typer.BadParameter(f"expected NAME or NAME=LOW:HIGH, found {part!r}", param_hint="--over")
    name = found["name"].strip()
    if found["low"] is None:
        return WantedAxis(name, None, cells)
    low, high = (_number(found[end]) for end in ("low", "high"))
    if not (math.isfinite(low) and math.isfinite(high)):
        message = f"expected two numbers, found {found['low']}:{found['high']}"
        raise typer.BadParameter(message, param_hint="--over")
    if low >= high:
        message = f"the low end {low:g} of {name} is not below the high end {high:g}"
        raise typer.BadParameter(message, param_hint="--over")
    return WantedAxis(name, (low, high), cells)


def _number(text: str) -> float:
    """A decimal number in ASCII; NaN for anything else."""
    return float(text) if _DECIMAL.fullmatch(text.strip()) else math.nan


def make_map(
    spec: Path,
    axes: list[WantedAxis],
    settings: tuple[str, ...],
    *,
    contact: str | None,
    workers: Workers,
    out: Path | None,
    as_json: bool,
    allow_code: bool = False,
) -> int:
    """Map a spec over two axes, write the map's files and show it. Returns the exit code."""
    program = sound(spec, settings, allow_code=allow_code)
    source = program.source.text
    if not program.world.has("hand"):
        if isinstance(workers, Dask):
            message = "a map of floating contacts is made in one go, by this process: Dask has no part in it"
            raise typer.BadParameter(message, param_hint="--engine")
        if_interrupted("nothing is kept of a map of floating contacts, which is made in one go: begin it again")
        with reading(str(spec), source):
            cells = _floating(program, axes, contact)
        copies = {f"{COPIES}/{file.kept_as.as_posix()}": file.content for file in program.files}
        seed = program.spec.trials.seed
        with reading(str(out or RUNS)), interruption.whole():
            folder = out or fresh_folder(RUNS, f"{program.spec.name}-map")
            made = attraction_map(
                program, cells, seed, repeating(folder / SPEC, cells, seed, settings, allow_code=allow_code)
            )
            prepare(folder, {SPEC: source, **copies, **_files(made)})
        show_map(made, folder, as_json)
        return 0
    with reading(str(spec), source):
        if contact is not None:
            raise refused("not-mapped", "the hand starts as a whole here: no contact by itself", "leave out --contact")
        whole = (*settings, *grid_settings(program, axes))
        known = examine(*program.source).diagnostics
        gridded = examine(*program.source._replace(overrides=whole))
    mapped = program_in(gridded, str(spec), source)
    complain(str(spec), source, [diagnostic for diagnostic in gridded.diagnostics if diagnostic not in known])
    return finish_map(Run(begin("map", mapped, out), mapped), workers, as_json)


def resume_map(path: Path, workers: Workers, as_json: bool, *, allow_code: bool = False) -> int:
    """Finish the map in a folder and show it. Returns the exit code."""
    if_interrupted(kept("map", "--resume", str(path)))
    run = opened(path, allow_code=allow_code)
    with reading(str(path)):
        axes_of(run.program.spec)
    return finish_map(run, workers, as_json)


def finish_map(run: Run, workers: Workers, as_json: bool) -> int:
    """Run the trials of a map that are not finished, write its files and show it. Returns the exit code."""
    words = resuming("map", run.folder)
    with keeping(run.path, *words):
        code = carried_on(run, workers, *words)
        if code == 0:
            made = map_of_run(run.folder, run.program, run.folder.records())
            replace(run.path, _files(made))
            show_map(made, run.path, as_json)
    return code


def _floating(program: Program, axes: list[WantedAxis], contact: str | None) -> Cells:
    total = axes[0].cells * axes[1].cells
    say(f"{program.spec.name}: {total} cells, seed {program.spec.trials.seed}")
    return floating_cells(
        program, axes, contact, program.spec.trials.seed, lambda done: say(f"{done} of {total} cells")
    )


def show_map(made: AttractionMap, folder: Path, as_json: bool) -> None:
    """What the map in a folder says, on stdout."""
    if as_json:
        result_json({**as_data(made), "run": str(folder)})
    else:
        result(_text(made, folder))


def _text(made: AttractionMap, folder: Path) -> str:
    head: list[RenderableType] = [Text(f"{made.name}, seed {made.seed}", style="bold")]
    for name, axis in zip(("across", "up"), (made.cells.x, made.cells.y), strict=True):
        head.append(f"{name}: {axis.parameter}, {axis.low:g} to {axis.high:g} {axis.unit}, {axis.cells} cells")
    head.append(f"fixed: {'; '.join(f'{name} {value}' for name, value in made.cells.fixed.items())}")
    rows = tuple((found.label, len(found.cells), found.share, found.interval) for found in made.classes)
    tables = [Table("Where starts end", (Column("class"), Column("cells", COUNT), *SHARES[1:]), rows)]
    reasons = [
        (found.label, found.mostly.detail, len(found.mostly.trials), len(found.cells))
        for found in made.classes
        if found.mostly is not None
    ]
    tables += [reasons_table("Why starts did not converge, mostly", reasons)] if reasons else []
    whole = "no start was feasible"
    if made.feasible:
        good, of = made.converged, made.feasible
        share = f"{percent(good / of)} (95 % interval {percents(wilson(good, of))})"
        whole = f"{good} of {of} feasible starts converged: {share}"
    files = f"The map is in {on_one_line(str(folder))} as {', '.join(FILES)}; to make it again:"
    parts = [part for table in tables for part in ("", laid_out(table))]
    return text_of([*head, *parts, "", whole, Text(files, overflow="fold")], f"  {made.command}")


def _files(made: AttractionMap) -> dict[str, str | bytes]:
    from graspdsl.report.map_figure import map_files  # which takes its time to import

    return map_files(made)
