"""An arm of six joints with a gripper, as models of industrial arms are written; two of it on a post; mount files."""

from __future__ import annotations

import math
from pathlib import Path

HALF = math.pi / 2
# name, origin xyz and rpy, kind
JOINTS = (
    ("pan", "0 0 0.15", "0 0 0", "continuous"),
    ("lift", "0 0.13 0", f"0 {HALF} 0", "revolute"),
    ("elbow", "0 -0.12 0.42", "0 0 0", "revolute"),
    ("wrist-1", "0 0 0.39", f"0 {HALF} 0", "revolute"),
    ("wrist-2", "0 0.1 0", "0 0 0", "revolute"),
    ("wrist-3", "0 0 0.1", "0 0 0", "revolute"),
)
AXES = {"pan": "0 0 1", "lift": "0 1 0", "elbow": "0 1 0", "wrist-1": "0 1 0", "wrist-2": "0 0 1", "wrist-3": "0 1 0"}
INERTIAL = (
    '<inertial><mass value="{mass}"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>'
)
LIMIT = '<limit lower="-3" upper="3" effort="100" velocity="3"/>'
JAW = """<link name="{p}{0}-jaw">{inertial}<collision><origin xyz="0 {1} 0.05"/>
<geometry><box size="0.02 0.01 0.1"/></geometry></collision></link>
<joint name="{p}{0}-slide" type="prismatic"><parent link="{p}gripper"/><child link="{p}{0}-jaw"/>
<axis xyz="0 {1} 0"/><limit lower="0" upper="0.04" effort="50" velocity="1"/></joint>"""


def arm(prefix: str = "", *, tool: bool = True) -> str:
    """Links and joints of an arm; with a ``tool`` frame, z out of its flange, and a gripper on that."""
    parts, parent = [f'<link name="{prefix}foot">{INERTIAL.format(mass=4)}</link>'], f"{prefix}foot"
    for name, xyz, rpy, kind in JOINTS:
        link = f"{prefix}{name}-link"
        solid = '<collision><origin xyz="0 0 0.03"/><geometry><box size="0.06 0.06 0.06"/></geometry></collision>'
        parts.append(f'<link name="{link}">{INERTIAL.format(mass=2)}{solid}</link>')
        limit = LIMIT if kind == "revolute" else '<limit effort="100" velocity="3"/>'
        parts.append(
            f'<joint name="{prefix}{name}" type="{kind}"><parent link="{parent}"/><child link="{link}"/>'
            f'<origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="{AXES[name]}"/>{limit}</joint>'
        )
        parent = link
    if tool:
        parts.append(
            f'<link name="{prefix}tool"/><joint name="{prefix}tool-at" type="fixed"><parent link="{parent}"/>'
            f'<child link="{prefix}tool"/><origin xyz="0 0.08 0" rpy="{-HALF} 0 0"/></joint>'
            f'<link name="{prefix}gripper">{INERTIAL.format(mass=0.5)}<collision><geometry><sphere radius="0.03"/>'
            f'</geometry></collision></link><joint name="{prefix}bolt" type="fixed"><parent link="{prefix}tool"/>'
            f'<child link="{prefix}gripper"/></joint>'
        )
        inertial = INERTIAL.format(mass=0.1)
        parts += [JAW.format(side, way, p=prefix, inertial=inertial) for side, way in (("left", 1), ("right", -1))]
    return "\n".join(parts)


def urdf(*parts: str) -> str:
    """A URDF of parts."""
    return '<robot name="stranger">' + "\n".join(parts) + "</robot>"


def two_arms() -> str:
    """Two of the arm on a post, the other one to its right."""
    post = f'<link name="post">{INERTIAL.format(mass=20)}</link>'
    bolts = (
        f'<joint name="{prefix}shoulder" type="fixed"><parent link="post"/><child link="{prefix}foot"/>'
        f'<origin xyz="0 {y} 0.9"/></joint>'
        for prefix, y in (("", 0.4), ("other-", -0.4))
    )
    return urdf(post, arm(tool=False), arm("other-", tool=False), *bolts)


def written(folder: Path, file: str, model: str) -> Path:
    """A mount file and its model, arm.yaml and arm.urdf, in a folder."""
    (folder / "arm.urdf").write_text(model, "utf-8")
    (folder / "arm.yaml").write_text(file, "utf-8")
    return folder / "arm.yaml"


FILE = "mount: arm\nabout: an arm\nurdf: arm.urdf\nface: tool\nbase: {position: [-0.5, 0.0, 0.0]}\n"
