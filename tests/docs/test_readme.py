"""Every block of the README is what it claims to be: commands run, specs are the shipped ones, messages are real."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from cli.program import graspdsl

from graspdsl.compiler.program import examine
from graspdsl.diagnostics import as_text
from graspdsl.trials.outcomes import OUTCOMES

from .pages import ROOT

README = (ROOT / "README.md").read_text("utf-8")
BLOCKS = re.findall(r"(?:<!-- (\w+): (.*?) -->\n)?```(\w+)\n(.*?)```", README, flags=re.S)
COMMANDS = [line for _, _, kind, text in BLOCKS if kind == "sh" for line in text.splitlines()]


def blocks(kind: str) -> list[tuple[str, str]]:
    """The argument and text of the blocks that a comment marks as of this kind."""
    return [(argument, text) for mark, argument, _, text in BLOCKS if mark == kind]


def test_every_block_is_checked() -> None:
    """A block is a command, or it is marked with what it must equal; what is printed is of a command that is there."""
    assert all(mark or language == "sh" for mark, _, language, _ in BLOCKS)
    assert {command for command, _ in blocks("printed")} <= set(COMMANDS)
    assert len(BLOCKS) >= 6


def shell_blocks() -> list[list[str]]:
    """The graspdsl commands of each block; those of one block run in order, in one folder."""
    found = [
        [line for line in text.splitlines() if line.startswith("graspdsl ")]
        for *_, kind, text in BLOCKS
        if kind == "sh"
    ]
    return [commands for commands in found if commands]


def printed(command: str, place: Path) -> str:
    """What one of the README's commands prints, run in a folder."""
    words = [str(ROOT / word) if word.startswith("specs/") else word for word in shlex.split(command)[1:]]
    done = graspdsl(*words, cwd=place)
    assert done.returncode == 0, done.stderr
    return done.stdout


def _alike(line: str) -> str:
    """A line without what may be otherwise on another machine: numbers, how a trial ended, what was said of it, and how
    wide a table is for that."""
    ending = "|".join(OUTCOMES)
    line = re.sub(rf"^({ending}) +(?!\d)\S.*", "outcome and why", line)
    line = re.sub("─+", "─", line)
    return re.sub(r"-?\d[\d.]*", "1", " ".join(re.sub(rf"^({ending}) ", "outcome ", line).split()))


def check_shown(command: str, output: str) -> None:
    """The lines of each block that shows a command's output are lines that it prints, in their order."""
    for text in (text for shown, text in blocks("printed") if shown == command):
        lines = iter(map(_alike, output.splitlines()))
        assert all(_alike(line) in lines for line in text.splitlines())


@pytest.mark.slow
@pytest.mark.parametrize("commands", shell_blocks(), ids=lambda commands: commands[0])
def test_commands_run(commands: list[str], tmp_path: Path) -> None:
    """The graspdsl commands run as they stand, and print what is shown; runs go to a folder of their own."""
    for command in commands:
        output = printed(command, tmp_path)
        assert output
        check_shown(command, output)


def test_make_knows_the_targets() -> None:
    """What the README tells people to make, the Makefile has, and its demo is the command by hand."""
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = [line.split()[1] for line in COMMANDS if line.startswith("make ")]
    assert targets == ["demo", "test", "experiments"]
    assert all(re.search(rf"^{target}:", makefile, flags=re.M) for target in targets)
    [by_hand] = [line for line in COMMANDS if "graspdsl run" in line and line.startswith(".venv")]
    assert by_hand.removeprefix(".venv/bin/") in makefile


def test_specs_are_the_shipped_ones() -> None:
    """A spec in the README is the file it names, to the letter."""
    for name, text in blocks("spec"):
        assert text == (ROOT / "specs" / name).read_text("utf-8")


def test_messages_are_real() -> None:
    """A diagnostic in the README is what the tool says when the shown spec is changed as noted."""
    [(_, good)] = blocks("spec")
    for change, shown in blocks("diagnostics"):
        old, new = change.split(" → ")
        assert good.count(old) == 1
        faulty = good.replace(old, new)
        found = "\n".join(as_text(d, "spec.yaml", faulty) for d in examine(faulty, "spec.yaml").diagnostics)
        assert shown.strip() == found


def test_pictures_exist() -> None:
    """Every picture and linked file of the README is there."""
    for target in re.findall(r"\]\(([^)]+)\)", README):
        assert target.startswith("http") or (ROOT / target).is_file()
