"""The commands that runs and maps print, typed as they are, where the spec names files that are no longer there."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest
import trimesh

from cli.program import PROGRAM, ROOT, graspdsl, numbers

pytestmark = pytest.mark.slow

HANDS = ROOT / "graspdsl" / "hands"
SPEC = ROOT / "specs" / "hands" / "trio_towel_roll.yaml"
SHORT = ("--set", "program.1.limit=0.5", "--set", "scene.world=mujoco", "--workers", "1")


@pytest.fixture
def spec(tmp_path: Path) -> Path:
    """A spec that names a hand file by a relative path and the file of an object by an absolute one."""
    place = tmp_path / "mine"
    (place / "parts").mkdir(parents=True)
    for name in ("trio.yaml", "trio.urdf"):
        shutil.copy(HANDS / name, place / "parts" / name)
    trimesh.creation.cylinder(radius=0.05, height=0.2).export(place / "can.stl")
    text = SPEC.read_text("utf-8")
    for old, new in (
        ("hand: trio", "hand: parts/trio.yaml"),
        ("object: towel-roll", f"object: {{mesh: {{file: {place / 'can.stl'}}}, mass: 0.5}}"),
    ):
        assert old in text
        text = text.replace(old, new)
    (place / "mine.yaml").write_text(text, "utf-8")
    return place / "mine.yaml"


def typed(command: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """What a shell answers to a command."""
    surroundings = {**os.environ, "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}"}
    return subprocess.run(
        command, shell=True, cwd=cwd, env=surroundings, capture_output=True, encoding="utf-8", timeout=120, check=False
    )


def test_the_command_that_repeats_a_run(spec: Path, tmp_path: Path) -> None:
    first = graspdsl("run", spec, *SHORT, "--trials", "1", "--out", "a run", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    shutil.rmtree(spec.parent)
    command = first.stdout.splitlines()[-1].strip()
    assert "a run/spec.yaml" in command
    again = typed(f"{command} --out again --json", tmp_path)
    assert again.returncode == 0, again.stderr
    before = graspdsl("report", "a run", "--json", cwd=tmp_path)
    assert numbers(json.loads(again.stdout)) == numbers(json.loads(before.stdout))
    for words in ("validate", "explain"):
        assert typed(f"graspdsl {words} again/spec.yaml", tmp_path).returncode == 0
    (tmp_path / "a run" / "run.json").unlink()
    refused = typed(command, tmp_path)
    assert (refused.returncode, "error[file-not-found]" in refused.stderr) == (1, True)


FLOATING = """\
graspdsl: 1
name: floating
scene: {world: floating, hand: parts/trio.yaml, object: ball}
resources: {γ1: digit-1, γ2: digit-2, γ3: digit-3, Γ: "{γ1, γ2, γ3}"}
program:
  - run: π_gx|Γ Γ
    until: {force_residual: 0.1, moment_residual: 0.005}
"""


@pytest.mark.parametrize("floats", [False, True])
def test_the_command_that_repeats_a_map(floats: bool, spec: Path, tmp_path: Path) -> None:
    words = ["--over", "azimuth,polar" if floats else "roll=0:0.2,standoff=0.03:0.05", "--grid", "1x1"]
    if floats:
        spec.write_text(FLOATING, "utf-8")
    else:
        words += SHORT
    first = graspdsl("map", spec, *words, "--out", "a map", "--json", cwd=tmp_path)
    assert first.returncode == 0, first.stderr
    shutil.rmtree(spec.parent)
    made = json.loads(first.stdout)
    again = typed(f"{made['command']} --out again --json", tmp_path)
    assert again.returncode == 0, again.stderr
    kept = set(made) - {"run", "command"}
    assert {name: json.loads(again.stdout)[name] for name in kept} == {name: made[name] for name in kept}


def test_a_spec_beside_other_files_finds_them(spec: Path, tmp_path: Path) -> None:
    """A folder called files, or a run.json, alone does not make the folder of a run."""
    (spec.parent / "files").mkdir()
    assert graspdsl("validate", spec, cwd=tmp_path).returncode == 0
    (spec.parent / "files").rmdir()
    (spec.parent / "run.json").write_text("{}", "utf-8")
    assert graspdsl("validate", spec, cwd=tmp_path).returncode == 0
