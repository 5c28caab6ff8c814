"""What a hand file leaves to its model: the root, the fingers, couplings, and where open and closed are."""

from __future__ import annotations

from collections.abc import Mapping

from graspdsl.hands.descriptions import Contact, Coupling, Hand
from graspdsl.models.joint_kinds import HINGES
from graspdsl.models.model import Model

Posture = Mapping[str, float]


def coupled(hand: Hand, model: Model) -> Hand:
    """A hand with the couplings that its model has and its file says nothing of."""
    adopted = dict[str, Coupling]()
    for name, joint in model.joints.items():
        whole = model.origin_of_motion(name)
        if joint.kind in HINGES and whole.joint != name and name not in (*hand.joints, *hand.couplings):
            led = hand.couplings.get(whole.joint, Coupling(follows=whole.joint, ratio=1.0, offset=0.0))
            ratio, offset = whole.multiplier * led.ratio, whole.multiplier * led.offset + whole.offset
            if led.follows in hand.joints and ratio != 0.0:
                adopted[name] = Coupling.model_construct(follows=led.follows, ratio=ratio, offset=offset)
    return hand.model_copy(update={"couplings": {**hand.couplings, **adopted}})


def completed(hand: Hand, model: Model) -> Hand:
    """A hand with what its file leaves to its model.

    The root is the model's, the palm the root; a finger is all driven joints that move its tip; open and closed are as
    ``open_and_closed`` has them, within the limits of the model.
    """
    opened, closed = (_within(posture, model) for posture in open_and_closed(hand, model))
    changes = {
        "urdf": hand.urdf or hand.mjcf,
        "root": model.root,
        "palm": hand.palm or model.root,
        "postures": {"open": opened, "closed": closed},
        "contacts": {
            name: contact.model_copy(update={"finger": finger_of(contact, hand, model)})
            for name, contact in hand.contacts.items()
        },
    }
    return hand.model_copy(update=changes)


def _within(posture: Posture, model: Model) -> Posture:
    limits = {name: model.joints[name].limits or (0.0, 0.0) for name in posture}
    return {name: min(max(place, limits[name][0]), limits[name][1]) for name, place in posture.items()}


def open_and_closed(hand: Hand, model: Model) -> tuple[Posture, Posture]:
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


def finger_of(contact: Contact, hand: Hand, model: Model) -> tuple[str, ...]:
    """The driven joints of a fingertip's own finger: those that its file names, or all that move it."""
    if contact.finger:
        return contact.finger
    movers = (hand.couplings[name].follows if name in hand.couplings else name for name in model.movers(contact.host))
    return tuple(dict.fromkeys(name for name in movers if name in hand.joints))
