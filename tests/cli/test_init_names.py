"""Where files to begin with are written, and where not; how they are named."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from graspdsl.cli.starting import init_hand, init_mount
from graspdsl.cli.viewing import view_hand
from graspdsl.diagnostics import DiagnosticError
from graspdsl.hands.descriptions import HERE

WAM = HERE / "wam.urdf"


def _refused(model: Path, out: Path) -> str:
    before = sorted(out.parent.glob("*"))
    codes = set[str]()
    for init in (init_hand, init_mount):
        with pytest.raises(DiagnosticError) as caught:
            init(model, out, "")
        codes |= {fault.code for fault in caught.value.diagnostics}
    assert sorted(out.parent.glob("*")) == before
    (code,) = codes
    return code


def test_a_place_where_no_file_can_be_is_told(tmp_path: Path) -> None:
    (tmp_path / "loop.urdf").symlink_to("loop.urdf")
    (tmp_path / "gone.yaml").symlink_to("nowhere")
    assert _refused(WAM, tmp_path / "arm.txt") == "unknown-suffix"
    assert _refused(WAM, tmp_path / "gone.yaml") == "file-exists"
    assert _refused(tmp_path / "loop.urdf", tmp_path / "arm.yaml") == "link-loop"


@pytest.mark.parametrize("name", [f"{'a' * 300}.yaml", "file/arm.yaml"])
def test_a_name_that_the_folder_refuses_is_told(name: str, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(DiagnosticError) as caught:
        init_mount(WAM, tmp_path / name, "")
    assert [fault.code for fault in caught.value.diagnostics] == ["folder-not-writable"]


def test_pictures_that_are_there_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "mine-open.png").touch()
    with pytest.raises(DiagnosticError, match="there already"):
        init_hand(HERE / "trio.urdf", tmp_path / "mine.yaml", "")
    assert [path.name for path in tmp_path.iterdir()] == ["mine-open.png"]


def test_names_are_read_back_as_text(tmp_path: Path) -> None:
    model = tmp_path / "an arm\nface: x.urdf"
    model.write_bytes(WAM.read_bytes())
    assert init_mount(model, tmp_path / "123.yaml", "") == 0
    assert yaml.safe_load((tmp_path / "123.yaml").read_text("utf-8"))["mount"] == "123"


def test_a_hand_with_names_of_its_mount_is_not_drawn(tmp_path: Path) -> None:
    for name in ("barrett.urdf", "barrett.yaml"):
        (tmp_path / name).write_text((HERE / name).read_text("utf-8").replace("base-1", "wrist-x"), "utf-8")
    with pytest.raises(DiagnosticError, match="has the name of a joint of the mount"):
        view_hand(str(tmp_path / "barrett.yaml"), tmp_path)
