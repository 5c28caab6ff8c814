"""A user's own hand: read from a file, held against its URDF, run without a change to the code."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pybullet_data
import pytest
import yaml

from graspdsl.compiler.program import examine, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity, as_text
from graspdsl.hands.description_files import DescriptionFileError
from graspdsl.hands.descriptions import HERE, Robot, mounts
from graspdsl.hands.hand_files import FoundHand, hand_in
from graspdsl.models.model import UNSTATED_EFFORT
from graspdsl.places.files import SpecFolder
from graspdsl.trials.identity import identities
from graspdsl.trials.setup import trial_loop
from graspdsl.worlds.bullet.engine import pybullet
from graspdsl.worlds.bullet.hand import BulletHand

PANDA = Path(pybullet_data.getDataPath(), "franka_panda", "panda.urdf")
# The flat pads of its fingers are no fingertips that sense: each gets one before it.
TIP = """\
<link name="{0}-tip"><inertial><mass value="0.01"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6"/></inertial></link>
<joint name="{0}-mounting" type="fixed"><parent link="panda_{0}finger"/><child link="{0}-tip"/>
<origin xyz="0 {1} 0.045"/></joint>
"""
TIPS = TIP.format("left", 0.004) + TIP.format("right", -0.004)
GRIPPER = """\
hand: gripper
urdf: panda.urdf
root: panda_hand
joints:
  panda_finger_joint1: {weight: 0.3, closes: -1}
  panda_finger_joint2: {weight: 0.3, closes: -1}
contacts:
  left: {link: left-tip, sphere: {radius: 0.01}}
  right: {link: right-tip, sphere: {radius: 0.01}}
palm_surface: 0.0584
"""
SPEC = """\
graspdsl: 1
name: can
scene:
  world: bullet
  hand: gripper.yaml
  object: {cylinder: {diameter: 0.05, height: 0.12}, mass: 0.3}
  sensing: exact
resources: {γ1: left, γ2: right, Γ: "{γ1, γ2}"}
parameters: {κ_f: 0.5}
program:
  - run: π_close|Γ Γ
    until: {contact: all, hold: 0.2}
  - run: π_s|Γ Γ (π_gx|Γ Γ)
    until: {force_residual: 0.1, moment_residual: 0.005, force_error: 0.1, hold: 1.0}
trials:
  start: {approach: side, roll: 0.3, height: 0.08, standoff: 0.02}
