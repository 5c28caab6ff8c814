"""The contract of mounts: what a mount file says of its model, and how it carries a hand."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from graspdsl.contracts.described import faults_of, is_named, is_told
from graspdsl.contracts.rule import Breach, contract
from graspdsl.contracts.standing_robots import taken_up
from graspdsl.hands.descriptions import Mount, Robot, hands, joint_limits
from graspdsl.hands.fingertip_motion import FingertipMotion
from graspdsl.hands.mount_check import taken_names
from graspdsl.hands.mount_files import mount_faults
from graspdsl.models.reading import model_in
from graspdsl.places.files import SpecFolder

HAND = "barrett"  # which each mount has to carry
FELT = 1e-9  # m or rad, of a joint that moves what it carries


def named(mount: Mount) -> Iterator[Breach]:
    """A mount has a name that a spec can write."""
    yield from is_named(mount.mount)


def told(mount: Mount) -> Iterator[Breach]:
    """One line says what it is."""
    yield from is_told(mount.about)


def model(mount: Mount) -> Iterator[Breach]:
    """The model can be read, and bears out what the mount file says: the face, the joints, their limits, the sets."""
    found = model_in(mount.model.encode(), SpecFolder(Path("/")), f"/{mount.urdf}")
    yield from faults_of(mount, lambda document: mount_faults(mount, found, document))


def carries(mount: Mount) -> Iterator[Breach]:
    """Each joint moves the hand."""
    robot = _with(HAND, mount)
    if any(taken_names(robot)):
        return  # it is no robot, as the rule of names says
    lower, upper = (np.array(limits) for limits in joint_limits(robot))
    turned = [np.zeros(len(lower)), lower + 0.6 * (upper - lower)]
    moved = sum(np.abs(part).sum(axis=(0, 1)) for at in turned for part in FingertipMotion(robot).jacobians(at))
    for name, amount in zip(robot.joints, moved, strict=True):
        if name in mount.joints and amount < FELT:
            yield f"{name} does not move the hand", "let each joint lie between the root and the face"


def zero(mount: Mount) -> Iterator[Breach]:
    """A mount without a base starts with all joints at zero, within their limits."""
    robot = _with(HAND, mount)
    for name, low, high in zip(robot.joints, *joint_limits(robot), strict=True):
        if name in mount.joints and not low < high:
            yield f"{name} goes from {low:g} to {high:g}", "let the lower limit lie below the upper one"
        elif name in mount.joints and mount.base is None and not low <= 0.0 <= high:
            yield f"{name} cannot be at 0, where a trial starts", "let its limits hold 0, or say where its base stands"


def names(mount: Mount) -> Iterator[Breach]:
    """Its names clash with those of no hand of the catalogue."""
    for hand in hands():
        yield from ((fault.message, fault.hint or "") for fault in taken_names(_with(hand, mount)))


def start(mount: Mount) -> Iterator[Breach]:
    """In the bullet world it takes the hand to a start before an object, and keeps it still there; one with a base and
    without joints goes nowhere."""
    if mount.base is not None and not mount.joints:
        return
    yield from taken_up(_with(HAND, mount))


RULES = contract(named, told, model, carries, zero, names, start, name=lambda mount: mount.mount, wording=(told,))


def _with(hand: str, mount: Mount) -> Robot:
    return Robot(hand=hands()[hand], mount=mount)
