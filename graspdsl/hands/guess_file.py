"""The text of a guessed hand file, each guess with why; and of a spec to begin with."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from textwrap import wrap

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import listed
from graspdsl.hands.fingertips import CapsuleTip, EllipsoidTip, FingertipShape, SphereTip
from graspdsl.hands.first_spec import GRASP, PRESS, FirstSpec, yaml_name, yaml_text
from graspdsl.hands.guess import GuessedContact, GuessedHand
from graspdsl.hands.todo import TODO
from graspdsl.spec.scene import GRAVITY

SLENDER = 2.2  # of its diameter, how tall a standing cylinder is
LOWEST = 0.08  # m it is taller than the tips are deep
ABOVE = 0.02  # m between table and hand, at the side of a cylinder
LIGHTEST, TIPPING = 0.3, 2.0  # kg, and how many times what tips the cylinder it is safe from
COLUMNS = 110  # of a comment
LEAST_GAP, PLAY = 0.004, 0.004  # m, of the standoff


def hand_text(guess: GuessedHand, name: str, key: str, model: str, root: str) -> str:
    """The hand file of a guess: ``name``; ``key``: urdf or mjcf; ``model``: how the file names it; root: the link that
    the hand begins with, empty for the model's own root."""
    return "\n".join([*_head(guess, name, key, model, root), *_joints(guess), *_contacts(guess), *_postures(guess), ""])


def _said(text: str) -> Iterator[str]:
    """A comment."""
    return (f"# {line}" for line in wrap(text, COLUMNS - 2))


def _head(guess: GuessedHand, name: str, key: str, model: str, root: str) -> Iterator[str]:
    file, count, face = model.rpartition("/")[2], len(guess.contacts), guess.face
    yield from _said(
        f"Guessed from {file} by graspdsl init hand. Change what is wrong: graspdsl validate tells what does not fit "
        "the model, graspdsl view --hand shows the hand open and closed."
    )
    yield f"hand: {yaml_name(name)}"
    yield f"about: {yaml_text(f'{count} fingers, guessed from {file}.')}"
    yield f"{key}: {yaml_text(model)}"
    if root:
        yield from _said("All fingers begin at this link; the joints before it carry the hand and are left out.")
        yield f"root: {yaml_name(root)}"
    yield f"palm: {yaml_name(guess.palm)}"
    yield from _said(
        "Out of the palm, in the frame of the root: from the bases of the fingers to where their tips meet, across how "
        "these close."
    )
    yield f"palm_normal: {_numbers(face.ahead)}"
    yield from _said("Across how they close: along the axis of an object that is grasped from the side.")
    yield f"palm_across: {_numbers(face.rotation[:, 0])}"
    yield from _said(
        "On the line along the palm's normal that the tips meet on, behind all of the palm: there a mount carries it."
    )
    yield f"palm_centre: {_numbers(face.place)}"
    if face.palm_surface is None:
        yield f"palm_surface: {yaml_text(f'{TODO}: m from palm_centre along palm_normal; the palm has no geometry')}"
    else:
        yield from _said("How far ahead of that the palm reaches, near the line.")
        yield f"palm_surface: {max(face.palm_surface, 0.0):.4g}"


def _joints(guess: GuessedHand) -> Iterator[str]:
    yield from _said(
        "In command order. weight: one over the lever at the fingertip that the joint moves most. closes: which way it "
        "brings opposing fingertips together; joints that do not flex a finger, as its last one does, have none."
    )
    yield "joints:"
    for name, joint in guess.joints.items():
        closes = f", closes: {joint.closes}" if joint.closes else ""
        lever = f"lever {1000 * joint.lever:.0f} mm" if joint.turns else "a slide"
        yield f"  {yaml_name(name)}: {{weight: {joint.weight:g}{closes}}} # {lever}"
    if guess.couplings:
        yield from _said("As the model couples them.")
        yield "couplings:"
        for name, (leader, ratio, offset) in guess.couplings.items():
            shifted = f", offset: {offset:.9g}" if offset else ""
            yield f"  {yaml_name(name)}: {{follows: {yaml_name(leader)}, ratio: {ratio:.9g}{shifted}}}"


def _contacts(guess: GuessedHand) -> Iterator[str]:
    yield from _said(f"{next(iter(guess.contacts))} first: it is farthest from the others, and opposes them.")
    if any(not contact.cell for contact in guess.contacts.values()):
        yield from _said(
            "onto: the fingertip is put on that link, in place of what of it touches, with a load cell between them: "
            "the model has none."
        )
    yield "contacts:"
    for name, contact in guess.contacts.items():
        yield from _contact(name, contact)
    yield "joint_sets:"
    closers = [name for name, joint in guess.joints.items() if joint.closes]
    yield f"  flexion: [{', '.join(map(yaml_name, closers))}]"


