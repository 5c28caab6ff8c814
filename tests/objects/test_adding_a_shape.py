"""A new shape is one class in one file and one line in the table: specs, both worlds and the schema then know it."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

CAPSULE = '''
from typing import ClassVar

import numpy as np
from pydantic import Field

from graspdsl.arrays import Array
from graspdsl.objects.cylinder import RoundedCylinder
from graspdsl.objects.mass import Solid, stacked_solid
from graspdsl.objects.shape import DescribedShape, Extent, Size


class Capsule(DescribedShape):
    """A cylinder between two half balls."""

    name: ClassVar = "capsule"
    about: ClassVar = "a capsule"

    diameter: Size = Field(description="diameter (m), 0.005 to 2")
    height: Size = Field(description="height of the whole (m), 0.005 to 2")

    @property
    def extent(self) -> Extent:
        return (self.diameter, self.diameter, self.height)

    @property
    def solid(self) -> Solid:
        return stacked_solid(self.surface().profile)

    def support(self, direction: Array) -> float:
        return self.diameter / 2 + abs(direction[2]) * (self.height - self.diameter) / 2

    def surface(self) -> RoundedCylinder:
        return RoundedCylinder(self.diameter, self.height, self.diameter / 2)
'''
TABLE = """
from graspdsl.objects.shapes import SHAPES
from capsule import Capsule
SHAPES["capsule"] = Capsule
"""
SPEC = """\
graspdsl: 1
name: capsule
scene: {{{scene}, object: {{capsule: {{diameter: 0.08, height: {height}}}, fixed: true}}}}
resources: {{γ1: {contacts}1, γ2: {contacts}2, γ3: {contacts}3, Γ: "{{γ1, γ2, γ3}}"}}
parameters: {{κ_f: 0.5}}
program:
  - {{run: "{formula}", until: {{contact: all}}, limit: 1.0}}
"""
WORLDS = {
    "floating": {"scene": "world: floating, hand: points", "contacts": "point-", "formula": "π_gx|Γ Γ"},
    "bullet": {"scene": "world: bullet", "contacts": "finger-", "formula": "π_close|Γ Γ"},
}


def _said(folder: Path, code: str) -> str:
    """What a program says in which the table of shapes has the new one."""
    (folder / "capsule.py").write_text(CAPSULE, "utf-8")
    done = subprocess.run([sys.executable, "-c", TABLE + code], cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.parametrize("world", WORLDS)
def test_a_trial_runs_on_it(world: str, tmp_path: Path) -> None:
    text = SPEC.format(**WORLDS[world], height=0.2)
    code = f"""
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop
print(trial_loop(program_of({text!r}, "spec.yaml")).run(0, 1).record.outcome.value)
"""
    assert _said(tmp_path, code).strip() in ("converged", "timeout")


def test_it_is_checked_and_in_the_schema(tmp_path: Path) -> None:
    texts = [SPEC.format(**WORLDS["floating"], height=height) for height in (3.0, 0.05)]
    code = f"""
import json
from graspdsl.compiler.program import examine
from graspdsl.spec import json_schema
said = [[found.message for found in examine(text, "spec.yaml").diagnostics] for text in {texts!r}]
print(json.dumps([*said, list(json_schema()["$defs"]["Capsule"]["properties"])]))
"""
    too_large, impossible, keys = json.loads(_said(tmp_path, code))
    assert too_large == ["expected a number of at most 2 (m), found 3"]
    assert [said.partition(":")[0] for said in impossible] == ["there is no such capsule"]
    assert keys == ["diameter", "height"]