"""
TWO_LINKS = """\
<robot name="two"><link name="palm"/><link name="finger"><inertial><mass value="0.1"/>
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>{mesh}</link><link name="tip"><inertial>
<mass value="0.01"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="bend" type="revolute"><parent link="palm"/><child link="finger"/><axis xyz="1 0 0"/>
<limit lower="{lower}" upper="1" effort="1" velocity="1"/></joint>
<joint name="cell" type="fixed"><parent link="finger"/><child link="tip"/></joint></robot>
"""
SMALL = {
    "hand": "small",
    "urdf": "two.urdf",
    "joints": {"bend": {"weight": 10.0, "closes": 1}},
    "contacts": {"pad": {"link": "tip", "cell": "cell", "sphere": {"radius": 0.01}}},
}


def read(folder: Path, changes: dict[str, object], urdf: str = "", mesh: str = "", lower: str = "0") -> FoundHand:
    """The small hand with changes, and its model."""
    (folder / "hand.yaml").write_text(yaml.safe_dump({**SMALL, **changes}, sort_keys=False), encoding="utf-8")
    model = urdf or TWO_LINKS.replace("{mesh}", mesh).replace("{lower}", lower)
    (folder / "two.urdf").write_text(model, encoding="utf-8")
    return hand_in(SpecFolder(folder), "hand.yaml")


def write_gripper(folder: Path, text: str = GRIPPER) -> None:
    """The gripper of an arm with fingertips before its pads, its meshes beside it."""
    whole = PANDA.read_text(encoding="utf-8").replace("</robot>", f"{TIPS}</robot>")
    (folder / "panda.urdf").write_text(whole, encoding="utf-8")
    shutil.copytree(PANDA.parent / "meshes", folder / "meshes", dirs_exist_ok=True)
    (folder / "gripper.yaml").write_text(text, encoding="utf-8")


def complaints(folder: Path, changes: dict[str, object], **model: str) -> tuple[Diagnostic, ...]:
    """What is said of the small hand with changes."""
    with pytest.raises(DescriptionFileError) as caught:
        read(folder, changes, **model)
    return caught.value.diagnostics


@pytest.mark.parametrize("name", ["barrett", "trio"])
def test_hands_of_the_catalogue_agree_with_their_models(name: str) -> None:
    found = hand_in(SpecFolder(HERE), f"{name}.yaml")
    assert found.hand.hand == name


def test_what_a_file_leaves_out_comes_from_the_model(tmp_path: Path) -> None:
    hand = read(tmp_path, {}).hand
    assert (hand.root, hand.palm) == ("palm", "palm")
    assert hand.contacts["pad"].finger == ("bend",)
    assert hand.postures == {"open": {"bend": 0.0}, "closed": {"bend": 1.0}}


FAULTY = (
    ({"palm": "plam"}, "unknown-link", "palm"),
    ({"joints": {"bent": {"weight": 1.0}, "bend": {"weight": 1.0}}}, "unknown-joint", "bend"),
    ({"joints": {"bend": {"weight": 1.0}, "cell": {"weight": 1.0}}}, "joint-not-movable", "fixed"),
    ({"joints": {}}, "joint-left-out", "bend"),
    ({"couplings": {"bend": {"follows": "bend", "ratio": 1.0}}}, "driven-and-coupled", "bend"),
    ({"joints": {}, "couplings": {"bend": {"follows": "bend", "ratio": 1.0}}}, "wrong-coupling", "follows"),
    ({"contacts": {"pad": {"link": "tips", "sphere": {"radius": 0.01}}}}, "unknown-link", "tip"),
    ({"contacts": {"pad": {"link": "tip", "cell": "sell", "sphere": {"radius": 0.01}}}}, "unknown-joint", "cell"),
    ({"contacts": {"pad": {"link": "tip", "cell": "bend", "sphere": {"radius": 0.01}}}}, "wrong-load-cell", "cell"),
    ({"contacts": {"pad": {"sphere": {"radius": 0.01}}}}, "missing-key", "a shape and no link"),
    ({"contacts": {"pad": {"link": "tip", "cell": "cell"}}}, "wrong-form", "exactly one shape"),
    ({"contacts": {"pad": {"link": "tip", "onto": "tip", "sphere": {"radius": 0.01}}}}, "wrong-form", "put onto one"),
    ({"joint_sets": {"all-fingers": ["bend", "bond"]}}, "unknown-joint", "bend"),
    ({"joint_sets": {"all-fingers": ["bend", "cell"]}}, "joint-not-driven", "cell is not among the driven joints"),
    ({"postures": {"open": {"cell": 0.0}}}, "joint-not-driven", "cell is not among the driven joints"),
    ({"postures": {"open": {"bend": 2.0}}}, "out-of-range", "0 to 1"),
    ({"postures": {"open": {"bond": 0.0}}}, "unknown-joint", "bend"),
    ({"urdf": "three.urdf"}, "file-not-found", "three.urdf"),
    ({"urdf": "../two.urdf"}, "outside-of-folder", "leads out"),
    ({"jonts": {}}, "unknown-key", "joints"),
)


@pytest.mark.parametrize(("changes", "code", "words"), FAULTY, ids=[f"{c}-{i}" for i, (_, c, _) in enumerate(FAULTY)])
def test_each_fault_has_its_place(tmp_path: Path, changes: dict[str, object], code: str, words: str) -> None:
    found = [fault for fault in complaints(tmp_path, changes) if fault.code == code]
    assert found
    assert all(fault.span is not None for fault in found)
    assert any(words in f"{fault.message} {fault.hint}" for fault in found)


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_lines_are_counted_alike_whatever_ends_them(tmp_path: Path, end: str) -> None:
    text = yaml.safe_dump({**SMALL, "palm": "plam"}, sort_keys=False)
    line = 1 + text[: text.index("palm")].count("\n")
    (tmp_path / "hand.yaml").write_bytes(text.replace("\n", end).encode())
    (tmp_path / "two.urdf").write_text(TWO_LINKS.replace("{mesh}", "").replace("{lower}", "0"), encoding="utf-8")
    with pytest.raises(DescriptionFileError) as caught:
        hand_in(SpecFolder(tmp_path), "hand.yaml")
    (fault,) = caught.value.diagnostics
    assert fault.span is not None
    assert fault.span.line == line
    assert "plam" in as_text(fault, "hand.yaml", caught.value.text).split("\n")[1]


MODELS = (
    ({"urdf": "<robot><link name='a'>"}, "line 1"),
    ({"urdf": "<!DOCTYPE robot [<!ENTITY a 'aaaa'>]><robot/>"}, "document type"),
    ({"urdf": "<mujoco/>"}, "0 bodies"),
    ({"urdf": "<html/>"}, "<html>"),
    ({"mesh": "<collision><geometry><mesh filename='no.stl'/></geometry></collision>"}, "no.stl"),
    ({"lower": "2"}, "leave no room"),
    ({"lower": "wide"}, "expected a number"),
)


@pytest.mark.parametrize(("model", "words"), MODELS, ids=[words for _, words in MODELS])
def test_faults_of_the_model(tmp_path: Path, model: dict[str, str], words: str) -> None:
    (fault,) = complaints(tmp_path, {}, **model)
    assert words in fault.message
    assert fault.span is not None


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    faults = complaints(tmp_path, {"palm": "p", "joint_sets": {"a": ["b"]}, "postures": {"open": {"bend": 9.0}}})
    assert [fault.code for fault in faults] == ["unknown-link", "unknown-joint", "out-of-range"]


@pytest.mark.slow
def test_a_gripper_of_others_runs(tmp_path: Path) -> None:
    """Two fingers of an arm's URDF, its arm cut off, without load cells."""
    write_gripper(tmp_path)
    program = program_of(SPEC, "can.yaml", folder=tmp_path)
    record = trial_loop(program).run(0, 1).record
    assert record.outcome == "converged", record.detail
    assert record.orientation_end == pytest.approx(1.5708, abs=0.05)


