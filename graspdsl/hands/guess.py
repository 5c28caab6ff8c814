"""A hand file guessed from a model: fingers, fingertips, how they close, weights, and where the palm faces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from graspdsl.hands.guess_closing import Closing, closing_of
from graspdsl.hands.guess_face import Face, face_of
from graspdsl.hands.guess_fingers import Finger, fingers_of
from graspdsl.hands.guess_fingertips import FittedTip, fitted_tips
from graspdsl.hands.guess_grasp import GuessedGrasp, grasp_of
from graspdsl.hands.guess_posture import PosedModel
from graspdsl.models.joint_kinds import FIXED, ROTATING
from graspdsl.models.model import Model

SHORTEST = 0.02  # m: the shortest lever that a weight is made of


@dataclass(frozen=True, slots=True)
class GuessedContact:
    """A fingertip: its finger and shape, the drivers that close it, and the model's fixed joint before it, where the
    shape is that of the link itself."""

    finger: Finger
    tip: FittedTip
    closers: tuple[str, ...]
    cell: str


@dataclass(frozen=True, slots=True)
class GuessedJoint:
    """A driven joint: the sign of the motion that closes, its lever [m] at the fingertip that it moves most, and the
    weight that follows; where it is [rad or m], open and closed; whether it turns."""

    closes: int
    lever: float
    weight: float
    opened: float
    closed: float
    turns: bool


@dataclass(frozen=True, slots=True)
class GuessedHand:
    """What can be told of a hand by its model alone.

    contacts: by name, the one that opposes the others first; opening [m]: between the surfaces of opposing tips, open;
    grasp: one to begin with.
    """

    model: Model
    palm: str
    joints: Mapping[str, GuessedJoint]
    couplings: Mapping[str, tuple[str, float, float]]
    contacts: Mapping[str, GuessedContact]
    face: Face
    opening: float
    grasp: GuessedGrasp


def guessed_hand(model: Model) -> GuessedHand:
    """The hand that a model is, as far as that can be told. Raises DiagnosticError for one without two fingers.

    Fingers are the chains of joints that end in links which can touch; the one farthest from the others opposes them.
    """
    posed = PosedModel(model)
    low, high = posed.limits
    neutral = np.clip(np.zeros(len(low)), low, high)
    fingers = fingers_of(posed, neutral)
    closing = closing_of(posed, fingers, neutral)
    face = face_of(posed, fingers, closing)
    frames = posed.frames(closing.pinch)
    sides = zip(fingers.fingers, closing.toward, strict=True)
    tips = fitted_tips(posed, fingers.fingers, [frames[finger.host].rotation.T @ side for finger, side in sides])
    contacts = {}
    for number, (finger, tip) in enumerate(zip(fingers.fingers, tips, strict=True)):
        closers = tuple(name for name, mine in zip(posed.drivers, closing.closers(number), strict=True) if mine)
        contacts[_named(number, len(fingers.fingers))] = GuessedContact(finger, tip, closers, _cell(model, finger, tip))
    shapes = [contact.tip.shape for contact in contacts.values()]
    opening, grasp = grasp_of(posed, fingers, closing, face, shapes)
    return GuessedHand(
        model,
        fingers.palm,
        dict(zip(posed.drivers, _joints(posed, closing), strict=True)),
        {
            name: (posed.drivers[leader], ratio, offset)
            for name, (leader, ratio, offset) in posed.followed.items()
            if name not in posed.drivers
        },
        contacts,
        face,
        opening,
        grasp,
    )


def _named(number: int, count: int) -> str:
    """Names of contacts: a hand of more than two fingers has a thumb."""
    if count == 2:
        return f"finger-{number + 1}"
    return f"finger-{number}" if number else "thumb"


def _cell(model: Model, finger: Finger, tip: FittedTip) -> str:
    """The fixed joint before a fingertip whose link has the very shape."""
    before = next((name for name, joint in model.joints.items() if joint.child == finger.host), "")
    return before if tip.exact and before and model.joints[before].kind == FIXED else ""


def _joints(posed: PosedModel, closing: Closing) -> list[GuessedJoint]:
    levers = np.linalg.norm(closing.columns, axis=1).max(axis=0)
    low, high = posed.limits

    def within(place: float, index: int) -> float:
        return min(max(round(place, 3), float(low[index])), float(high[index]))

    return [
        GuessedJoint(
            int(closing.signs[index]),
            float(levers[index]),
            float(f"{1.0 / max(float(levers[index]), SHORTEST):.2g}"),
            within(float(closing.opened[index]), index),
            within(float(closing.closed[index]), index),
            posed.model.joints[name].kind in ROTATING,
        )
        for index, name in enumerate(posed.drivers)
    ]
