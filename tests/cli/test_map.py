"""``graspdsl map``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from cli.program import ROOT, SPEC, graspdsl, interrupt, stopped
from graspdsl.trials.store import RunFolder

pytestmark = pytest.mark.slow

FLOATING = ROOT / "specs" / "compare" / "moment_subject_to_force.yaml"
SHORT = ("--set", "program.1.limit=1.0")  # s: enough to tell the classes of the cells apart
HAND = ("--over", "roll,height=-0.2:0.2", "--grid", "2x2", *SHORT)


def without_place(document: dict[str, Any]) -> dict[str, Any]:
    """A map's numbers but for the folder that it was made in."""
    return {name: value for name, value in document.items() if name not in ("run", "command")}


def test_a_map_of_a_hand_does_not_depend_on_workers(tmp_path: Path) -> None:
    """The same map by one and by two; it is a run that can be reported, and that its command makes again."""
    maps = {}
    for workers in ("1", "2"):
        folder = tmp_path / workers
        done = graspdsl("map", SPEC, *HAND, "--workers", workers, "--out", folder, "--json", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        maps[workers] = json.loads(done.stdout)
        assert json.loads((folder / "map.json").read_text("utf-8")) == {
            name: value for name, value in maps[workers].items() if name != "run"
        }
        assert (folder / "map.png").read_bytes().startswith(b"\x89PNG")
        assert "<svg" in (folder / "map.svg").read_text("utf-8")
    assert without_place(maps["1"]) == without_place(maps["2"])
    in_the_table = maps["1"]["grid"][0]
    assert [maps["1"]["classes"][place]["outcome"] for place in in_the_table] == ["infeasible-start"] * 2
    reasons = maps["1"]["details"][0]
    assert all(reason.startswith("the start is not feasible: ") for reason in reasons)
    assert maps["1"]["feasible"] > 0
    assert maps["1"]["fixed"]["standoff"] == "0.07 m"
    assert "infeasible-start" in graspdsl("report", tmp_path / "1", cwd=tmp_path).stdout
    words = maps["1"]["command"].split()
    assert words[:2] == ["graspdsl", "map"]
    again = graspdsl(*words[1:], "--out", tmp_path / "again", "--json", cwd=tmp_path)
    assert without_place(json.loads(again.stdout)) == without_place(maps["1"])


def test_an_interrupted_map_goes_on(tmp_path: Path) -> None:
    """What was finished is kept; the line that is printed finishes the map."""
    words = ("map", SPEC, "--over", "roll,height", "--grid", "2x2", *SHORT, "--workers", "1", "--out", "m")
    begun = stopped(*words, cwd=tmp_path, after="1/4", stop=interrupt)
    assert begun.returncode == 130
    assert "graspdsl map --resume m" in begun.stderr
    assert not (tmp_path / "m" / "map.json").exists()
    done = graspdsl("map", "--resume", "m", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "finished before" in done.stderr
    assert (tmp_path / "m" / "map.json").exists()


def test_a_map_of_floating_contacts(tmp_path: Path) -> None:
    """By default a new folder in runs/; the command makes the same map again."""
    done = graspdsl("map", FLOATING, "--over", "polar,azimuth=0:3", "--grid", "5x4", "--seed", "3", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "20 of 20 feasible starts converged" in done.stdout
    assert "20 of 20 cells" in done.stderr
    folder = tmp_path / "runs" / "compare-moment-subject-to-force-map-001"
    first = json.loads((folder / "map.json").read_text("utf-8"))
    assert [(axis["parameter"], axis["cells"]) for axis in first["axes"]] == [("polar", 5), ("azimuth", 4)]
    assert [len(row) for row in first["grid"]] == [5] * 4
    again = graspdsl(*first["command"].split()[1:], "--out", "again", "--json", cwd=tmp_path)
    assert without_place(json.loads(again.stdout)) == without_place(first)
    assert graspdsl(*first["command"].split()[1:], "--out", "again", cwd=tmp_path).returncode == 1


def test_a_map_of_an_object_from_a_file_keeps_the_file(tmp_path: Path) -> None:
    """Its command makes the same map again when the file is gone, which a smaller part does not."""
    part, spec = tmp_path / "part.stl", tmp_path / "part.yaml"
    spec.write_text(SPEC.read_text("utf-8").replace("object: towel-roll", "object: {mesh: {file: part.stl}}"), "utf-8")
    words = ("--over", "roll,height=0.08:0.12", "--grid", "2x1", *SHORT, "--workers", "1", "--json")
    maps = {}
    for name, radius in (("large", 0.045), ("small", 0.025)):
        trimesh.creation.cylinder(radius=radius, height=0.18).export(part)
        done = graspdsl("map", spec, *words, "--out", tmp_path / name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        maps[name] = json.loads(done.stdout)
    part.unlink()
    spec.unlink()
    assert [file.suffix for file in (tmp_path / "large" / "files").iterdir()] == [".stl"]
    again = graspdsl(*maps["large"]["command"].split()[1:], "--out", "again", "--json", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    assert without_place(json.loads(again.stdout)) == without_place(maps["large"])
    ends = {name: RunFolder.open(tmp_path / name).records() for name in ("large", "small", "again")}
    shown = {name: [record.orientation_end for record in records] for name, records in ends.items()}
    assert np.isfinite(shown["large"]).any()
    np.testing.assert_array_equal(shown["again"], shown["large"])
    assert not np.array_equal(shown["small"], shown["large"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--over", "roll,height", "--grid", "40"), "COLUMNSxROWS"),
        (("--over", "roll,height", "--grid", "0x4"), "1 to 1000"),
        (("--over", "roll,height", "--grid", "1000x1000"), "100000"),
        (("--over", "roll"), "two parameters"),
        (("--over", "roll,height,yaw"), "two parameters"),
        (("--over", "roll,roll"), "named twice"),
        (("--over", "roll=1:-1,height"), "not below"),
        (("--over", "roll=a:b,height"), "two numbers"),
        (("--over", "roll=nan:1,height"), "two numbers"),
        (("--over", "roll=1,height"), "NAME=LOW:HIGH"),
        (("--over", "roll=٠:١,height"), "two numbers"),
        (("--over", "roll=1_0:2_0,height"), "two numbers"),
        (("--over", "roll,height", "--grid", "٤x٤"), "COLUMNSxROWS"),
        ((), "--over"),
        (("--over", "roll,height", "--resume", "x"), "keeps all"),
    ],
)
def test_wrong_use_says_what_is_right(words: tuple[str, ...], said: str, tmp_path: Path) -> None:
    done = graspdsl("map", SPEC, *words, cwd=tmp_path, env={"COLUMNS": "200"})
    assert done.returncode == 2
    assert said in done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        *(("--grid", "5x5"), ("--grid", "40x40"), ("--seed", "3"), ("--contact", "point-1"), ("--out", "y")),
        *(("--over", "roll,height"), ("--set", "scene.friction=0.5")),
    ],
)
def test_a_resumed_map_takes_nothing_that_it_would_ignore(words: tuple[str, ...], tmp_path: Path) -> None:
    done = graspdsl("map", "--resume", "x", *words, cwd=tmp_path, env={"COLUMNS": "200"})
    assert (done.returncode, "keeps all that it was begun with" in done.stderr) == (2, True)


def test_an_interrupted_map_of_floating_contacts_says_that_nothing_is_kept(tmp_path: Path) -> None:
    words = ("map", FLOATING, "--over", "azimuth,polar", "--grid", "300x300", "--out", "m")
    begun = stopped(*words, cwd=tmp_path, after="cells, seed", stop=interrupt)
    assert begun.returncode == 130
    assert begun.stderr.splitlines()[-1].startswith("interrupted; nothing is kept of a map of floating contacts")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("spec", "words", "code"),
    [
        (SPEC, ("--over", "rol,height"), "unknown-start-parameter"),
        (SPEC, ("--over", "yaw,height"), "no-bounds"),
        (SPEC, ("--over", "roll=0:9,height"), "out-of-range"),
        (SPEC, ("--over", "roll,height", "--contact", "finger-1"), "not-mapped"),
        (FLOATING, ("--over", "roll,height"), "unknown-start-parameter"),
        (FLOATING, ("--over", "azimuth,polar", "--contact", "point-9"), "unknown-contact"),
        (Path("nowhere.yaml"), ("--over", "roll,height"), "file-not-found"),
    ],
)
def test_wrong_input_is_one_complaint(spec: Path, words: tuple[str, ...], code: str, tmp_path: Path) -> None:
    done = graspdsl("map", spec, *words, "--grid", "2x2", "--json", cwd=tmp_path)
    assert done.returncode == 1
    [file] = json.loads(done.stdout)["files"]
    assert [diagnostic["code"] for diagnostic in file["diagnostics"]] == [code]
    assert done.stderr.count("error[") == 1


def test_only_a_map_can_be_finished_as_one(tmp_path: Path) -> None:
    done = graspdsl("map", "--resume", tmp_path, cwd=tmp_path)
    assert (done.returncode, "not-a-run" in done.stderr) == (1, True)
    graspdsl("run", FLOATING, "--trials", "1", "--out", "plain", cwd=tmp_path)
    done = graspdsl("map", "--resume", "plain", cwd=tmp_path)
    assert (done.returncode, "not-a-map" in done.stderr) == (1, True)