def test_a_spec_tells_of_the_faults_of_its_hand(tmp_path: Path) -> None:
    write_gripper(tmp_path, GRIPPER.replace("link: left", "link: lef"))
    fault = examine(SPEC, "can.yaml", folder=tmp_path).diagnostics[-1]
    assert (fault.code, fault.span.line if fault.span else 0) == ("unknown-link", 5)
    assert fault.message.startswith("gripper.yaml:8:")


def test_without_load_cells_there_is_no_load_cell_sensing(tmp_path: Path) -> None:
    write_gripper(tmp_path)
    text = SPEC.replace("sensing: exact", "sensing: load-cell")
    assert "not-sensed" in [fault.code for fault in examine(text, "can.yaml", folder=tmp_path).diagnostics]


def test_another_model_makes_other_trials(tmp_path: Path) -> None:
    write_gripper(tmp_path)
    before = identities(program_of(SPEC, "can.yaml", folder=tmp_path), 0)(0)
    write_gripper(tmp_path, GRIPPER.replace("radius: 0.01", "radius: 0.011"))
    assert identities(program_of(SPEC, "can.yaml", folder=tmp_path), 0)(0) != before


def test_a_hand_file_that_is_not_there() -> None:
    with pytest.raises(DiagnosticError):
        hand_in(SpecFolder(HERE), "nowhere.yaml")


