"""Runs: made, gone on with, opened, and everything that is known of one."""

from __future__ import annotations

import shutil
import weakref
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cached_property, partial
from operator import index
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, TypeVar

from graspdsl.api.programs import load, warn, with_trials
from graspdsl.api.told import Place, Told
from graspdsl.api.trajectories import Trajectory
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError, on_one_line, reading
from graspdsl.report.claims import Claim, claims_of
from graspdsl.report.data_files import NPZ, format_of, write_columns
from graspdsl.report.evidence import Evidence, evidence_of
from graspdsl.report.exports import TRAJECTORY, TRIALS, columns_of_trajectory, tables_of
from graspdsl.report.figure_data import FigureData, figures_of
from graspdsl.report.outcomes import representatives
from graspdsl.report.summary import Summary, summarised
from graspdsl.report.wording import counted
from graspdsl.trials.columns import Column, columns_of
from graspdsl.trials.identity import check_origin
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute, new_run, program_of_run
from graspdsl.trials.store import POINTS, SPEC, RunFolder
from graspdsl.trials.trajectories import Layout
from graspdsl.trials.workers import WorkerEndedError, Workers, sharing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OnRecord = Callable[[TrialRecord], object]
STOPPED = (KeyboardInterrupt, WorkerEndedError)

MOST_WORKERS = 1024
SWEEPS = "graspdsl.sweep runs it; set=['sweep=null'] makes it a plain one"
R = TypeVar("R", bound=Told)


def run(
    program: Program | Place,
    *,
    trials: int | None = None,
    seed: int | None = None,
    workers: int | None = None,
    engine: str = "local",
    scheduler: str | None = None,
    out: Place | None = None,
    progress: bool | OnRecord = True,
    allow_code: bool = False,
) -> Run:
    """Run the trials of a program, or of a spec file, and give back what came of them.

    trials, seed: in place of those of the spec. workers: how many processes share the trials, by default as many as are
    worth it; the numbers do not depend on it, and a script needs no ``__main__`` guard. engine: ``local``, or ``dask``
    for the cluster of a Dask scheduler, named by its address or by its file (.json), or without one for a cluster of
    ``workers`` on this machine. out: the run's folder, which
    must not be there or be empty; by default one that goes when the Run goes, unless :meth:`Run.save` keeps it.
    progress: a bar on stderr, none, or what is called with the record of each trial as it ends. allow_code: of a spec
    file, as for :func:`load`.

    Raises DiagnosticError where the spec has faults, where the folder cannot be written to, or when none of the first
    trials could begin, or where Dask's scheduler cannot be reached, goes away, or has workers with other versions;
    WorkerEndedError where workers end one after the other. After these, as after KeyboardInterrupt, the trials that
    were finished are kept in ``out``, and :func:`resume` goes on. Raises ValueError for less than one worker, or where
    engine, scheduler and workers do not go together.
    """
    shared_by = checked(workers, engine, scheduler)
    if not isinstance(program, Program):
        program = load(program, allow_code=allow_code)
    program = with_trials(program, trials, seed)
    if program.points:
        raise DiagnosticError([is_a_sweep(f"this spec is a sweep of {len(program.points)} points", SWEEPS)])
    return performed(Run, program, shared_by, out, progress)


def performed(
    kind: Callable[[RunFolder, Program], R],
    program: Program,
    shared_by: Workers,
    out: Place | None,
    progress: bool | OnRecord,
) -> R:
    """A run, or a sweep, of a program: made, and all its trials run."""
    if out is not None:
        with told_how_to_go_on(Path(out)):
            return carried_on(_begun(kind, Path(out), program), shared_by, progress)
    passing = Path(mkdtemp(prefix="graspdsl-"))
    try:
        made = carried_on(_begun(kind, passing / program.spec.name, program), shared_by, progress)
    except BaseException as end:
        shutil.rmtree(passing, ignore_errors=True)
        if isinstance(end, STOPPED):
            end.add_note("nothing is kept: name a folder, out=…, to be able to go on")
        raise
    weakref.finalize(made, shutil.rmtree, passing, ignore_errors=True)
    return made


def _begun(kind: Callable[[RunFolder, Program], R], place: Path, program: Program) -> R:
    with reading(str(place)):
        return kind(new_run(place, program), program)


def is_a_sweep(message: str, hint: str) -> Diagnostic:
    """The complaint about a sweep where a single run is asked for."""
    return Diagnostic("is-a-sweep", message, hint=hint)


