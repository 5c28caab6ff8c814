"""The command line as its users have it: the installed program, in a process of its own."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from cli import warm
from cli.warm import PROGRAM
from graspdsl.trials.interruption import SIGNALS

ROOT = Path(__file__).parents[2]
SPEC = Path(__file__).with_name("towel_roll_two_contacts.yaml")  # as it ships, but in the engine that is quicker
TRIALS = 3
SHORT = ("--set", "program.1.limit=1.0", "--set", "evaluate=[]")  # of SPEC, for a trial of a few seconds
TIMEOUT = 120.0  # s, of a command

Stop = Callable[[subprocess.Popen[str]], None]


def graspdsl(
    *words: str | Path, cwd: Path, env: dict[str, str] | None = None, anew: bool = False, sites: Sequence[Path] = ()
) -> subprocess.CompletedProcess[str]:
    """What the program answers, and its exit code.

    env: of its surroundings; ``anew``: it begins from nothing, for what is looked at while it imports; sites: where
    packages are besides.
    """
    written = [*map(str, words)]
    if not anew:
        done = warm.run(written, cwd, TIMEOUT, *sites, env=env)
    else:
        done = subprocess.run(
            [str(PROGRAM), *written],
            cwd=cwd,
            env={**os.environ, **(env or {})},
            capture_output=True,
            encoding="utf-8",
            timeout=TIMEOUT,
            check=False,
        )
    if "engine-missing" in done.stderr:
        pytest.skip("needs an engine that is not installed")
    return done


def heed_interrupts() -> None:
    """In a child about to begin: a background job ignores SIGINT, nohup SIGHUP, and so would what they begin."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_DFL)


def begun(*words: str | Path, cwd: Path, first: Callable[[], object] = heed_interrupts) -> subprocess.Popen[str]:
    """The program as it runs, in a session of its own; ``first`` is done in its process before it begins."""
    return subprocess.Popen(
        [str(PROGRAM), *map(str, words)],
        cwd=cwd,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
        preexec_fn=first,
    )


def stopped(*words: str | Path, cwd: Path, after: str, stop: Stop) -> subprocess.CompletedProcess[str]:
    """What the program answers when it is stopped once it has said a line with some text on stderr."""
    with begun(*words, cwd=cwd) as process:
        assert process.stderr is not None
        before = ""
        while after not in before:
            line = process.stderr.readline()
            assert line, before
            before += line
        stop(process)
        out, rest = process.communicate(timeout=60)
    return subprocess.CompletedProcess(process.args, process.returncode, out, rest)


def interrupt(process: subprocess.Popen[str]) -> None:
    """Ctrl-C, to the program alone."""
    process.send_signal(signal.SIGINT)


def numbers(document: dict[str, Any]) -> list[dict[str, Any]]:
    """The records of a run but for the time that each trial took."""
    return [{name: value for name, value in record.items() if name != "wall_s"} for record in document["records"]]


def codes(answer: subprocess.CompletedProcess[str]) -> Sequence[str]:
    """The codes of the diagnostics in the JSON document of an answer."""
    (file,) = json.loads(answer.stdout)["files"]
    assert file["ok"] is False
    return [diagnostic["code"] for diagnostic in file["diagnostics"]]


@dataclass(frozen=True)
class FinishedRun:
    """A run that went to its end without interruption, in one process."""

    folder: Path
    document: dict[str, Any]
    messages: str
