"""The page on objects: what it says of files and starts is so."""

from __future__ import annotations

import yaml

from graspdsl.compiler.program import examine
from graspdsl.models.mesh_files import FORMATS, MOST_FACES
from graspdsl.objects.standing import STANDING
from graspdsl.spec.scene import Scene
from graspdsl.spec.trials import StartSettings
from graspdsl.worlds.rigid.engine import ROLLING_RESISTANCE

from .pages import PAGES, ROOT, blocks_of

PAGE = PAGES["objects.md"]
BLOCKS = blocks_of(PAGE)
SPEC = "specs/towel_roll_two_contacts.yaml"


def test_its_scenes_and_starts_are_sound() -> None:
    scenes, starts = (block.text for block in BLOCKS if block.language == "yaml" and not block.mark)
    assert [len([Scene.model_validate(yaml.safe_load(line)["scene"]) for line in scenes.splitlines()])] == [5]
    assert len([StartSettings.model_validate(yaml.safe_load(line)["start"]) for line in starts.splitlines()]) == 2


def test_what_falls_is_told_as_it_says() -> None:
    *_, text = (block.text for block in BLOCKS if block.language == "text")
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