def resume(
    path: Place,
    *,
    workers: int | None = None,
    engine: str = "local",
    scheduler: str | None = None,
    progress: bool | OnRecord = True,
    allow_code: bool = False,
) -> Run:
    """Run what is not finished of the run in a folder, as :func:`run` would have."""
    shared_by = checked(workers, engine, scheduler)
    begun = open_run(path, allow_code=allow_code)
    with told_how_to_go_on(begun.path):
        return carried_on(begun, shared_by, progress)


def open_run(path: Place, *, allow_code: bool = False) -> Run:
    """The run in a folder, finished or not, as it is now; ``allow_code``: whether Python files in it may be run, which
    its spec names.

    Raises DiagnosticError where there is none, or where it or its spec cannot be read or do not go together.
    """
    found, warnings = opened(Path(path), allow_code=allow_code)
    warn(str(path), warnings)
    return found


def opened(path: Path, *, allow_code: bool = False) -> tuple[Run, list[Diagnostic]]:
    """The run in a folder, and the warnings about it. Raises DiagnosticError as :func:`open_run`."""
    folder, program, warnings = opened_folder(path, allow_code=allow_code)
    if program.points:
        message = f"this run is a sweep of {len(program.points)} points"
        raise DiagnosticError([is_a_sweep(message, f"name one of them: {path / POINTS}/000")], str(path))
    return Run(folder, program), warnings


def opened_folder(path: Path, *, allow_code: bool = False) -> tuple[RunFolder, Program, list[Diagnostic]]:
    """The folder of a run, its program, and the warnings about it. Raises DiagnosticError as :func:`open_run`."""
    with reading(str(path)):
        folder = RunFolder.open(path, allow_code=allow_code)
        text = folder.spec_text
    with reading(str(folder.whole / SPEC), text):
        program = program_of_run(folder)
    with reading(str(path)):
        return folder, program, check_origin(folder, program)


def carried_on(begun: R, workers: Workers, progress: bool | OnRecord) -> R:
    """Run what is not finished of a run."""
    folder = begun.folder
    with reading(str(folder.path)), folder.held():
        finished = folder.finished()
        if callable(progress):
            execute(folder, workers, progress, finished)
        elif progress:
            from graspdsl.api.progress import TrialProgress

            with TrialProgress(folder.manifest.asked, finished) as bar:
                execute(folder, workers, bar.advance, finished, bar.draw_again)
        else:
            execute(folder, workers, finished=finished)
    return begun


def checked(workers: int | None, engine: str, scheduler: str | None) -> Workers:
    """Who shares the trials. Raises ValueError where that cannot be."""
    if workers is not None and not 1 <= index(workers) <= MOST_WORKERS:
        raise ValueError(f"workers: expected from 1 to {MOST_WORKERS} processes, found {workers}")
    return sharing(workers, engine, scheduler)


@contextmanager
def told_how_to_go_on(place: Path) -> Iterator[None]:
    """What stops a run within says how to go on with it."""
    try:
        yield
    except STOPPED as end:
        end.add_note(on_one_line(f"finished trials are kept; to go on: graspdsl.resume({str(place)!r})"))
        raise


class Trials:
    """The records of a run's finished trials, by number: ``trials[3]``; a loop over them goes by number."""

    def __init__(self, records: Sequence[TrialRecord]) -> None:
        self._records = {record.number: record for record in records}

    def __getitem__(self, number: int) -> TrialRecord:
        try:
            return self._records[number]
        except KeyError:
            raise IndexError(f"trial {number} is not among the {len(self)} that are finished") from None

    def __contains__(self, number: object) -> bool:
        return number in self._records

    def __iter__(self) -> Iterator[TrialRecord]:
        return iter(self._records.values())

    def __len__(self) -> int:
        return len(self._records)

    def __repr__(self) -> str:
        return f"<Trials: {', '.join(f'{record.number} {record.outcome}' for record in self)}>"


def _figure_of(data: FigureData) -> Figure:
    from graspdsl.report.figures import drawing_of

    return drawing_of(data).figure


