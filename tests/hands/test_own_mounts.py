"""A mount file of one's own: what it may leave to its model, how a spec names it, what of it is refused."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from graspdsl.compiler.program import Program, examine, program_of
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.arm_reach import ArmReach
from graspdsl.hands.descriptions import HERE, Robot, base_pose, hands, joint_limits, mounts
from graspdsl.hands.mount_files import mounts_in
from graspdsl.hands.mount_guess import guessed_mount, mount_text
from graspdsl.hands.mount_model import frame_of
from graspdsl.models.model import Frame
from graspdsl.models.reading import read_model
from graspdsl.places.files import SpecFolder
from graspdsl.trials.identity import identities

from .arms import FILE, arm, two_arms, urdf, written

ARM = ["pan", "lift", "elbow", "wrist-1", "wrist-2", "wrist-3"]
SPEC = """\
graspdsl: 1
name: own-arm
scene: {world: bullet, mount: MOUNT, object: towel-roll}
resources: {γ1: finger-3, γ2: finger-1, Γ: "{γ1, γ2}"}
parameters: {κ_f: 0.5}
program: [{run: "π_close|Γ Γ", until: {contact: all}}]
trials: {count: 2, start: {roll: {uniform: [-0.5, 0.5]}}}
"""
SECOND = "mount: arm\nabout: two arms\nurdf: arm.urdf\nface: wrist-3-link\nholds: other-wrist-3-link\n"
STILL = "still: {other-pan: 0.3, other-lift: 1.0, other-elbow: 0.5, other-wrist-1: 0.1, other-wrist-2: -0.4, "


def test_what_a_file_leaves_out_is_as_its_model_has_it(tmp_path: Path) -> None:
    found = mounts_in(written(tmp_path, "mount: arm\nurdf: arm.urdf\n", urdf(arm(tool=False))))["arm"]
    assert (found.face, [*found.joints], found.base) == ("wrist-3-link", ARM, None)
    weights = [joint.weight for joint in found.joints.values()]
    assert 0.8 < weights[0] < weights[-1] == 3.5  # of the shortest lever
    low, high = joint_limits(Robot(hand=hands()["points"], mount=found))
    assert (low[0], high[0]) == pytest.approx((-2 * np.pi, 2 * np.pi))  # what turns without end


def test_the_hand_takes_the_place_of_what_hangs_on_the_face(tmp_path: Path) -> None:
    at = FILE + "face_at: {position: [0.0, 0.0, 0.02], rpy: [0.0, 0.0, 1.0]}\n"
    for file, face in ((FILE, "tool"), (at, "arm-face")):
        found = mounts_in(written(tmp_path, file, urdf(arm())))["arm"]
        links = {link.get("name") for link in ElementTree.fromstring(found.model).iter("link")}
        assert found.face == face
        assert links >= {"tool", face}
        assert not links & {"gripper", "left-jaw", "right-jaw"}


def test_the_other_arm_keeps_still_and_holds(tmp_path: Path) -> None:
    file = SECOND + "holds_at: {position: [0.0, 0.05, 0.0]}\n" + STILL + "other-wrist-3: 2.0}\n"
    found = mounts_in(written(tmp_path, file, two_arms()))["arm"]
    assert [*found.joints] == ARM
    (tmp_path / "whole.urdf").write_text(found.model, "utf-8")
    held = Frame(*base_pose(found)).then(frame_of(read_model(SpecFolder(tmp_path), "whole.urdf"), found.holds))
    np.testing.assert_allclose(held.place, 0.0, atol=1e-9)
    np.testing.assert_allclose(held.rotation, np.eye(3), atol=1e-9)


@pytest.mark.parametrize(
    ("file", "model", "said"),
    [
        ("mount: arm\nurdf: arm.urdf\n", urdf(arm()), "arm.yaml:1:1: the model has 2 ends"),
        (FILE.replace("tool", "tol"), urdf(arm()), "arm.yaml:4:7: there is no link 'tol'"),
        (FILE.replace("face: tool", "mjcf: arm.xml"), urdf(arm()), "arm.yaml:1:1: a mount file names one model"),
        (FILE.replace("tool", "'TODO: the flange'"), urdf(arm()), "arm.yaml:4:7: fill in face: the flange"),
        (FILE + "still: {elbow: 4.0}\n", urdf(arm()), "arm.yaml:6:16: elbow moves from -3 to 3, found 4"),
        (FILE + "still: {elbo: 0.0}\n", urdf(arm()), "arm.yaml:6:15: there is no joint 'elbo'"),
        (FILE + "joints: {pan: {weight: 1}}\n", urdf(arm()), "arm.yaml:6:9: the joint lift of the model moves, but is"),
        (SECOND + STILL + "other-wrist-3: 0}\nbase: {}\n", two_arms(), None),
        (SECOND, two_arms(), "arm.yaml:5:8: other-pan, other-lift, other-elbow, other-wrist-1, other-wrist-2"),
        ("mount: arm\nurdf: arm.urdf\nface: wrist-3-link\n", two_arms(), "arm.yaml:1:8: the joint other-pan of the"),
    ],
)
def test_a_fault_is_told_with_its_place(file: str, model: str, said: str | None, tmp_path: Path) -> None:
    if said is None:
        mounts_in(written(tmp_path, file, model))
        return
    with pytest.raises(DiagnosticError) as refused:
        mounts_in(written(tmp_path, file, model))
    messages = [fault.message for fault in refused.value.diagnostics]
    assert any(message.startswith(said) for message in messages), messages


def own(folder: Path) -> Program:
    """A program of a spec that names a mount file."""
    return program_of(SPEC.replace("MOUNT", "arm.yaml"), "spec.yaml", (), folder)


def test_a_spec_names_a_mount_file(tmp_path: Path) -> None:
    written(tmp_path, FILE, urdf(arm()))
    program = own(tmp_path)
    assert [str(file.kept_as) for file in program.files] == ["arm.yaml", "arm.urdf"]
    before = identities(program, 1)(0)
    written(tmp_path, FILE.replace("-0.5", "-0.6"), urdf(arm()))
    assert identities(own(tmp_path), 1)(0) != before


def test_faults_of_a_mount_are_told_where_the_spec_names_it(tmp_path: Path) -> None:
    written(tmp_path, FILE.replace("tool", "tol"), urdf(arm()))
    for name, code, message in (
        ("arm.yaml", "unknown-link", "arm.yaml:4:7: there is no link 'tol'"),
        ("harm.yaml", "file-not-found", "there is no file harm.yaml"),
        ("gantri", "unknown-mount", "there is no mount 'gantri'"),
    ):
        (fault,) = examine(SPEC.replace("MOUNT", name), "spec.yaml", (), tmp_path).diagnostics
        assert (fault.code, fault.message) == (code, message)
        assert fault.span is not None
        assert (fault.span.line, fault.span.column) == (3, 31)


def test_an_object_that_the_other_hand_does_not_hold_is_refused(tmp_path: Path) -> None:
    (fault,) = examine(SPEC.replace("MOUNT", "dexter"), "spec.yaml", (), tmp_path).diagnostics
    assert (fault.code, fault.span and fault.span.column) == ("not-held", 47)


def test_a_guessed_mount_reaches_the_object(tmp_path: Path) -> None:
    written(tmp_path, "", urdf(arm()))
    guess = guessed_mount(read_model(SpecFolder(tmp_path), "arm.urdf"))
    assert (guess.face, [*(guess.joints or ())]) == ("tool", ARM)
    (tmp_path / "arm.yaml").write_text(mount_text(guess, "arm", "urdf", "arm.urdf"), "utf-8")
    found = mounts_in(tmp_path / "arm.yaml")["arm"]
    reach = ArmReach(Robot(hand=hands()["barrett"], mount=found))
    palm = np.column_stack([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    assert len(reach.postures(np.array([-0.2, 0.0, 0.12]), palm))
    # Without a frame for a tool it is where the last link ends along the axis of its joint.
    written(tmp_path, "", urdf(arm(tool=False)))
    bare = guessed_mount(read_model(SpecFolder(tmp_path), "arm.urdf"))
    assert bare.face == "wrist-3-link"
    assert bare.face_at is not None
    np.testing.assert_allclose(bare.face_at.place, [0.0, 0.03, 0.0], atol=1e-9)
    np.testing.assert_allclose(bare.face_at.rotation[:, 2], [0.0, 1.0, 0.0], atol=1e-9)


def test_what_cannot_be_guessed_is_asked_for(tmp_path: Path) -> None:
    written(tmp_path, "", two_arms())
    guess = guessed_mount(read_model(SpecFolder(tmp_path), "arm.urdf"))
    text = mount_text(guess, "arm", "urdf", "arm.urdf")
    with pytest.raises(DiagnosticError, match=r"fill in face: the link that carries the hand, such as wrist-3-link"):
        mounts_in(written(tmp_path, text, two_arms()))


def test_the_other_hand_of_dexter_holds_at_the_origin(tmp_path: Path) -> None:
    text = (HERE / "dexter.yaml").read_text("utf-8").replace("[-0.42, 0.05, -1.0]", "[-0.42, 0.08, -1.0]")
    with pytest.raises(DiagnosticError, match=r"base right-place is at \[0.0, 0.03, -?0.0\], not upright"):
        mounts_in(written(tmp_path, text.replace("dexter.urdf", "arm.urdf"), (HERE / "dexter.urdf").read_text("utf-8")))
    assert mounts()["dexter"].joints == mounts()["wam"].joints
