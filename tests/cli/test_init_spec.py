"""Specs to begin with, and those that ship."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
from pathlib import Path

import pytest
import yaml

from graspdsl.api.programs import examined
from graspdsl.spec.formatting import formatted

from .program import PROGRAM, TIMEOUT, graspdsl

# In millimetres: a corner that two fingers side by side cannot meet, and a slab that stands across the table's axes.
CORNER = "v 0 0 0\nv 60 0 0\nv 0 60 0\nv 0 0 60\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
SLAB = "".join(
    [
        *(f"v {x + y} {x - y} {z}\n" for z in (0, 180) for x, y in ((-60, -20), (60, -20), (60, 20), (-60, 20))),
        "f 1 2 3 4\nf 5 8 7 6\nf 1 5 6 2\nf 2 6 7 3\nf 3 7 8 4\nf 4 8 5 1\n",
    ]
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("wishes", "said"),
    [
        ("", {"hand": "barrett", "object": "towel-roll"}),
        ("--world mujoco --object box --hand trio --sensing skin", {"hand": "trio", "sensing": "skin"}),
        ("--world floating", {"world": "floating", "hand": "points"}),
        ("--world floating --object sphere --controller pi_fr", {"object": "sphere"}),
        ("--controller π_g", {}),
        ("--object part.obj", {"object": {"mesh": {"file": "part.obj", "scale": 0.001}}}),
        ("--object {cylinder:{diameter:0.06,height:0.15}}", {}),
    ],
)
def test_what_is_written_is_sound_and_formatted(wishes: str, said: dict[str, object], tmp_path: Path) -> None:
    """By default and for wishes; without one warning."""
    (tmp_path / "part.obj").write_text(SLAB, "utf-8")
    words = [word.replace(":", ": ") if word.startswith("{") else word for word in wishes.split()]
    answer = graspdsl("init", "mine.yaml", *words, cwd=tmp_path)
    assert answer.returncode == 0, answer.stderr
    assert answer.stdout == "mine.yaml\n"
    assert answer.stderr == "next: graspdsl explain mine.yaml\n      graspdsl run mine.yaml\n"
    text, examination = examined(tmp_path / "mine.yaml")
    assert examination.program is not None
    assert examination.diagnostics == ()
    assert formatted(text) == text
    scene = yaml.safe_load(text)["scene"]
    assert said.items() <= scene.items()


@pytest.mark.slow
def test_what_is_written_runs(tmp_path: Path) -> None:
    assert graspdsl("init", "--object", "box", cwd=tmp_path).returncode == 0
    run = graspdsl("run", "grasp.yaml", "--trials", "1", "--workers", "1", "--json", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    assert not {"infeasible-start", "crashed"} & {*json.loads(run.stdout)["outcomes"]}


@pytest.mark.parametrize(
    ("words", "code", "told"),
    [
        ("--world mujoco --object part.obj", 1, "closes without meeting the object"),
        ("--from 4.26 --world mujoco", 2, "has its own object"),
        ("--from 4.27", 1, "error[unknown-spec]: no spec that ships is called '4.27'"),
        ("--world mars", 1, "error[unknown-world]"),
        ("--hand barett", 1, "did you mean barrett?"),
        ("--hand nowhere.yaml", 1, "error[file-not-found]"),
        ("--object tovel-roll", 1, "did you mean towel-roll?"),
        ("--world floating --object box", 1, "error[shape-not-in-world]"),
        ("--world floating --controller pi_h", 1, "graspdsl init --from 4.22"),
        ("--world floating --controller pi_nothing", 1, "error[unknown-controller]"),
        ("--sensing hearing", 1, "hearing"),
        ("mine.txt", 1, "error[unknown-suffix]"),
        ("folder.yaml --force", 1, "error[is-a-directory]"),
    ],
)
def test_what_cannot_be_is_told(words: str, code: int, told: str, tmp_path: Path) -> None:
    (tmp_path / "part.obj").write_text(CORNER, "utf-8")
    (tmp_path / "folder.yaml").mkdir()
    answer = graspdsl("init", *words.split(), cwd=tmp_path)
    assert answer.returncode == code
    assert told in answer.stderr
    assert {path.name for path in tmp_path.iterdir()} == {"part.obj", "folder.yaml"}


def test_specs_that_ship(tmp_path: Path) -> None:
    """They are listed, written by name, equation or experiment, never over a file, and run by name."""
    listed = json.loads(graspdsl("list", "specs", "--json", cwd=tmp_path).stdout)["specs"]
    names = [spec["name"] for spec in listed]
    assert len(names) == len(set(names)) >= 30
    assert {"slide-with-posture", "experiment-4", "towel-roll-two-contacts"} <= set(names)
    for wanted, name in {"4.26": "slide-with-posture", "experiment 2": "experiment-2", "cstar": "cstar"}.items():
        answer = graspdsl("init", "it.yaml", "--from", wanted, "--force", cwd=tmp_path)
        assert answer.returncode == 0, answer.stderr
        assert yaml.safe_load((tmp_path / "it.yaml").read_text("utf-8"))["name"] == name
    refused = graspdsl("init", "it.yaml", "--from", "4.26", cwd=tmp_path)
    assert refused.returncode == 1
    assert "error[file-exists]" in refused.stderr
    assert yaml.safe_load((tmp_path / "it.yaml").read_text("utf-8"))["name"] == "cstar"
    assert graspdsl("validate", "force-residual", "it.yaml", cwd=tmp_path).returncode == 0
    shown = graspdsl("explain", "force-residual", "--as", "unicode", cwd=tmp_path)
    assert shown.stdout == "π_fr|Γ Γ\n"
    assert "graspdsl init --from force-residual" in shown.stderr


@pytest.mark.slow
def test_at_a_terminal_one_is_asked_and_asked_again_after_a_slip(tmp_path: Path) -> None:
    ours, its = os.openpty()
    with subprocess.Popen([str(PROGRAM), "init"], cwd=tmp_path, stdin=its, stdout=its, stderr=its) as asking:
        os.close(its)
        os.write(ours, b"flaoting\nfloating\n\nsphere\n\npi_fr\n")
        said = b""
        with contextlib.suppress(OSError):  # which is how a terminal ends
            while more := os.read(ours, 4096):
                said += more
        assert asking.wait(TIMEOUT) == 0
    os.close(ours)
    assert b"did you mean floating?" in said
    text = (tmp_path / "grasp.yaml").read_text("utf-8")
    assert yaml.safe_load(text)["scene"] == {"world": "floating", "hand": "points", "object": "sphere"}
    assert "π_fr|Γ Γ" in text
