"""Sweeps: made, gone on with, opened, and everything that is known of one."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

from graspdsl.api.programs import load, trial_settings, warn, with_settings
from graspdsl.api.runs import (
    OnRecord,
    Run,
    carried_on,
    checked,
    opened_folder,
    performed,
    told_how_to_go_on,
)
from graspdsl.api.told import Place, Told
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, on_one_line, reading
from graspdsl.places.wording import Data
from graspdsl.report.sweeps import SweepSummary, columns_over, figure_name, swept, tables_of_sweep, verdict
from graspdsl.spec.sweeping import Point, setting
from graspdsl.trials.columns import Column, columns_of
from graspdsl.trials.store import RunFolder

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def sweep(
    program: Program | Place,
    over: Mapping[str, Sequence[Data]] | None = None,
    *,
    trials: int | None = None,
    seed: int | None = None,
    workers: int | None = None,
    engine: str = "local",
    scheduler: str | None = None,
    out: Place | None = None,
    progress: bool | OnRecord = True,
    allow_code: bool = False,
) -> Sweep:
    """Run the trials of a program, or of a spec file, at every point of its sweep, and give back what came of them.

    over: the values of a grid by the dotted paths of fields, ``{"scene.friction": [0.3, 0.6]}``, in place of the sweep
    that the spec has. trials: at each point. All else is as for :func:`graspdsl.run`.

    Raises DiagnosticError where there is no sweep, or where a point has faults, too.
    """
    shared_by = checked(workers, engine, scheduler)
    if not isinstance(program, Program):
        program = load(program, allow_code=allow_code)
    grid = [setting("sweep", {"grid": {field: list(over[field]) for field in over}})] if over is not None else []
    if more := [*grid, *trial_settings(trials, seed)]:
        program = with_settings(program, *more)
    if not program.points:
        raise DiagnosticError([_no_sweep("this spec has no sweep")])
    return performed(Sweep, program, shared_by, out, progress)


def resume_sweep(
    path: Place,
    *,
    workers: int | None = None,
    engine: str = "local",
    scheduler: str | None = None,
    progress: bool | OnRecord = True,
    allow_code: bool = False,
) -> Sweep:
    """Run what is not finished of the sweep in a folder, as :func:`sweep` would have."""
    shared_by = checked(workers, engine, scheduler)
    begun = open_sweep(path, allow_code=allow_code)
    with told_how_to_go_on(begun.path):
        return carried_on(begun, shared_by, progress)


def open_sweep(path: Place, *, allow_code: bool = False) -> Sweep:
    """The sweep in a folder, finished or not, as it is now. Raises DiagnosticError as :func:`graspdsl.open_run`."""
    found, warnings = opened_either(Path(path), allow_code=allow_code)
    warn(str(path), warnings)
    if isinstance(found, Run):
        raise DiagnosticError([_no_sweep("this run is no sweep")], str(path))
    return found


def opened_either(path: Path, *, allow_code: bool = False) -> tuple[Run | Sweep, list[Diagnostic]]:
    """The run, or the sweep, in a folder, and the warnings about it. Raises DiagnosticError as
    :func:`graspdsl.open_run`."""
    folder, program, warnings = opened_folder(path, allow_code=allow_code)
    return of_either_kind(folder, program), warnings


def of_either_kind(folder: RunFolder, program: Program) -> Run | Sweep:
    """The run, or the sweep, of a program in a folder."""
    return Sweep(folder, program) if program.points else Run(folder, program)


def _no_sweep(message: str) -> Diagnostic:
    return Diagnostic("no-sweep", message, hint="a sweep: sweep: {grid: {scene.friction: [0.3, 0.6]}}")


class Sweep(Told):
    """A sweep: its points, each a :class:`Run` of its own, and what a report says of all. Made by :func:`sweep` or
    :func:`open_sweep`.

    ``sweep[3]`` is point 3; a loop over it goes from point to point. ``program``: what was run, as it is without the
    values of a point. What is asked for is worked out when it is first asked for.
    """

    def __init__(self, folder: RunFolder, program: Program) -> None:
        super().__init__(folder, program)
        self._runs = dict[int, Run]()

    @cached_property
    def points(self) -> Sequence[Point]:
        """The values of each point, by the dotted paths of fields."""
        return self.program.spec.sweep.points() if self.program.spec.sweep else []

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, point: int) -> Run:
        if not 0 <= point < len(self):
            raise IndexError(f"there are {len(self)} points, from 0 on; there is no {point}")
        if point not in self._runs:
            self._runs[point] = Run(self.folder.at_point(point), self.program.at(point))
        return self._runs[point]

    def __iter__(self) -> Iterator[Run]:
        return map(self.__getitem__, range(len(self)))

    @cached_property
    def summary(self) -> SweepSummary:
        """Everything that a report says of it, as data: ``summary.points[3].share`` and so on."""
        with reading(str(self.path)):
            return swept(self.folder, self.program)

    @cached_property
    def _shown(self) -> Mapping[str, Callable[[], Mapping[str, Column]]]:
        return tables_of_sweep(self.summary)

    def _of_trials(self) -> Mapping[str, Column]:
        return columns_over(self.points, [columns_of(run.program, list(run.trials)) for run in self])

    @cached_property
    def _drawn(self) -> Mapping[str, Callable[[], Figure]]:
        return {figure_name(field): partial(self._figure, field) for field in self.summary.fields}

    def _figure(self, field: str) -> Figure:
        from graspdsl.report.sweep_page import field_figure

        return field_figure(self.summary, field)

    def report(self) -> Path:
        """Write its page, ``report.html``, and its figures into its folder; gives back where the page is.

        Raises DiagnosticError where the folder cannot be written to.
        """
        from graspdsl.report.sweep_page import write_sweep

        with reading(str(self.path)):
            return write_sweep(self.folder, self.summary)

    def __repr__(self) -> str:
        return on_one_line(f"<Sweep {self.name}: {verdict(self.summary)} {self.path}>")
