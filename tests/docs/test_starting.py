"""The page on specs to begin with: its commands run one after the other."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from cli.program import graspdsl

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "starting.md").read_text("utf-8")
BLOCKS = re.findall(r"^```sh\n(.*?)^```", PAGE, re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_its_commands_run(tmp_path: Path) -> None:
    assert PAGE.count("```") == 2 * len(BLOCKS)
    commands = [line for block in BLOCKS for line in block.splitlines()]
    assert len(commands) >= 8
    for command in commands:
        answer = graspdsl(*shlex.split(command)[1:], cwd=tmp_path)
        assert answer.returncode == 0, answer.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"first.yaml", "box.yaml", "posture.yaml", "second.yaml"}
