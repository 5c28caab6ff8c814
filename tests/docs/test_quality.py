"""The page on grades: its blocks run, what they claim is so, and the table is what its script makes."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from quality.grasps import antipodal

from graspdsl.quality.contact_models import PATCH, SoftFinger
from graspdsl.quality.wrench_space import wrench_space

from .test_contracts import BLOCK
from .test_python import CLAIM

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "quality.md").read_text("utf-8")
BLOCKS = BLOCK.findall(PAGE)
SCRIPT = runpy.run_path(str(DOCS / "render_quality.py"))


def test_every_block_is_checked() -> None:
    assert PAGE.count("```") == 2 * len(BLOCKS)
    assert {mark or language for mark, _, language, _ in BLOCKS} == {"spec", "sh", "python"}


def test_what_it_claims_is_so() -> None:
    names: dict[str, Any] = {}
    lines = [line for _, _, language, text in BLOCKS if language == "python" for line in text.splitlines()]
    claims = 0
    for line in lines:
        claim = CLAIM.match(line)
        if claim is None:
            exec(line, names)
        else:
            assert repr(eval(claim["said"], names)) == claim["value"], claim["said"]
            claims += 1
    assert claims >= 8
    assert names["patch"] == pytest.approx(PATCH, rel=1e-12)


@pytest.mark.slow
def test_its_command_runs(tmp_path: Path) -> None:
    [(name, spec)] = [(name, text) for mark, name, _, text in BLOCKS if mark == "spec"]
    [command] = [text for _, _, language, text in BLOCKS if language == "sh"]
    (tmp_path / name).write_text(spec, "utf-8")
    words = command.split()
    program = Path(sys.executable).with_name(words[0])
    done = subprocess.run([program, *words[1:]], cwd=tmp_path, capture_output=True, encoding="utf-8", check=False)
    assert done.returncode == 0, done.stderr
    said = " ".join(done.stdout.split())
    assert "torque scale of 50 mm, as the spec gives it, for all grasps" in said
    assert "soft finger contact, μ = 0.4, μ_t = 0.652 mm" in said
    assert not re.search(r"warning\[", done.stderr)


@pytest.mark.slow
def test_the_table_is_what_its_script_makes() -> None:
    """A row of it; run docs/render_quality.py where it is not."""
    [row] = SCRIPT["rows"]("2, drawn", (8,))
    assert f"\n{row}\n" in PAGE
    assert PAGE.count("\n| 2, drawn |") == len(SCRIPT["EDGES"])


@pytest.mark.parametrize("torsion", [0.002, 0.04])
def test_its_round_cones_are_those_of_a_closed_form(torsion: float) -> None:
    """Two antipodal soft fingers: ε = min(μ_t / r, μ / √(2 + μ²)), moments over r."""
    space = wrench_space(*antipodal(0.05), SoftFinger(0.5, torsion, 8), length=0.05)
    low, high = SCRIPT["round_cones"](space, 0.02)
    expected = min(torsion / 0.05, 0.5 / np.sqrt(2.25))
    assert low * (1.0 - 1e-9) <= expected <= high * (1.0 + 1e-9)
    assert high - low <= 0.02 * high
