"""A run keeps the files of its object: it is repeated from them, wherever it is moved to."""

from __future__ import annotations

from pathlib import Path

import pytest
import trimesh

from graspdsl.compiler.program import Program, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.trials.identity import identities, versions
from graspdsl.trials.runner import execute, new_run, program_of_run
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

SPEC = Path(__file__).parents[2] / "specs" / "towel_roll_two_contacts.yaml"
OVERRIDES = ("trials.count=2", "program.1.limit=1.0", "scene.world=mujoco")


def _program(file: Path | str, folder: Path) -> Program:
    text = SPEC.read_text("utf-8").replace("object: towel-roll", f"object: {{mesh: {{file: {file}}}}}")
    return program_of(text, "spec.yaml", OVERRIDES, folder)


def _part(folder: Path, height: float = 0.18) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "part.stl"
    trimesh.creation.cylinder(radius=0.045, height=height).export(path)
    return path


@pytest.mark.parametrize("absolute", [False, True])
def test_a_run_is_finished_from_its_own_copies(absolute: bool, tmp_path: Path) -> None:
    part = _part(tmp_path / "spec")
    program = _program(part if absolute else part.name, part.parent)
    folder = new_run(tmp_path / "run", program)
    part.unlink()
    folder.path.rename(tmp_path / "moved")
    moved = RunFolder.open(tmp_path / "moved")
    assert identities(program_of_run(moved), 1)(0) == identities(program, 1)(0)
    execute(moved, workers=2)
    assert [record.identity for record in moved.records()] == [
        identities(program, moved.manifest.seed)(n) for n in (0, 1)
    ]


def test_another_file_of_the_same_name_is_another_trial(tmp_path: Path) -> None:
    first = _program(_part(tmp_path / "spec").name, tmp_path / "spec")
    second = _program(_part(tmp_path / "spec", 0.16).name, tmp_path / "spec")
    assert identities(first, 1)(0) != identities(second, 1)(0)


@pytest.mark.parametrize("world", ["bullet", "mujoco"])
def test_versions_are_of_what_reads_files_and_of_what_runs(world: str, tmp_path: Path) -> None:
    """MuJoCo's compiler reads models of files, whatever world they are put into."""
    (tmp_path / "ball.urdf").write_text(
        '<robot name="ball"><link name="ball"><collision><geometry><sphere radius="0.03"/></geometry></collision>'
        "</link></robot>",
        encoding="utf-8",
    )
    text = SPEC.read_text("utf-8").replace("world: bullet", f"world: {world}")
    read = text.replace("object: towel-roll", "object: {urdf: ball.urdf}")
    for spec, depends in ((text, world == "mujoco"), (read, True)):
        program = program_of(spec, "spec.yaml", (), tmp_path)
        made_by = versions(program)
        assert ("mujoco" in made_by) == depends
        assert (
            identities(program, 1, {**made_by, "mujoco": "0.0"})(0) != identities(program, 1, made_by)(0)
        ) == depends


def test_a_run_does_not_go_on_with_another_file(tmp_path: Path) -> None:
    part = _part(tmp_path / "spec")
    program = _program(part.name, part.parent)
    folder = new_run(tmp_path / "run", program)
    execute(folder, workers=1)
    _part(folder.files, 0.16)
    with pytest.raises(DiagnosticError, match="this run was made from another spec"):
        execute(folder, workers=1)
