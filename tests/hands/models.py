"""A small hand, its model and a spec for tests that change one thing of them."""

from __future__ import annotations

from pathlib import Path

from graspdsl.models.model import Model
from graspdsl.models.reading import model_in
from graspdsl.places.files import SpecFolder

URDF = """\
<robot name="two">
  <material name="grey"><color rgba="0.5 0.5 0.5 1"/></material>
  <link name="palm">
    <inertial><mass value="0.5"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <link name="finger">
    <inertial><origin xyz="0 0 0.02" rpy="0 0 0"/><mass value="0.1"/>
      <inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 0.02"/><geometry><box size="0.01 0.01 0.04"/></geometry></collision>
  </link>
  <joint name="bend" type="revolute"><parent link="palm"/><child link="finger"/><origin xyz="0.03 0 0"/>
    <axis xyz="0 1 0"/><limit lower="-0.5" upper="1" effort="1" velocity="2"/></joint>
  <link name="tip">
    <inertial><mass value="0.01"/><inertia ixx="1e-6" iyy="1e-6" izz="1e-6" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><sphere radius="0.011"/></geometry><material name="grey"/></visual>
    <collision><geometry><sphere radius="0.01"/></geometry></collision>
  </link>
  <joint name="cell" type="fixed"><parent link="finger"/><child link="tip"/><origin xyz="0 0 0.05"/></joint>
  <link name="thumb">
    <inertial><mass value="0.1"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  <joint name="thumb-bend" type="revolute"><parent link="palm"/><child link="thumb"/><origin xyz="-0.03 0 0"/>
    <axis xyz="0 -1 0"/><limit lower="-0.5" upper="1" effort="1" velocity="2"/></joint>
</robot>
"""
HAND = """\
hand: two
urdf: two.urdf
root: palm
palm: palm
joints:
  bend: {weight: 10.0, closes: 1}
  thumb-bend: {weight: 10.0, closes: 1}
contacts:
  pad: {link: tip, cell: cell, sphere: {radius: 0.01}, finger: [bend]}
  thumb: {link: thumb, capsule: {radius: 0.01, length: 0.02, axis: [0.0, 0.0, 1.0]}}
joint_sets:
  both: [bend, thumb-bend]
palm_surface: 0.05
postures:
  open: {bend: 0.1}
"""
SPEC = """\
graspdsl: 1
name: two
scene: {world: bullet, hand: hand.yaml, object: {like: towel-roll, fixed: true}, sensing: exact}
resources: {γ1: pad, γ2: thumb, Γ: "{γ1, γ2}"}
parameters: {κ_f: 0.5}
program:
  - {run: π_close|Γ Γ, until: {contact: all, hold: 0.1}, limit: 0.1}
trials: {count: 1, start: {standoff: 0.005}}
"""


def changed(text: str, change: tuple[str, str]) -> str:
    """The text with its one place changed; the change has to be one."""
    old, new = change
    assert text.count(old) == 1, (old, text.count(old))
    return text.replace(old, new)


def write(folder: Path, urdf: str | bytes = URDF, hand: str = HAND) -> Path:
    """The hand and its spec in a folder; where the spec is."""
    (folder / "two.urdf").write_bytes(urdf if isinstance(urdf, bytes) else urdf.encode())
    (folder / "hand.yaml").write_text(hand, encoding="utf-8")
    (folder / "spec.yaml").write_text(SPEC, encoding="utf-8")
    return folder / "spec.yaml"


def model_of(text: str, root: str = "", name: str = "two.urdf") -> Model:
    """The model in a text that names no files."""
    return model_in(text.encode(), SpecFolder(Path("/")), name, root)


def with_links(links: int) -> str:
    """The model with a chain of so many more links on the tip."""
    link = '<link name="l{}"/><joint name="j{}" type="fixed"><parent link="{}"/><child link="l{}"/></joint>'
    rest = "".join(link.format(i, i, f"l{i - 1}" if i else "tip", i) for i in range(links))
    return changed(URDF, ("</robot>", f"{rest}</robot>"))
