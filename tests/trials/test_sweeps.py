"""The trials of a sweep: those of a run at each of its points, whoever runs them and however often that is stopped."""

from __future__ import annotations

import dataclasses
import random
from pathlib import Path

import numpy as np
import pytest
from compiler.specs import floating

from graspdsl.compiler.program import Program, examine, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.health import examined
from graspdsl.trials.identity import check_origin
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import execute, new_run, program_of_run
from graspdsl.trials.store import RunFolder
from graspdsl.trials.sweeps import SweepLoop
from graspdsl.trials.trajectories import Layout
from graspdsl.trials.workers import Dask

pytestmark = pytest.mark.slow

COUNT = 3
GRID = "{grid: {control.step: [0.001, 0.004], scene.object: [{sphere: {diameter: 0.1}}, {sphere: {diameter: 0.06}}]}}"


def swept(count: int = COUNT, sweep: str = GRID) -> Program:
    """A program of four points whose trials take a moment."""
    return program_of(f"{floating()}trials: {{count: {count}}}\nsweep: {sweep}\n", "spec.yaml")


def kept(folder: RunFolder) -> dict[int, tuple[str, bytes]]:
    """All that is kept of each trial but for the time that it took."""
    content = {piece.number: folder.packs.content(piece) for piece in folder.pieces()}
    records = {record.number: repr(dataclasses.replace(record, wall_s=0.0)) for record in folder.records()}
    return {number: (record, content[number]) for number, record in records.items()}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> RunFolder:
    """The sweep by one process, not to be written to."""
    folder = new_run(tmp_path_factory.mktemp("sweep") / "run", swept())
    execute(folder, 1)
    return folder


def test_the_trials_of_a_point_are_those_of_a_run_of_its_values(whole: RunFolder, tmp_path: Path) -> None:
    program = swept()
    assert len(program.points) == 4
    for point, values in enumerate(program.spec.sweep.points() if program.spec.sweep else ()):
        settings = (f"control.step={values['control.step']}", f"scene.object={values['scene.object']}")
        alone = new_run(tmp_path / str(point), program_of(program.source.text, "spec.yaml", ("sweep=null", *settings)))
        execute(alone, 1)
        assert kept(RunFolder.at(whole.path / "points" / f"{point:03d}")) == kept(alone)
    assert len({record.identity for record in whole.records()}) == 4 * COUNT
    assert [record.number for record in whole.records()] == list(range(4 * COUNT))


def test_a_point_is_read_as_a_run(whole: RunFolder) -> None:
    third = RunFolder.at(whole.path / "points" / "002")
    program = program_of_run(third)
    assert (program.spec.control.step, program.points, third.manifest.asked) == (0.004, (), COUNT)
    assert check_origin(third, program) == []
    assert third.outcomes() == {Outcome.CONVERGED.value: COUNT}
    of_all = whole.identities()
    assert third.identities() == {number: of_all[2 * COUNT + number] for number in range(COUNT)}
    rows, of_whole = third.trajectory(1, Layout.of(program)), whole.trajectory(2 * COUNT + 1)
    assert all(np.array_equal(values, of_whole[name], equal_nan=True) for name, values in rows.items())
    assert len(rows["time"]) > third.records()[1].ticks > 0
    with pytest.raises(DiagnosticError, match="one point of a sweep"), third.held():
        pass
    for name in ("004", "4", "x"):
        with pytest.raises(DiagnosticError):
            RunFolder.at(whole.path / "points" / name)


def test_two_processes_and_one_that_is_stopped_make_the_same_sweep(whole: RunFolder, tmp_path: Path) -> None:
    folder, told = new_run(tmp_path / "run", swept()), list[int]()

    def stop(record: TrialRecord) -> None:
        told.append(record.number)
        if len(told) == 5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        execute(folder, 2, stop)
    assert len(folder.records()) == 5
    execute(folder, 2)
    assert kept(folder) == kept(whole)
    assert examined(folder).sound


def test_a_cluster_makes_the_same_sweep(whole: RunFolder, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    folder = new_run(tmp_path / "run", swept())
    execute(folder, Dask(workers=1))
    assert kept(folder) == kept(whole)


def test_numbers_may_come_in_any_order(whole: RunFolder) -> None:
    numbers = [*range(4 * COUNT)]
    random.Random(5).shuffle(numbers)
    loop = SweepLoop(swept())
    records = {trial.record.number: trial.record for trial in loop.run_all(numbers, 0)}
    assert loop.running == 0
    found = [repr(dataclasses.replace(records[number], wall_s=0.0)) for number in range(4 * COUNT)]
    assert found == [record for record, _ in kept(whole).values()]


def test_a_sweep_of_another_spec_does_not_go_on(whole: RunFolder, tmp_path: Path) -> None:
    text = whole.spec_text
    for changed in (text.replace("0.004", "0.005"), text.replace("π_gx|Γ Γ", "π_fr|Γ Γ")):
        assert changed != text
        folder = new_run(tmp_path / str(len(list(tmp_path.iterdir()))), swept())
        execute(folder, 1)
        (folder.path / "spec.yaml").write_text(changed, "utf-8")
        with pytest.raises(DiagnosticError, match="another spec"):
            check_origin(folder, program_of_run(folder))


@pytest.mark.parametrize(
    ("values", "code", "message"),
    [
        ("[0.001, -1]", "out-of-range", "at control.step=-1: expected a number above 0 (m), found -1"),
        ("[0.001, fast]", "wrong-type", 'at control.step="fast": expected a number (m)'),
    ],
)
def test_a_fault_of_a_point_is_told_at_its_value(values: str, code: str, message: str) -> None:
    text = f"{floating()}sweep: {{grid: {{control.step: {values}, scene.friction: [0.3, 0.6]}}}}\n"
    [fault] = [fault for fault in examine(text, "spec.yaml").diagnostics if fault.severity == "error"]
    assert (fault.code, fault.message[: len(message)]) == (code, message)
    assert fault.span
    line = text.splitlines()[fault.span.line - 1]
    assert line[fault.span.column - 1 : fault.span.end_column - 1] == values.split(", ")[1].rstrip("]")


def test_a_law_that_is_wrong_everywhere_is_told_once() -> None:
    text = f"{floating()}sweep: {{random: {{points: 5, over: {{control.step: {{uniform: [1, 2]}}}}}}}}\n"
    [fault] = [fault for fault in examine(text, "spec.yaml").diagnostics if fault.severity == "error"]
    assert (fault.code, fault.span and fault.span.column) == (
        "out-of-range",
        text.splitlines()[-1].index("{uniform") + 1,
    )


def test_a_fault_that_a_point_alone_has_names_the_point() -> None:
    text = f"{floating()}sweep: {{list: [{{scene.hand: points}}, {{scene.hand: barrett}}]}}\n"
    faults = [fault for fault in examine(text, "spec.yaml").diagnostics if fault.severity == "error"]
    assert faults
    assert all(fault.message.startswith('at point 1 of the sweep, scene.hand="barrett": ') for fault in faults)


def test_a_sweep_has_no_more_trials_than_a_run_may_have() -> None:
    with pytest.raises(DiagnosticError, match="4 points of 30000 trials are more than the 100000"):
        swept(30_000)
    assert swept(25_000).trials == 100_000
