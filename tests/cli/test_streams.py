"""Where the output goes: closed pipes, full disks, narrow encodings, terminals."""

from __future__ import annotations

import fcntl
import json
import os
import pty
import re
import struct
import subprocess
import termios
from pathlib import Path

import pytest

from cli import warm
from cli.program import PROGRAM, SHORT, SPEC, TIMEOUT, FinishedRun, graspdsl

pytestmark = pytest.mark.slow

FULL = Path("/dev/full")


@pytest.mark.parametrize(
    ("words", "code", "messages"),
    [
        (["schema"], 0, b""),
        (["validate", "missing.yaml"], 1, b""),
        (["report", "run"], 0, b"report: run/report.html\n"),
    ],
)
def test_nobody_reads_the_results(words: list[str], code: int, messages: bytes, finished: FinishedRun) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    answer = subprocess.run(
        [PROGRAM, *words], cwd=finished.folder.parent, stdout=writer, stderr=subprocess.PIPE, check=False
    )
    os.close(writer)
    assert (answer.returncode, answer.stderr) == (code, messages)


def test_a_run_goes_on_when_nobody_reads_its_messages(tmp_path: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    command = [PROGRAM, "run", SPEC, *SHORT, "--trials", "1", "--json", "--no-report"]
    answer = subprocess.run(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=writer, check=False)
    os.close(writer)
    assert answer.returncode == 0
    assert json.loads(answer.stdout)["trials"] == {"asked": 1, "finished": 1, "different": 1}


@pytest.mark.skipif(not FULL.exists(), reason="this system has no device that is always full")
@pytest.mark.parametrize("words", [["schema"], ["report", "run"], ["report", "run", "--json"], ["--version"]])
def test_results_that_cannot_be_written(words: list[str], finished: FinishedRun) -> None:
    with FULL.open("wb") as full:
        answer = subprocess.run(
            [PROGRAM, *words], cwd=finished.folder.parent, stdout=full, stderr=subprocess.PIPE, check=False
        )
    assert answer.returncode == 1
    message = "graspdsl: error[output-not-writable]: cannot write the results to stdout: no space left on device\n"
    assert answer.stderr.decode() == message


@pytest.mark.parametrize("closed", [">&-", "2>&-", "<&- >&- 2>&-"])
def test_closed_streams(closed: str, finished: FinishedRun) -> None:
    command = f"'{PROGRAM}' run --resume run {closed}"
    answer = subprocess.run(command, shell=True, cwd=finished.folder.parent, capture_output=True, check=False)
    assert answer.returncode == 0
    assert b"Traceback" not in answer.stderr


def test_ascii_only(finished: FinishedRun) -> None:
    def ascii_of(*words: str | Path) -> str:
        return graspdsl(*words, cwd=finished.folder.parent, env={"PYTHONIOENCODING": "ascii"}).stdout

    assert json.loads(ascii_of("report", "run", "--json")) == finished.document
    assert "φ_fr" in json.dumps(json.loads(ascii_of("explain", "π_gx|Γ Γ", "--json")), ensure_ascii=False)
    lines = ascii_of("report", "run").splitlines()
    assert "||rho_f|| < 0.1, ||rho_m|| < 5 mm" in lines[3]
    assert [" ".join(line.split()) for line in lines[5:7]] == ["How trials ended", "outcome trials share 95 % interval"]
    assert set(lines[7]) == {"-"}
    assert len(lines[7]) == len(lines[6])
    assert ascii_of("explain", "φ_xr|τ_p(Γ) σ_p(Γ)").splitlines() == []
    anew = graspdsl("validate", "φ.yaml", cwd=finished.folder.parent, env={"PYTHONIOENCODING": "ascii"}, anew=True)
    assert ascii_of("validate", "φ.yaml") == anew.stdout
    assert anew.stdout.startswith("phi.yaml: error[file-not-found]")


def _on_a_terminal(columns: int, *words: str | Path, cwd: Path, env: dict[str, str] | None = None) -> str:
    """All that the program writes to a terminal of so many columns."""
    parent, child = pty.openpty()
    fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", 24, columns, 0, 0))
    surroundings = {name: value for name, value in os.environ.items() if name not in {"COLUMNS", "NO_COLOR"}}
    command = [*map(str, words)]
    process = warm.begin(command, cwd, (child, child, child), {**surroundings, "TERM": "xterm", **(env or {})})
    os.close(child)
    written = b""
    while True:
        try:
            piece = os.read(parent, 4096)
        except OSError:  # how Linux tells that nobody has the other end any more
            break
        if not piece:
            break
        written += piece
    os.close(parent)
    warm.ended(process, command, TIMEOUT)
    return written.decode().replace("\r\n", "\n")


@pytest.mark.parametrize("columns", [30, 80])
def test_progress_stays_on_one_line(columns: int, tmp_path: Path) -> None:
    words = ("run", SPEC, *SHORT, "--trials", "2", "--workers", "1", "--no-report")
    text = _on_a_terminal(columns, *words, cwd=tmp_path)
    (line,) = [line for line in text.split("\n") if "/2" in line]
    states = [re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", state) for state in line.split("\r\x1b[2K")]
    counts = [next(word for word in state.split() if "/2" in word) for state in states]
    assert list(dict.fromkeys(counts)) == ["0/2", "1/2", "2/2"]
    assert max(map(len, states)) <= columns
    before = [state for state, count in zip(states, counts, strict=True) if count == "0/2"]
    assert len(set(before)) > 3  # a sign of life before the first trial ends
    assert text.count("\x1b[?25l") == text.count("\x1b[?25h")  # the cursor is there again


def test_colours_only_where_wanted(tmp_path: Path) -> None:
    coloured = _on_a_terminal(80, "validate", "missing.yaml", cwd=tmp_path)
    assert "missing.yaml: \x1b[1;31merror[file-not-found]\x1b[0m: there is no such file" in coloured
    assert "\x1b" not in _on_a_terminal(80, "validate", "missing.yaml", cwd=tmp_path, env={"NO_COLOR": "1"})


@pytest.mark.parametrize("columns", [20, 40, 80])
def test_the_summary_fits_the_terminal(columns: int, finished: FinishedRun) -> None:
    text = _on_a_terminal(columns, "report", "run", cwd=finished.folder.parent)
    *lines, page = re.sub(r"\x1b\[[0-9;]*m", "", text).splitlines()
    assert page == "report: run/report.html"
    assert max(map(len, lines[:-1])) <= columns
    assert lines[-1] == "  graspdsl run run/spec.yaml --trials 3 --seed 2006"
    assert "".join("".join(lines).split()).count("converged") >= 2


def test_a_formula_alone_is_explained_in_a_scene_that_is_told(tmp_path: Path) -> None:
    answer = graspdsl("explain", "π_gx|Γ Γ", "--as", "ascii", cwd=tmp_path)
    assert answer.stdout == "pi_gx|G G\n"
    assert "barrett" in answer.stderr
    assert "Γ = {γ1, <γ2, γ3>}" in answer.stderr