def _contact(name: str, contact: GuessedContact) -> Iterator[str]:
    tip, finger = contact.tip, contact.finger
    if tip.exact:
        yield "  # The very solid of the model."
    else:
        yield (
            f"  # {tip.kind.capitalize()} for the end of the link where that meets an object: off by "
            f"{1000 * tip.error:.1f} mm in the mean, {1000 * tip.worst:.1f} mm at the most."
        )
    yield f"  {name}:"
    yield f"    {'link' if contact.cell else 'onto'}: {yaml_name(finger.host)}"
    if contact.cell:
        yield f"    cell: {yaml_name(contact.cell)}"
    yield f"    {tip.kind}: {_shape(tip.shape)}"
    yield f"    finger: [{', '.join(map(yaml_name, contact.closers))}]"


def _shape(shape: FingertipShape) -> str:
    centre = f"centre: {_numbers(np.array(shape.centre))}"
    match shape:
        case SphereTip():
            return f"{{{centre}, radius: {shape.radius:g}}}"
        case CapsuleTip():
            axis = _numbers(np.array(shape.axis))
            return f"{{{centre}, radius: {shape.radius:g}, length: {shape.length:g}, axis: {axis}}}"
        case EllipsoidTip():
            axes = f"semi_axes: {_numbers(np.array(shape.semi_axes))}"
            return f"{{{centre}, {axes}, rpy: {_numbers(np.array(shape.rpy))}}}"


def _postures(guess: GuessedHand) -> Iterator[str]:
    yield from _said(
        "Fingers close along the line between the two. On it opposing tips meet with all flexing joints about half "
        "bent; joints that do not close stand where tips oppose best. "
        f"Open, the tips are {1000 * guess.opening:.0f} mm apart."
    )
    yield "postures:"
    yield f"  open: {_posture({name: joint.opened for name, joint in guess.joints.items()})}"
    yield f"  closed: {_posture({name: joint.closed for name, joint in guess.joints.items()})}"


def _posture(places: Mapping[str, float]) -> str:
    return f"{{{', '.join(f'{yaml_name(name)}: {place + 0.0:.6g}' for name, place in places.items())}}}"


def _numbers(numbers: Array) -> str:
    return f"[{', '.join(f'{_number(float(number))}' for number in numbers)}]"


def _number(number: float) -> str:
    """A number without an exponent, which not every reader of YAML takes for one."""
    return f"{round(number, 5) + 0.0:.5f}".rstrip("0").rstrip(".")


def spec_text(guess: GuessedHand, name: str, hand: str, world: str) -> str:
    """A spec that grasps a standing cylinder of a width that suits the hand; ``hand``: how it names the hand file."""
    grasp = guess.grasp
    way = "the side" if grasp.side else "above"
    contacts = list(guess.contacts)
    near, far = max(grasp.standoff - PLAY, LEAST_GAP), max(grasp.standoff + PLAY, LEAST_GAP + 2 * PLAY)
    standoff = f"standoff: {{uniform: [{near:.3f}, {far:.3f}]}}"
    if grasp.side:
        beside, tips = grasp.beside
        height = beside + tips + 2.0 * ABOVE
        start = ["roll: {uniform: [-0.1, 0.1]}", f"height: {beside + ABOVE:.3f}", standoff]
    else:
        height = max(SLENDER * grasp.width, grasp.deep + LOWEST)
        start = [standoff]
    pressed = beside + ABOVE if grasp.side else height - grasp.deep
    mass = max(LIGHTEST, math.ceil(10.0 * TIPPING * PRESS * pressed / (GRAVITY * grasp.width / 2.0)) / 10.0)
    return FirstSpec(
        name,
        f"{listed(contacts)} on a standing cylinder, from {way}.",
        [
            f"world: {world}",
            f"hand: {yaml_text(hand)}",
            f"# As wide as lets the links behind the fingertips keep {1000 * grasp.room:.0f} mm off it.",
            f"# So heavy that the first fingertip to touch, {1000 * pressed:.0f} mm above the table, does not tip it.",
            f"object: {{cylinder: {{diameter: {grasp.width:.3f}, height: {height:.3f}}}, mass: {mass:.1f}}}",
            "friction: 0.6",
        ],
        contacts,
        grasp.side,
        GRASP,
        ("force-closure", "lift"),
        8,
        [
            f"approach: {'side' if grasp.side else 'top'}",
            *start,
            "yaw: {uniform: [-3.14, 3.14]}",
            "offset: {uniform: [-0.005, 0.005]}",
            *([] if grasp.side else ["tilt: {uniform: [-0.1, 0.1]}"]),
        ],
    ).text()
