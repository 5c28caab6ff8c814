"""The contract of hands: what a hand file says of its model, and whether the hand can take anything."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from graspdsl.contracts.described import faults_of, is_named, is_told
from graspdsl.contracts.rule import Breach, contract
from graspdsl.contracts.standing_robots import taken_up
from graspdsl.hands.descriptions import Hand, Robot, joint_limits, mounts
from graspdsl.hands.fingertip_check import fingertip_complaints
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.hand_check import faults
from graspdsl.hands.mount_check import taken_names
from graspdsl.models.model import Model
from graspdsl.models.reading import model_in
from graspdsl.places.files import SpecFolder

MOUNT = "gantry"  # which carries each hand
NARROW = 0.01  # m
WEAK = 0.5  # N
STEP, CLOSE = 1e-5, 1e-6  # of joints; m or rad for each of a joint


def named(hand: Hand) -> Iterator[Breach]:
    """A hand has a name that a spec can write."""
    yield from is_named(hand.hand)


def told(hand: Hand) -> Iterator[Breach]:
    """One line says what it is."""
    yield from is_told(hand.about)


def model(hand: Hand) -> Iterator[Breach]:
    """The model can be read, and bears out what the hand file says: links, joints, couplings, cells, postures."""
    if not hand.urdf:
        return
    yield from faults_of(hand, lambda document: faults(hand, _model(hand), document))


def fingertips(hand: Hand) -> Iterator[Breach]:
    """The declared shapes of the fingertips are those of the model, as far as that can be told."""
    if not hand.urdf:
        return
    yield from faults_of(hand, lambda document: list(fingertip_complaints(hand, _model(hand), document)))


def postures(hand: Hand) -> Iterator[Breach]:
    """There are an open and a closed posture."""
    for name in ("open", "closed") if hand.urdf else ():
        if name not in hand.postures:
            yield f"it has no posture {name}", f"write under postures: {name}: {{JOINT: …}}"


def motion(hand: Hand) -> Iterator[Breach]:
    """Its fingertips move as their Jacobians say, against central differences, and each joint moves one."""
    if not _is_robot(hand):
        return
    robot = _robot(hand)
    known, (lower, upper) = FingertipMotion(robot), map(np.array, joint_limits(robot))
    own = np.isin(list(robot.joints), list(hand.joints))
    at = np.where(own, lower + 0.4 * (upper - lower), 0.0)
    linear, angular = known.jacobians(at)
    # With the mount at zero, the hand's root is turned as the robot's is.
    ends = STEP * np.eye(len(at))[own]
    moved = [(known.centres(at + end) - known.centres(at - end)) / (2.0 * STEP) for end in ends]
    if np.abs(np.stack(moved, axis=-1) - linear[..., own]).max() > CLOSE:
        yield "its fingertips do not move as their Jacobians say", "let couplings and the model agree"
    for name, column in zip(hand.joints, (np.abs(linear) + np.abs(angular)).sum(axis=(0, 1))[own], strict=True):
        if column < CLOSE:
            yield f"{name} moves no fingertip", "leave it out: make it fixed in the model"


def opens(hand: Hand) -> Iterator[Breach]:
    """Somewhere between open and closed, two fingertips have room for something between them, before the palm."""
    if not _is_robot(hand) or len(hand.contacts) < 2:
        return
    room = FingertipMotion(_robot(hand)).openings()
    widest = float(room[room[:, 1] > 0.0, 0].max(initial=0.0))
    if widest < NARROW:
        yield f"its fingertips are never more than {1000 * widest:.3g} mm apart", "mend its postures or its limits"


def strength(hand: Hand) -> Iterator[Breach]:
    """Each fingertip presses as it closes."""
    if not _is_robot(hand):
        return
    for contact, press in zip(hand.contacts, FingertipMotion(_robot(hand)).strongest(), strict=True):
        if press is None or press.force < WEAK:
            yield f"{contact} presses with less than {WEAK} N", "give the joints of its finger an effort (N·m or N)"


def names(hand: Hand) -> Iterator[Breach]:
    """Its names clash with those of no mount of the catalogue."""
    for mount in mounts().values():
        taken = taken_names(Robot(hand=hand, mount=mount))
        yield from ((fault.message, fault.hint or "") for fault in taken)


def start(hand: Hand) -> Iterator[Breach]:
    """In the bullet world it takes up a start before an object, and keeps still there."""
    if hand.urdf:
        yield from taken_up(_robot(hand))


RULES = contract(
    named,
    told,
    model,
    fingertips,
    postures,
    motion,
    opens,
    strength,
    names,
    start,
    name=lambda hand: hand.hand,
    wording=(told,),
)


def _is_robot(hand: Hand) -> bool:
    """Whether it has a model, whose names do not clash with those of its mount: that is a rule of its own."""
    return bool(hand.urdf) and not any(taken_names(_robot(hand)))


def _model(hand: Hand) -> Model:
    return model_in(hand.model.encode(), SpecFolder(Path("/")), f"/{hand.urdf}", hand.root)


def _robot(hand: Hand) -> Robot:
    return Robot(hand=hand, mount=mounts()[MOUNT])