def test_json_is_of_hand_files_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from typer.testing import CliRunner

    from graspdsl.cli.app import app

    del capsys
    write_gripper(tmp_path, "# mine\n" + GRIPPER.replace("weight: 0.3", "weight: -1"))
    ran = CliRunner().invoke(app, ["validate", str(tmp_path / "gripper.yaml"), "--json"])
    assert ran.exit_code == 1
    (file,) = json.loads(ran.stdout)["files"]
    assert {fault["line"] for fault in file["diagnostics"]} == {6, 7}


SLIDE = TWO_LINKS.replace('type="revolute"', 'type="prismatic"').replace("{mesh}", "").replace("{lower}", "0")


@pytest.mark.parametrize(
    ("closes", "lower", "upper", "opened", "closed"),
    [
        (1, 0.0, 0.04, 0.0, 0.04),
        (-1, 0.0, 0.04, 0.04, 0.0),
        (1, -0.04, 0.0, -0.04, 0.0),
        (-1, -0.04, 0.0, 0.0, -0.04),
        (1, -0.5, 1.0, 0.0, 1.0),
        (-1, 0.2, 1.0, 1.0, 0.2),
        (1, 0.2, 1.0, 0.2, 1.0),
    ],
)
def test_open_is_never_closed(
    closes: int, lower: float, upper: float, opened: float, closed: float, tmp_path: Path
) -> None:
    model = SLIDE.replace('lower="0" upper="1"', f'lower="{lower}" upper="{upper}"')
    hand = read(tmp_path, {"joints": {"bend": {"weight": 10.0, "closes": closes}}}, urdf=model).hand
    assert hand.postures == {"open": {"bend": opened}, "closed": {"bend": closed}}


@pytest.mark.parametrize(
    "changes",
    [
        {"joints": {"bend": {"weight": 1.0}}},
        {"postures": {"open": {"bend": 1.0}}},
        {"postures": {"open": {"bend": 0.3}, "closed": {"bend": 0.3}}},
        {"contacts": {"pad": {"link": "palm", "sphere": {"radius": 0.01}}}},
    ],
)
def test_a_fingertip_that_nothing_closes_is_an_error(changes: dict[str, object], tmp_path: Path) -> None:
    faults = complaints(tmp_path, changes)
    assert "never-closes" in [fault.code for fault in faults]


def test_a_mimic_of_a_driven_joint_is_passed_over_with_a_warning(tmp_path: Path) -> None:
    mimic = '<mimic joint="other" multiplier="-2"/><axis xyz="1 0 0"/>'
    model = TWO_LINKS.replace('<axis xyz="1 0 0"/>', mimic).replace("{mesh}", "").replace("{lower}", "0")
    (warning,) = read(tmp_path, {}, urdf=model).warnings
    assert (warning.code, warning.severity) == ("mimic-passed-over", Severity.WARNING)
    assert "bend mimics other" in warning.message
    assert "bend: {follows: other, ratio: -2}" in (warning.hint or "")


@pytest.mark.parametrize("effort", ["", 'effort="0"', 'effort="3"'])
def test_an_effort_that_a_model_does_not_state_is_told(effort: str, tmp_path: Path) -> None:
    model = TWO_LINKS.replace('effort="1"', effort).replace("{mesh}", "").replace("{lower}", "0")
    found = read(tmp_path, {}, urdf=model)
    robot = Robot(hand=found.hand, mount=mounts()["gantry"])
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        hand = BulletHand(engine, client, robot, np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0]), 0.4)
    finally:
        engine.disconnect(client)
    used = hand.efforts[hand.movable_names.index("bend")]
    assert used == (3.0 if "3" in effort else UNSTATED_EFFORT)
    said = [warning.message for warning in found.warnings]
    assert len(said) == ("3" not in effort)
    assert all("of bend: up to 50 N m, or N of a slide, is used" in message for message in said)
