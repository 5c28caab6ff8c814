"""The folders of a stranger's package."""

from __future__ import annotations

from pathlib import Path

from graspdsl.hands.hand_files import hands_in
from graspdsl.hands.mount_files import mounts_in
from graspdsl.objects.object_files import objects_in

STRANGER = Path(__file__).parents[1] / "plugin" / "src" / "graspdsl_stranger"
JAW = hands_in(STRANGER / "hands")["parallel-jaw"]
PORTAL = mounts_in(STRANGER / "mounts")["portal"]
KITCHEN = objects_in(STRANGER / "objects")

PLATE = """<robot name="plate">
  <link name="foot"/>
  <link name="plate">
    <inertial><mass value="1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="bolts" type="fixed"><parent link="foot"/><child link="plate"/></joint>
</robot>
"""


def written_plate(folder: Path, face: str = "plate", base: str = "") -> Path:
    """The file of a mount without joints."""
    (folder / "plate.urdf").write_text(PLATE, "utf-8")
    text = f"mount: plate\nabout: a plate with bolts\nurdf: plate.urdf\nface: {face}\njoints: {{}}\n{base}"
    (folder / "plate.yaml").write_text(text, "utf-8")
    return folder / "plate.yaml"


def replaced(text: str, old: str, new: str) -> str:
    """The text with all of what is there once or more replaced."""
    assert old in text, old
    return text.replace(old, new)