class Run(Told):
    """A run: its trials, their trajectories, and what a report says of them. Made by :func:`run` or :func:`open_run`.

    ``program``: what was run. What is asked for is worked out when it is first asked for.
    """

    @cached_property
    def trials(self) -> Trials:
        """The finished trials, by number."""
        with reading(str(self.path)):
            return Trials(self.folder.records())

    @cached_property
    def evidence(self) -> Evidence:
        """Its records with how their residuals went, which every report is made from."""
        with reading(str(self.path)):
            return evidence_of(self.folder, self.program, self.trials)

    @cached_property
    def summary(self) -> Summary:
        """Everything that a report says of it, as data: ``summary.outcomes``, ``summary.converged.share`` and so on."""
        return summarised(self.evidence)

    @cached_property
    def claims(self) -> list[Claim]:
        """What the chapter says of the experiment that was run, and what agrees; nothing of any other run."""
        return claims_of(self.evidence)

    def trajectory(self, number: int) -> Trajectory:
        """The trajectory of a finished trial. Raises IndexError for any other, DiagnosticError where it is lost."""
        number = self.trials[number].number
        with reading(str(self.path)):
            return Trajectory(self.folder.trajectory(number, Layout.of(self.program)))

    def export(self, path: Place, what: str = TRIALS, *, trial: int | None = None, form: str | None = None) -> Path:
        """Write one of its tables into a file, as :meth:`Told.export`, or a ``trajectory``, of a ``trial``.

        Raises ValueError for a trial of a table, DiagnosticError where it is not finished.
        """
        if trial is None:
            return super().export(path, what, form=form)
        place, columns = Path(path), self.columns_for(what, trial)
        form = format_of(place, form)
        if form == NPZ:  # which has room for axes
            arrays = self.trajectory(trial)
            columns = {name: Column(arrays[name], unit) for name, unit in arrays.units.items()}
        with reading(str(place)):
            return write_columns(place, columns, form)

    def columns_for(self, name: str, trial: int | None = None) -> Mapping[str, Column]:
        """What :meth:`export` writes under a name."""
        if (name == TRAJECTORY) != (trial is not None):
            raise ValueError(f"trial: a {TRAJECTORY} is of one, and nothing else")
        if trial is None:
            return super().columns_for(name)
        if trial not in self.trials:
            hint = f"{counted(len(self.trials), 'trial is', 'trials are')} finished"
            message = f"this run has no finished trial {trial}"
            raise DiagnosticError([Diagnostic("unknown-trial", message, hint=hint)], str(self.path))
        return columns_of_trajectory(self.program, self.trajectory(trial))

    def _of_trials(self) -> Mapping[str, Column]:
        return columns_of(self.program, list(self.trials))

    @cached_property
    def _shown(self) -> Mapping[str, Callable[[], Mapping[str, Column]]]:
        return tables_of(self.evidence, self.summary, self._figures.values(), self.claims)

    @cached_property
    def _figures(self) -> Mapping[str, FigureData]:
        return {figure.name: figure for figure in figures_of(self.evidence, self.summary)}

    @cached_property
    def _drawn(self) -> Mapping[str, Callable[[], Figure]]:
        return {name: partial(_figure_of, data) for name, data in self._figures.items()}

    def report(self) -> Path:
        """Write its page, ``report.html``, and its figures into its folder; gives back where the page is.

        Raises DiagnosticError where the folder cannot be written to.
        """
        from graspdsl.report.page import write_report

        with reading(str(self.path)):
            return write_report(self.evidence, self.summary, frames=self._frames(), claims=self.claims)

    def _frames(self) -> dict[str, bytes]:
        """A PNG picture of the end of one trial of each outcome, where one can be drawn."""
        from graspdsl.trials.replay import frame

        shown = {name: frame(self.folder, trial.number) for name, trial in representatives(self.trials).items()}
        return {name: picture for name, picture in shown.items() if picture is not None}

    def __repr__(self) -> str:
        asked, seed = self.folder.manifest.asked, self.folder.manifest.seed
        good = sum(record.outcome == "converged" for record in self.trials)
        done = f"{len(self.trials)} of {counted(asked, 'trial', 'trials')}"
        return on_one_line(f"<Run {self.name}, seed {seed}: {done} finished, {good} converged; {self.path}>")

    def __rich_console__(self, *_: object) -> Iterator[object]:
        from graspdsl.api.console import shown

        yield from shown(self.summary)

    def _repr_html_(self) -> str:
        """For notebooks: whether it worked, how trials ended, and where grasps started and ended."""
        from graspdsl.report.notebook import cell

        return cell(self.evidence, self.summary)
