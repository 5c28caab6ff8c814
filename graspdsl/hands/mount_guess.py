"""A mount file guessed from the model of an arm: what carries the hand, where it stands, how its joints are scaled."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.angles import roll_pitch_yaw
from graspdsl.arrays import Array
from graspdsl.diagnostics import listed, on_one_line
from graspdsl.hands.arm_reach import ArmReach
from graspdsl.hands.descriptions import Joint, Mount, Pose, Robot, hands
from graspdsl.hands.mount_levers import BARE, SHARE, weighed
from graspdsl.hands.mount_model import carrying, frame_of
from graspdsl.hands.todo import TODO
from graspdsl.models.joint_kinds import FIXED, HINGES
from graspdsl.models.model import HERE, Frame, Model

FEWEST = 3  # joints of an arm: where fewer come before a fork, that is no hand but several arms
ALONG = 1e-3  # (1): how far an axis may be off another that it counts as
WORKPLACE = 0.15  # m above the table: where palms begin
DISTANCES = (0.3, 0.4, 0.5, 0.6, 0.7)  # m from the base to the object
NEAR = 0.01  # m
AHEAD = 0.2  # m that a face is from the middle of the object, with a hand between the two


@dataclass(frozen=True, slots=True)
class GuessedMount:
    """What a mount file says of an arm; where nothing carries a hand for sure, ``ends`` alone are known."""

    model: Model
    ends: tuple[str, ...] = ()
    face: str = ""
    face_at: Frame | None = None
    cut: tuple[str, ...] = ()
    still: Mapping[str, float] | None = None
    joints: Mapping[str, Joint] | None = None
    base: Array | None = None


def guessed_mount(model: Model, face: str = "") -> GuessedMount:
    """The mount that a model makes; ``face``: the link that the hand is fixed to, where that is known."""
    chain = model.movers(face) if face else _serial(model)
    moving = [name for name in chain if model.joints[name].kind in HINGES]
    if not face and len(moving) < FEWEST:
        parents = {joint.parent for joint in model.joints.values()}
        return GuessedMount(model, tuple(link for link in model.links if link not in parents))
    at = None if face or not moving else _face(model, moving)
    if at is not None:
        face, at_frame = at
    else:
        face, at_frame = face or model.joints[chain[-1]].child, None
    beyond = model.below(face) - {face}
    still = {
        name: min(max(0.0, low), high)
        for name, joint in model.joints.items()
        if joint.kind in HINGES and name not in moving and joint.child not in beyond
        for low, high in [joint.limits or (0.0, 0.0)]
    }
    cut = tuple(link for link in model.links if link in beyond and model.links[link].solids)
    mount = Mount(
        mount="guessed",
        about="",
        urdf="-",
        mjcf="",
        face=face,
        face_at=None if at_frame is None else _pose(at_frame),
        still=still,
        joints=dict.fromkeys(moving, Joint(weight=1.0, closes=0)),
    )
    whole = carrying(mount, model)
    joints = weighed(whole) if moving else {}
    whole = whole.model_copy(update={"joints": joints})
    return GuessedMount(model, (), face, at_frame, cut, still, joints, _base(whole) if moving else None)


def _serial(model: Model) -> tuple[str, ...]:
    """The joints from the root as far as the model moves as one chain."""
    moves = {name for name, joint in model.joints.items() if joint.kind in HINGES}
    link, chain = model.root, list[str]()
    while True:
        ways = [
            name
            for name, joint in model.joints.items()
            if joint.parent == link
            and any(other in moves for other, inner in model.joints.items() if inner.child in model.below(joint.child))
        ]
        if len(ways) != 1:
            return tuple(chain)
        chain += ways
        link = model.joints[ways[0]].child


def _face(model: Model, moving: Sequence[str]) -> tuple[str, Frame | None]:
    """The link of the face behind the last of an arm's joints, or one and the pose on it.

    It is a frame of the model without geometry, z along the axis of the joint, else where the link ends along that.
    """
    joint = model.joints[moving[-1]]
    link = joint.child
    frames, waiting = dict[str, Frame](), [(link, HERE)]
    while waiting:
        at, frame = waiting.pop()
        for inner in model.joints.values():
            if inner.parent == at and inner.kind == FIXED and not model.links[inner.child].solids:
                frames[inner.child] = frame.then(inner.frame)
                waiting.append((inner.child, frames[inner.child]))
    out = _outwards(model, link, joint.axis, model.joints[moving[-2]].child)
    good = {name: frame for name, frame in frames.items() if frame.rotation[:, 2] @ out > 1.0 - ALONG}
    if good:
        return max(good, key=lambda name: float(good[name].place @ out)), None
    end = max([0.0, *(float(solid.reach(out[None])[0]) for solid in model.links[link].solids)])
    if end < NEAR and out[2] > 1.0 - ALONG:
        return link, None
    return link, Frame(end * out, _turned_to(out))


def _outwards(model: Model, link: str, axis: Array, before: str) -> Array:
    """Which way along an axis a link goes on: away from the link of the joint before, or where most of it is."""
    here = frame_of(model, link).inverse()
    away = -float(here.then(frame_of(model, before)).place @ axis)
    if abs(away) > NEAR:
        return axis if away > 0.0 else -axis
    places = [float(here.then(frame_of(model, other)).place @ axis) for other in model.below(link)]
    reach = [solid.reach(np.stack([axis, -axis])).tolist() for solid in model.links[link].solids]
    ahead = max(*places, *(first for first, _ in reach), 0.0)
    behind = max(*(-place for place in places), *(second for _, second in reach), 0.0)
    return axis if ahead >= behind else -axis


def _turned_to(out: Array) -> Array:
    """A rotation (3, 3) with z along a direction, x as near to that of the frame as it can be."""
    first = np.eye(3)[0] if abs(out[0]) < 0.9 else np.eye(3)[1]
    x = first - (first @ out) * out
    x /= np.linalg.norm(x)
    return np.column_stack([x, np.cross(out, x), out])


def _base(mount: Mount) -> Array | None:
    """Where the arm stands (3,) [m] before the object: from there it holds a hand most freely to its side and above it;
    None where it reaches from nowhere."""
    best: tuple[float, float] = (0.0, 0.0)
    side = np.column_stack([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [1.0, 0.0, 0.0]])
    top = np.column_stack([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    wanted = (
        (np.array([-AHEAD, 0.0, WORKPLACE]), side),
        (np.array([0.0, 0.0, WORKPLACE + AHEAD]), top),
    )
    for distance in DISTANCES:
        standing = mount.model_copy(update={"base": Pose(position=(-distance, 0.0, 0.0))})
        reach = ArmReach(Robot(hand=hands()[BARE], mount=standing))
        found = [reach.postures(place, rotation) for place, rotation in wanted]
        free = min(float(reach.dexterity(postures[0])) if len(postures) else 0.0 for postures in found)
        best = max(best, (free, -distance))
    return np.array([best[1], 0.0, 0.0]) if best[0] > 0.0 else None


def mount_text(guess: GuessedMount, name: str, key: str, model: str) -> str:
    """The mount file of a guess: ``name``; ``key``: urdf or mjcf; ``model``: how the file names it."""
    return "\n".join([*_lines(guess, name, key, model), ""])


def _lines(guess: GuessedMount, name: str, key: str, model: str) -> Iterator[str]:
    file = on_one_line(model.rpartition("/")[2])
    yield f"# Guessed from {file} by graspdsl init mount. What is wrong here can be changed: graspdsl validate"
    yield "# tells what does not fit the model."
    yield f"mount: {_quoted(name)}"
    yield f"about: {_quoted(f'an arm, guessed from {file}')}"
    yield f"{key}: {_quoted(model)}"
    if guess.joints is None:
        yield "# The model is no single chain: no link of it carries the hand for sure."
        ends = listed(guess.ends[:8], "or")
        yield f"face: {_quoted(f'{TODO}: the link that carries the hand, such as {ends}')}"
        return
    if guess.face_at is None:
        yield "# The last link that moves, or a frame on it, whose z axis is that of its joint, away from the arm."
    else:
        yield "# The last link that moves; the model has no frame for a tool on it, z out of it."
    yield f"face: {_quoted(guess.face)}"
    if guess.face_at is not None:
        place, angles = _pose(guess.face_at).position, _pose(guess.face_at).rpy
        yield "# Where that link ends along the axis of its joint, z away from the arm."
        yield f"face_at: {{position: {_numbers(place)}, rpy: {_numbers(angles)}}}"
    if guess.cut:
        yield f"# What hangs on the face is left out, for the hand takes its place: {listed(guess.cut[:5])}."
    if guess.base is None:
        yield "# From no place before the object does the arm reach to its side and above it, standing upright."
        yield f"base: {_quoted(f'{TODO}: where the root stands: {{position: [x, y, z], rpy: [roll, pitch, yaw]}}')}"
    else:
        yield "# The root upright on the table, x towards the object at the origin, as far from it as leaves the arm"
        yield "# most freedom to hold a hand beside it and above it."
        yield f"base: {{position: {_numbers(guess.base)}, rpy: [0.0, 0.0, 0.0]}}"
    yield f"# In command order. weight: {SHARE:g} over the mean lever of a grasp about the joint, over its range."
    yield "joints:"
    for joint, said in guess.joints.items():
        yield f"  {_quoted(joint)}: {{weight: {said.weight:g}}}"
    if guess.still:
        yield "# These do not move the hand, and keep still."
        places = ", ".join(f"{_quoted(joint)}: {place:g}" for joint, place in guess.still.items())
        yield f"still: {{{places}}}"
    yield "joint_sets:"
    yield f"  arm: [{', '.join(map(_quoted, guess.joints))}]"


def _pose(frame: Frame) -> Pose:
    x, y, z = (round(float(number), 6) + 0.0 for number in frame.place)
    roll, pitch, yaw = (round(angle, 9) + 0.0 for angle in roll_pitch_yaw(frame.rotation))
    return Pose(position=(x, y, z), rpy=(roll, pitch, yaw))


def _numbers(numbers: Array | tuple[float, ...]) -> str:
    return f"[{', '.join(repr(float(number)) for number in numbers)}]"


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
