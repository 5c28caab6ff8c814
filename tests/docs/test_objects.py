"""The page on objects: its blocks are sound, and what it says of files and starts is so."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from graspdsl.compiler.program import examine
from graspdsl.models.mesh_files import FORMATS, MOST_FACES
from graspdsl.objects.standing import STANDING
from graspdsl.spec.scene import Scene
from graspdsl.spec.trials import StartSettings
from graspdsl.worlds.rigid.engine import ROLLING_RESISTANCE

from .test_contracts import BLOCK

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "objects.md").read_text("utf-8")
BLOCKS = BLOCK.findall(PAGE)
SPEC = "specs/towel_roll_two_contacts.yaml"


def test_every_block_is_checked() -> None:
    assert PAGE.count("```") == 2 * len(BLOCKS)
    assert [mark or language for mark, _, language, _ in BLOCKS] == ["yaml", "sh", "spec", "text", "yaml"]


def test_its_scenes_and_starts_are_sound() -> None:
    scenes, starts = (text for mark, _, language, text in BLOCKS if language == "yaml" and not mark)
    assert [len([Scene.model_validate(yaml.safe_load(line)["scene"]) for line in scenes.splitlines()])] == [5]
    assert len([StartSettings.model_validate(yaml.safe_load(line)["start"]) for line in starts.splitlines()]) == 2


def test_what_falls_is_told_as_it_says() -> None:
    [text] = [text for _, _, language, text in BLOCKS if language == "text"]
    spec = (ROOT / SPEC).read_text("utf-8")
    egg = spec.replace("object: towel-roll\n", "object: {ellipsoid: {size: [0.06, 0.06, 0.12]}, mass: 1}\n")
    [fault] = examine(egg, "spec.yaml").diagnostics
    assert fault.message in text
    assert f"hint: {fault.hint}" in text


def test_its_numbers_and_formats_are_those_of_the_program() -> None:
    assert all(suffix.removeprefix(".").upper() in PAGE for suffix in FORMATS)
    assert f"{MOST_FACES // 1000} 000 triangles" in PAGE
    assert f"by up to {STANDING:g}°" in PAGE
    assert f"a lever of {1000 * ROLLING_RESISTANCE:g} mm" in PAGE


@pytest.mark.slow
def test_its_command_runs(tmp_path: Path) -> None:
    [(name, spec)] = [(name, text) for mark, name, _, text in BLOCKS if mark == "spec"]
    [command] = [text for _, _, language, text in BLOCKS if language == "sh"]
    (tmp_path / name).write_text(spec, "utf-8")
    words = command.split()
    program = Path(sys.executable).with_name(words[0])
    done = subprocess.run([program, *words[1:]], cwd=tmp_path, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    assert "1 of 1 trials converged" in " ".join(done.stdout.split())
