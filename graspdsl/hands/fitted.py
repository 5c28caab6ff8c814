"""A model as its hand file has it: coupled joints counted from where they are led, the palm's normal along z."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graspdsl.arrays import Array
from graspdsl.hands.descriptions import UP, Coupling, Hand
from graspdsl.models.joint_kinds import FIXED, ROTATING
from graspdsl.models.model import Frame, Joint, Link, Model

ROUNDING = 1e-6  # rad or m
SMALL = 0.05  # of the range of a coupled joint, or rad: how far beyond it is put down to rounded numbers


def coupled_range(model: Model, name: str, coupling: Coupling) -> tuple[float, float] | None:
    """From where to where a joint is led [rad or m], None where one of the two has no limits."""
    leading = model.joints[coupling.follows].limits
    if leading is None or model.joints[name].limits is None:
        return None
    low, high = sorted(coupling.ratio * end + coupling.offset for end in leading)
    return low, high


def is_slightly_beyond(joint: Joint, low: float, high: float) -> bool:
    """Whether a range is beyond a joint's limits by so little that it may be clipped."""
    least, most = joint.limits or (low, high)
    slack = max(SMALL * (most - least), SMALL if joint.kind in ROTATING else 0.0)
    return low >= least - slack and high <= most + slack


def fitted(hand: Hand, model: Model) -> tuple[Hand, Model]:
    """A hand and its model without offsets of couplings, and with a root that a mount carries by its z axis.

    Leaders whose followers would go slightly beyond their limits go as far as these let them; followers that the model
    itself would have go farther beyond go there. A coupled joint is at 0 where its leader is. Where the palm does not
    face along the root's z axis, or its centre is not at the root's origin, a new root is, before the hand's.
    """
    joints = dict(model.joints)
    for name, coupling in hand.couplings.items():
        joint, leader = joints[name], joints[coupling.follows]
        led = coupled_range(model, name, coupling)
        if led is not None and not is_slightly_beyond(joint, *led):
            joint = joints[name] = replace(joint, limits=led)
        elif joint.limits is not None and leader.limits is not None:
            ends = sorted((end - coupling.offset) / coupling.ratio for end in joint.limits)
            low, high = max(leader.limits[0], ends[0]), min(leader.limits[1], ends[1])
            if low > leader.limits[0] + ROUNDING or high < leader.limits[1] - ROUNDING:
                joints[coupling.follows] = replace(leader, limits=(low, high))
        if coupling.offset:
            joints[name] = _counted_from(joint, coupling.offset)
    couplings = {name: each.model_copy(update={"offset": 0.0}) for name, each in hand.couplings.items()}
    hand = hand.model_copy(update={"couplings": couplings})
    model = replace(model, joints=joints)
    face = Frame(np.array(hand.palm_centre), palm_rotation(hand))
    if not np.any(face.place) and np.array_equal(face.rotation, np.eye(3)):
        return hand, model
    root = f"{model.root}-mounted"
    before = Joint(FIXED, root, model.root, face.inverse(), np.zeros(3), None, 0.0, 0.0, 0.0, "")
    mounted = Model(
        root,
        {root: Link(0.0, np.zeros(3), np.zeros((3, 3)), (), ""), **model.links},
        {f"{root}-fixed": before, **joints},
        model.warnings,
    )
    palm = hand.palm or model.root
    return hand.model_copy(update={"root": root, "palm": palm}), mounted


def palm_rotation(hand: Hand) -> Array:
    """The rotation (3, 3) of the frame by which a hand is carried, in that of its root: z where the palm faces, x
    across it; where the file does not say, x is the root's x, or y where that is near z."""
    if hand.palm_normal == UP and hand.palm_across is None:
        return np.eye(3)
    z = np.array(hand.palm_normal) / np.linalg.norm(hand.palm_normal)
    across = hand.palm_across or ((1.0, 0.0, 0.0) if abs(z[0]) < 0.9 else (0.0, 1.0, 0.0))
    x = np.array(across) - (z @ np.array(across)) * z
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(z, x), z])


def _counted_from(joint: Joint, offset: float) -> Joint:
    """The same joint, its place counted from an offset."""
    limits = None if joint.limits is None else (joint.limits[0] - offset, joint.limits[1] - offset)
    return replace(joint, frame=joint.at(offset), limits=limits)
