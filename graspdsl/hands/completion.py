"""What a hand file leaves to its model: the root, the fingers, and where open and closed are."""

from __future__ import annotations

from collections.abc import Mapping

from graspdsl.hands.descriptions import Contact, Hand
from graspdsl.hands.robot_model import RobotModel

Posture = Mapping[str, float]


def completed(hand: Hand, model: RobotModel) -> Hand:
    """A hand with what its file leaves to its model.

    The root is the model's, the palm the root; a finger is all driven joints that move its tip; open and closed are as
    ``open_and_closed`` has them.
    """
    opened, closed = open_and_closed(hand, model)
    root = hand.root or model.root
    changes = {
        "urdf": hand.urdf or hand.mjcf,
        "root": root,
        "palm": hand.palm or root,
        "postures": {"open": opened, "closed": closed},
        "contacts": {
            name: contact.model_copy(update={"finger": finger_of(contact, hand, model)})
            for name, contact in hand.contacts.items()
        },
    }
    return hand.model_copy(update=changes)


def open_and_closed(hand: Hand, model: RobotModel) -> tuple[Posture, Posture]:
    """Where the driven joints of a hand are, open and closed.

    Where the file does not say: a joint that closes is closed when it has gone as far as it can, and open where it is
    nearest to 0, or where that is as far as it can go, at its other end. One that does not close is nearest to 0.
    """
    opened, closed = dict[str, float](), dict[str, float]()
    for name, joint in hand.joints.items():
        low, high = (model.joints[name].limits if name in model.joints else None) or (0.0, 0.0)
        first, last = (low, high) if joint.closes > 0 else (high, low)
        nearest = min(max(0.0, low), high)
        closed[name] = last if joint.closes else nearest
        opened[name] = first if joint.closes and nearest == last else nearest
    return {**opened, **hand.postures.get("open", {})}, {**closed, **hand.postures.get("closed", {})}


def finger_of(contact: Contact, hand: Hand, model: RobotModel) -> tuple[str, ...]:
    """The driven joints of a fingertip's own finger: those that its file names, or all that move it."""
    if contact.finger:
        return contact.finger
    movers = (hand.couplings[name].follows if name in hand.couplings else name for name in model.movers(contact.link))
    return tuple(dict.fromkeys(name for name in movers if name in hand.joints))
