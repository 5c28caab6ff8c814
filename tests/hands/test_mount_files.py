"""Mount files and hand files in folders of elsewhere: read, held against their models, and told with their places."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import HERE, hands, mounts
from graspdsl.hands.hand_files import hands_in
from graspdsl.hands.mount_files import mounts_in

STRANGER = Path(__file__).parents[1] / "plugin" / "src" / "graspdsl_stranger"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A copy of a stranger's mounts."""
    return Path(shutil.copytree(STRANGER / "mounts", tmp_path / "mounts"))


def changed(file: Path, old: str, new: str) -> None:
    """Write a file anew with one of its places changed."""
    text = file.read_text("utf-8")
    assert old in text
    file.write_text(text.replace(old, new), "utf-8")


def said_of(place: Path) -> list[str]:
    """What is said of the mounts in a place."""
    with pytest.raises(DiagnosticError) as refused:
        mounts_in(place)
    return [fault.message for fault in refused.value.diagnostics]


def test_the_files_of_this_package_are_read_as_others_are() -> None:
    assert {name: mount.model_dump() for name, mount in mounts_in(HERE).items()} == {
        name: mount.model_dump() for name, mount in mounts().items()
    }
    for name in ("barrett", "trio"):
        assert hands_in(HERE / f"{name}.yaml")[name].model_dump() == hands()[name].model_dump()


def test_a_file_or_a_folder_of_mounts_is_read_with_its_model(folder: Path) -> None:
    for place in (folder, folder / "portal.yaml"):
        [(name, mount)] = mounts_in(place).items()
        assert (name, mount.mount) == ("portal", "portal")
        assert 'name="rail-x"' in mount.model
    shutil.rmtree(folder)
    assert 'name="rail-x"' in mount.model  # wherever its files are now


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("portal.yaml", "face: flange", "face: flanch", "portal.yaml:5:7: there is no link 'flanch'"),
        (
            "portal.yaml",
            "  turn: {weight: 2.0}\n",
            "",
            "portal.yaml:8:3: the joint turn of the model moves, but is",
        ),
        (
            "portal.yaml",
            "face: flange",
            "face: frame",
            "portal.yaml:8:11: the joint rail-x does not move the face frame",
        ),
        ("portal.yaml", "turn:", "twist:", "portal.yaml:11:10: there is no joint 'twist'"),
        ("portal.yaml", "rails: [", "turn: [", "portal.yaml:13:9: the joint set turn has the name of a joint"),
        ("portal.yaml", "rail-z]", "rail-w]", "portal.yaml:13:27: there is no joint 'rail-w'"),
        ("portal.yaml", "weight: 2.0", "weight: -2.0", "portal.yaml:11:18: expected a number above 0"),
        ("portal.yaml", "urdf: portal.urdf", "urdf: gate.urdf", "portal.yaml:4:7: there is no file gate.urdf"),
        ("portal.urdf", "<robot", "<robots", "portal.yaml:4:7: portal.urdf is no XML"),
    ],
)
def test_a_fault_is_told_with_its_place(folder: Path, file: str, old: str, new: str, said: str) -> None:
    changed(folder / file, old, new)
    assert any(message.startswith(said) for message in said_of(folder)), said_of(folder)


def test_a_folder_without_any_is_told(tmp_path: Path) -> None:
    assert said_of(tmp_path) == [f"there is no description of a mount in {tmp_path.name}"]


def test_a_faulty_hand_in_a_folder_is_told(tmp_path: Path) -> None:
    hands_folder = Path(shutil.copytree(STRANGER / "hands", tmp_path / "hands"))
    changed(hands_folder / "parallel_jaw.yaml", "cell: cell-left", "cell: cell-up")
    with pytest.raises(DiagnosticError, match=r"parallel_jaw.yaml:13:32: there is no joint 'cell-up' in the model"):
        hands_in(hands_folder)
