"""The pages of docs/ and their blocks, and what it is to run those: all of a page, in their order, in one folder.

A block is read by its language and by the comment in the line above it:

    spec: NAME, code: NAME   it is the file NAME of that folder; NAME may come again, when a reader is to change it
    sh                       its graspdsl commands run and end well; after ``fails`` the last one ends with exit code 1
    text                     after ``sh``, lines of what that printed, in their order; after ``python``, all of it
    python                   runs, in one namespace a page; a line that ends with # → and a value has that value
    shown: WHY               its commands are only read: each is one that the program knows, with options that it knows

``file``, ``project``, ``offers`` and the rest are for tests of single pages, as are blocks in other languages.
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cli.program import graspdsl
from typer.main import get_command

from graspdsl.cli.app import app

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
PAGES = {path.relative_to(DOCS).as_posix(): path.read_text("utf-8") for path in sorted(DOCS.rglob("*.md"))}
BLOCK = re.compile(r"(?:^<!-- (\w+)(?:: (.*?))? -->\n)?^```(\w+)\n(.*?)^```$", flags=re.S | re.M)
CLAIM = re.compile(r"^(?P<said>.*\S) +# → (?P<value>.*)$")


@dataclass(frozen=True)
class Block:
    """A block of a page: what the comment above it says, its language, its text."""

    mark: str
    about: str
    language: str
    text: str

    @property
    def file(self) -> str:
        """The name of the file that it is; empty where it is none."""
        return self.about if self.mark in ("spec", "code") else ""

    @property
    def commands(self) -> list[list[str]]:
        """The words of its graspdsl commands."""
        lines = self.text.replace("\\\n", " ").splitlines() if self.language == "sh" else []
        found = [shlex.split(line, comments=True) for line in lines]
        return [words[1:] for words in found if words[:1] == ["graspdsl"]]


def blocks_of(text: str) -> list[Block]:
    """All blocks of a page."""
    found = [Block(*groups) for groups in BLOCK.findall(text)]
    assert text.count("```") == 2 * len(found), "a block that is not read"
    return found


def run_page(text: str, folder: Path, sites: Sequence[Path] = ()) -> None:
    """Run the blocks of a page in a folder, in which the process is; ``sites``: where packages are besides."""
    blocks = blocks_of(text)
    for block in reversed(blocks):
        if block.file:
            (folder / block.file).write_text(block.text, "utf-8")
    names, printed, ran = dict[str, Any](), "", ""
    for block in blocks:
        if block.mark == "shown":
            known(block)
        elif block.file:
            (folder / block.file).write_text(block.text, "utf-8")
        elif block.language == "sh":
            printed = _commanded(block, folder, sites)
        elif block.language == "python" and not block.mark:
            printed = _executed(block.text, names)
        elif block.language == "text" and ran == "sh":
            lines = iter(map(_spaced, printed.splitlines()))
            missing = [line for line in block.text.splitlines() if _spaced(line) not in lines]
            assert not missing, f"{missing[0]}\nis not in\n{printed}"
        elif block.language == "text" and ran == "python":
            assert block.text == printed, f"{block.text}\nis not what is printed:\n{printed}"
        ran = block.language if not block.file and block.mark in ("", "fails") else ""


def _spaced(line: str) -> str:
    return " ".join(line.split())


def known(block: Block) -> None:
    """Each command of a block is one of the program's, and so are its options."""
    commands = vars(get_command(app))["commands"]
    assert block.about
    for name, *words in block.commands:
        if name == "--version":
            continue
        command = commands[name]
        if hasattr(command, "commands") and words and words[0] in command.commands:
            command, words = command.commands[words[0]], words[1:]
        command.make_context(name, words)


def _commanded(block: Block, folder: Path, sites: Sequence[Path]) -> str:
    assert block.commands, f"nothing here is run: {block.text}"
    said = ""
    for place, words in enumerate(block.commands, 1):
        into = words[-1] if words[-2:-1] == [">"] else None
        done = graspdsl(*words[:-2] if into else words, cwd=folder, sites=sites)
        if into:
            (folder / into).write_text(done.stdout, "utf-8")
        said = done.stderr if into else done.stdout + done.stderr
        fails = block.mark == "fails" and place == len(block.commands)
        assert done.returncode == fails, said
        assert fails or not re.search(r"^\S+: (error|warning)\[", said, flags=re.M), said
    return said


def _executed(code: str, names: dict[str, Any]) -> str:
    """Run a block of Python; what it prints."""
    with contextlib.redirect_stdout(io.StringIO()) as said:
        for part in re.split(r"^(.*# → .*\n)", code, flags=re.M):
            claim = CLAIM.match(part)
            if claim is None:
                exec(compile(part, "a page", "exec"), names)
            else:
                assert repr(eval(claim["said"], names)) == claim["value"], claim["said"]
    return said.getvalue()
