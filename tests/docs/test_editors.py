"""The page on editors: its commands are there, and its settings can be read."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from cli.program import graspdsl
from shipped import SPECS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "editors.md"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)


def _blocks(language: str) -> list[str]:
    return [block for said, block in BLOCKS if said == language]


def test_every_editor_starts_the_command_that_there_is() -> None:
    [settings] = map(json.loads, _blocks("json"))
    assert [settings["glspc.server.command"], *settings["glspc.server.commandArguments"]] == ["graspdsl", "lsp"]
    assert all("'graspdsl', 'lsp'" in block for block in _blocks("lua"))
    assert all('"graspdsl" "lsp"' in block for block in _blocks("elisp"))
    assert {said for said, _ in BLOCKS} == {"sh", "lua", "elisp", "json", "yaml"}


@pytest.mark.slow
def test_its_commands_are_there(tmp_path: Path) -> None:
    install, schema = _blocks("sh")
    assert "graspdsl[lsp]" in install
    command, _, file = schema.strip().partition(" > ")
    assert graspdsl(*command.split()[1:], cwd=tmp_path).stdout == (SPECS / file).read_text("utf-8")
    assert "--allow-code" in graspdsl("lsp", "--help", cwd=tmp_path).stdout


def test_its_schema_line_is_that_of_the_specs() -> None:
    [line] = _blocks("yaml")
    assert (SPECS / "towel_roll_two_contacts.yaml").read_text("utf-8").startswith(line)
