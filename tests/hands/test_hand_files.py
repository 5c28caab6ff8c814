"""A user's own hand: read from a file, held against its URDF, run without a change to the code."""

from __future__ import annotations

import json
from pathlib import Path

import pybullet_data
import pytest
import yaml

from graspdsl.compiler.program import examine, program_of
from graspdsl.diagnostics import Diagnostic, DiagnosticError, as_text
from graspdsl.hands.descriptions import HERE
from graspdsl.hands.hand_files import FoundHand, HandFileError, hand_in
from graspdsl.spec.named_files import SpecFolder
from graspdsl.trials.loop import identity
from graspdsl.trials.setup import trial_loop

PANDA = Path(pybullet_data.getDataPath(), "franka_panda", "panda.urdf")
GRIPPER = f"""\
hand: gripper
urdf: {PANDA}
root: panda_hand
joints:
  panda_finger_joint1: {{weight: 0.3, closes: -1}}
  panda_finger_joint2: {{weight: 0.3, closes: -1}}
contacts:
  left: {{link: panda_leftfinger, sphere: {{centre: [0.0, 0.0, 0.045], radius: 0.01}}}}
  right: {{link: panda_rightfinger, sphere: {{centre: [0.0, 0.0, 0.045], radius: 0.01}}}}
palm_surface: 0.0584
postures:
  open: {{panda_finger_joint1: 0.04, panda_finger_joint2: 0.04}}
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
<inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>{mesh}</link><link name="tip"/>
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


def complaints(folder: Path, changes: dict[str, object], **model: str) -> tuple[Diagnostic, ...]:
    """What is said of the small hand with changes."""
    with pytest.raises(HandFileError) as caught:
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
    with pytest.raises(HandFileError) as caught:
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


def test_a_gripper_of_others_runs(tmp_path: Path) -> None:
    """Two fingers of an arm's URDF, its arm cut off, without load cells."""
    (tmp_path / "gripper.yaml").write_text(GRIPPER, encoding="utf-8")
    program = program_of(SPEC, "can.yaml", folder=tmp_path)
    record = trial_loop(program).run(0, 1).record
    assert record.outcome == "converged", record.detail
    assert record.orientation_end == pytest.approx(1.5708, abs=0.05)


def test_a_spec_tells_of_the_faults_of_its_hand(tmp_path: Path) -> None:
    (tmp_path / "gripper.yaml").write_text(GRIPPER.replace("link: panda_left", "link: panda_lef"), encoding="utf-8")
    (fault,) = examine(SPEC, "can.yaml", folder=tmp_path).diagnostics
    assert (fault.code, fault.span.line if fault.span else 0) == ("unknown-link", 5)
    assert fault.message.startswith("gripper.yaml:8:")


def test_without_load_cells_there_is_no_load_cell_sensing(tmp_path: Path) -> None:
    (tmp_path / "gripper.yaml").write_text(GRIPPER, encoding="utf-8")
    text = SPEC.replace("sensing: exact", "sensing: load-cell")
    assert [fault.code for fault in examine(text, "can.yaml", folder=tmp_path).diagnostics] == ["not-sensed"]


def test_another_model_makes_other_trials(tmp_path: Path) -> None:
    (tmp_path / "gripper.yaml").write_text(GRIPPER, encoding="utf-8")
    before = identity(program_of(SPEC, "can.yaml", folder=tmp_path), 0, 0)
    (tmp_path / "gripper.yaml").write_text(GRIPPER.replace("radius: 0.01", "radius: 0.011"), encoding="utf-8")
    assert identity(program_of(SPEC, "can.yaml", folder=tmp_path), 0, 0) != before


def test_a_hand_file_that_is_not_there() -> None:
    with pytest.raises(DiagnosticError):
        hand_in(SpecFolder(HERE), "nowhere.yaml")


def test_json_is_of_hand_files_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from typer.testing import CliRunner

    from graspdsl.cli.app import app

    del capsys
    (tmp_path / "gripper.yaml").write_text("# mine\n" + GRIPPER.replace("weight: 0.3", "weight: -1"), encoding="utf-8")
    ran = CliRunner().invoke(app, ["validate", str(tmp_path / "gripper.yaml"), "--json"])
    assert ran.exit_code == 1
    (file,) = json.loads(ran.stdout)["files"]
    assert {fault["line"] for fault in file["diagnostics"]} == {6, 7}
