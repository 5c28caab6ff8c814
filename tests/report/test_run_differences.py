"""What differs between two runs is said key by key, and nothing else is."""

from __future__ import annotations

import dataclasses
import json
from hashlib import sha256
from pathlib import Path

import pytest
from stored_runs import stored_run
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.places.files import NamedFile
from graspdsl.plugins.kinds import Plugin
from graspdsl.report.run_differences import DIGITS, Difference, differences, differences_table
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder

SPECS = Path(__file__).parents[2] / "specs"
SPEC = SPECS / "chapter" / "4_30_grasp_cartesian.yaml"


def _made(place: Path, *overrides: str, spec: Path = SPEC) -> RunFolder:
    return stored_run(place, spec, "trials.count=1", *overrides, begun=False)


def _found(first: RunFolder, second: RunFolder) -> list[Difference]:
    return differences((first, program_of_run(first)), (second, program_of_run(second)))


def test_values_stand_in_for_those_of_the_spec_and_defaults_count(tmp_path: Path) -> None:
    first = _made(tmp_path / "a")
    said = ("trials.seed=7", "program.0.limit=3", "evaluate=[force-closure]", "trials.keep=ends")
    assert _found(first, _made(tmp_path / "b", *said)) == [
        Difference("spec", "program.0.limit", 20.0, 3.0, "s"),
        Difference("spec", "evaluate", [], ["force-closure"]),
        Difference("spec", "trials.seed", 2006, 7),
        Difference("spec", "trials.keep", "all", "ends"),
    ]
    assert _found(first, _made(tmp_path / "c", "trials.seed=2006", "trials.keep=all")) == []


def test_versions_plugins_and_files(tmp_path: Path) -> None:
    first, second = _made(tmp_path / "run-a"), _made(tmp_path / "run-b")
    second.manifest = dataclasses.replace(
        second.manifest,
        versions={**second.manifest.versions, "numpy": "0.1"},
        plugins=(Plugin("potentials", "φ_h", "kit", "1.0", "abc"),),
    )
    numpy, program = first.manifest.versions["numpy"], program_of_run(first)
    meshes = [dataclasses.replace(program, files=(NamedFile(Path("part.obj"), content),)) for content in (b"a", b"b")]
    assert differences((first, meshes[0]), (second, meshes[1])) == [
        Difference("version", "numpy", numpy, "0.1"),
        Difference("version", "kit", None, "1.0"),
        Difference("plug-in", "potentials φ_h", None, "kit 1.0, abc"),
        Difference("file", "part.obj", sha256(b"a").hexdigest()[:DIGITS], sha256(b"b").hexdigest()[:DIGITS]),
    ]


def test_values_are_written_with_their_units() -> None:
    found = [
        Difference("spec", "program.0.limit", 20.0, None, "s"),
        Difference("spec", "trials.start.roll.uniform", [-1.5, 1.5], "π", "rad"),
        Difference("spec", "scene.object.held", True, False),
    ]
    cells = differences_table(found, ("a", "b")).cells()
    assert [[cell.text for cell in row[2:]] for row in cells] == [
        ["20.0 s", "–"],
        ["[-1.5, 1.5] rad", "π"],
        ["true", "false"],
    ]


@pytest.mark.slow
def test_another_world_another_hand(tmp_path: Path) -> None:
    towel = SPECS / "towel_roll_two_contacts.yaml"
    found = {one.key: one for one in _found(_made(tmp_path / "a"), _made(tmp_path / "b", spec=towel))}
    assert (found["scene.hand"].first, found["scene.hand"].second) == ("points", "barrett")
    assert found["trials.start.roll.uniform"] == Difference(
        "spec", "trials.start.roll.uniform", None, [-1.5, 1.5], "rad"
    )


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    _made(Path("a"))
    _made(Path("b"), "program.0.limit=3")
    answer = CliRunner().invoke(app, ["diff", "a", "b"])
    assert (answer.exit_code, answer.stderr) == (0, "")
    assert answer.stdout.splitlines()[-1].split() == ["spec", "program.0.limit", "20.0", "s", "3.0", "s"]
    same = CliRunner().invoke(app, ["diff", "a", "a"])
    assert (same.exit_code, same.stdout.startswith("nothing differs")) == (0, True)
    document = json.loads(CliRunner().invoke(app, ["diff", "a", "b", "--json"]).stdout)
    assert (document["runs"], document["same"], len(document["differences"])) == (["a", "b"], False, 1)
    Path("b/spec.yaml").write_text("graspdsl: one", "utf-8")
    faulty = CliRunner().invoke(app, ["diff", "a", "b"])
    assert (faulty.exit_code, faulty.stdout) == (1, "")
    assert "b/spec.yaml:1:11: error[wrong-version]" in faulty.stderr
    assert "missing: error[folder-not-found]" in CliRunner().invoke(app, ["diff", "missing", "a"]).stderr
