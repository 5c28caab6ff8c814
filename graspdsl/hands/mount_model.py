"""A model as it carries a hand: what hangs on the face left out, joints that keep still made fixed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from graspdsl.angles import roll_pitch_yaw, turned_by_angles
from graspdsl.hands.descriptions import Mount, Pose
from graspdsl.models.joint_kinds import CONTINUOUS, FIXED, REVOLUTE
from graspdsl.models.model import HERE, Frame, Joint, Link, Model
from graspdsl.models.urdf_text import urdf_text

TURN = 2.0 * math.pi  # rad either way, where a joint turns without end


def carrying(mount: Mount, model: Model) -> Mount:
    """The mount with the text of its model as it carries a hand, in which what its file says of frames and of joints
    that keep still is done.

    What hangs on the face is left out: the hand takes its place. A joint without limits has those of a turn either way.
    """
    beyond = model.below(mount.face) - {mount.face}
    links = {name: link for name, link in model.links.items() if name not in beyond}
    joints = {
        name: joint.held(mount.still[name]) if name in mount.still else _bounded(joint)
        for name, joint in model.joints.items()
        if joint.child not in beyond
    }
    changes: dict[str, object] = {"urdf": mount.urdf or mount.mjcf, "mjcf": "", "still": {}}
    for key, at in (("face", mount.face_at), ("holds", mount.holds_at)):
        if at is not None:
            name, frame = f"{mount.mount}-{key}", Frame(np.array(at.position), turned_by_angles(at.rpy))
            links[name] = Link(0.0, np.zeros(3), np.zeros((3, 3)), (), "")
            joints[f"{name}-at"] = Joint(FIXED, getattr(mount, key), name, frame, np.zeros(3), None, 0.0, 0.0, 0.0, "")
            changes |= {key: name, f"{key}_at": None}
    carrier = Model(model.root, links, joints)
    found = mount.model_copy(update=changes)
    if found.holds and found.base is None:
        root = frame_of(carrier, found.holds).inverse()
        x, y, z = root.place.tolist()
        base = Pose(position=(x, y, z), rpy=roll_pitch_yaw(root.rotation))
        found = found.model_copy(update={"base": base})
    return found.with_model(urdf_text(carrier))


def frame_of(model: Model, link: str) -> Frame:
    """The frame of a link in that of the root, all joints at 0."""
    frame = HERE
    for name in model.movers(link):
        frame = frame.then(model.joints[name].frame)
    return frame


def _bounded(joint: Joint) -> Joint:
    return replace(joint, kind=REVOLUTE, limits=(-TURN, TURN)) if joint.kind == CONTINUOUS else joint
