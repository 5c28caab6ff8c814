"""Which parts of a model are fingers: where its palm is, what their ends are, and which opposes the others."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.hands.guess_posture import PosedModel
from graspdsl.models.joint_kinds import ROTATING
from graspdsl.models.model import Frame

NARROWINGS = 6
SHALLOWEST = 0.005  # m
SHORTER = 0.85  # of the length of another finger that one joint drives too: a linkage beside it


@dataclass(frozen=True, slots=True)
class Finger:
    """A chain of joints from the palm to a last link with something that can touch.

    joints: those that move it, the first one first; base: where the first and the last of them are (2, 3) [m] in the
    frame of the root, all joints at ``neutral``; last: the links that move as one at its end; host: that of them which
    reaches farthest;
    along: the unit direction (3,), in the frame of the host, from the last joint to what reaches farthest; tip: the
    middle (3,) [m] of the part that does, there; flexor: the last joint, which flexes it.
    """

    joints: tuple[str, ...]
    base: Array
    last: tuple[str, ...]
    host: str
    along: Array
    tip: Array
    flexor: str


@dataclass(frozen=True, slots=True)
class Fingers:
    """The link that all fingers begin at, with those fixed to it, and the fingers, the opposing one first."""

    palm: str
    palm_links: tuple[str, ...]
    fingers: tuple[Finger, ...]


def fingers_of(posed: PosedModel, neutral: Array) -> Fingers:
    """The fingers of a model. Raises DiagnosticError for one with less than two."""
    model, frames = posed.model, posed.frames(neutral)
    inner = {posed.group(joint.parent) for name, joint in model.joints.items() if name in posed.followed}
    ends = [group for group in posed.groups if group not in inner and posed.chain(group)]
    solid = [end for end in ends if len(posed.points(posed.groups[end], frames))]
    fingers = [_finger(posed, end, frames) for end in solid]
    palm = _palm(posed, solid)
    kept = [finger for finger in fingers if not _is_linkage(posed, finger, fingers, frames, palm)]
    if len(kept) < 2:
        found = f"only {kept[0].host} does" if kept else "none does"
        message = f"the model has no two fingers: expected two links at the ends of chains of joints, {found}"
        hint = "fingers that are fixed, or of a model that is bent by tendons alone, have to be written by hand"
        raise DiagnosticError([Diagnostic("no-fingers", message, hint=hint)])
    return Fingers(palm, posed.groups[palm], _opposing_first(_trimmed(posed, kept, palm, frames), frames))


def _palm(posed: PosedModel, ends: Sequence[str]) -> str:
    """The last group that all ends hang on."""
    paths = [_path(posed, end) for end in ends]
    common = [group for group in paths[0] if all(group in path for path in paths)] if paths else [posed.model.root]
    return common[-1]


def _path(posed: PosedModel, end: str) -> list[str]:
    """The groups from the root to one."""
    groups = [posed.group(posed.model.joints[name].parent) for name in posed.chain(end)]
    return [*groups, posed.group(end)]


def _finger(posed: PosedModel, end: str, frames: dict[str, Frame]) -> Finger:
    model, chain, links = posed.model, posed.chain(end), posed.groups[end]
    flexor = model.joints[chain[-1]]
    at, axis = frames[flexor.child].place, frames[flexor.child].rotation @ flexor.axis
    points = posed.points(links, frames)
    ahead = points.mean(axis=0) - at
    if flexor.kind in ROTATING:
        across = ahead - (ahead @ axis) * axis
        ahead = across if np.linalg.norm(across) > 1e-3 else ahead
    along = ahead / max(float(np.linalg.norm(ahead)), 1e-9)
    host = max(links, key=lambda link: _farthest(posed.points([link], frames), along))
    own = posed.points([host], frames)
    tip = distal(own, along).mean(axis=0)
    into = frames[host].rotation.T
    first = model.joints[chain[0]]
    return Finger(
        chain,
        np.array([frames[first.child].place, at]),
        links,
        host,
        into @ along,
        into @ (tip - frames[host].place),
        chain[-1],
    )


def _farthest(points: Array, along: Array) -> float:
    return float((points @ along).max()) if len(points) else -np.inf


def distal(points: Array, along: Array) -> Array:
    """Those of points (p, 3) [m] that are as near to their end along a direction (3,) as the end is broad."""
    reach = points @ along
    aside = points - reach[:, None] * along
    end = reach >= np.median(reach)
    for _ in range(NARROWINGS):
        spread = aside[end] - aside[end].mean(axis=0)
        breadth = 2.0 * float(np.linalg.norm(spread, axis=1).max())
        narrower = reach >= reach.max() - max(breadth, SHALLOWEST)
        if narrower.sum() >= end.sum():
            break
        end = narrower
    return np.asarray(points[end])


def _is_linkage(
    posed: PosedModel, finger: Finger, fingers: Sequence[Finger], frames: dict[str, Frame], palm: str
) -> bool:
    """Whether one joint moves a finger together with a longer one beside it: a bar of its linkage."""
    tips = {other.host: _place(other, frames) for other in fingers}
    centre = frames[palm].place
    mine, widest = tips[finger.host], max(float(np.linalg.norm(a - b)) for a in tips.values() for b in tips.values())
    drivers = {posed.followed[joint][0] for joint in finger.joints}
    return any(
        other.host != finger.host
        and drivers <= {posed.followed[joint][0] for joint in other.joints}
        and np.linalg.norm(mine - centre) < SHORTER * np.linalg.norm(tips[other.host] - centre)
        and np.linalg.norm(mine - tips[other.host]) < widest / 2.0
        for other in fingers
    )


def _place(finger: Finger, frames: dict[str, Frame]) -> Array:
    return np.asarray(frames[finger.host].place + frames[finger.host].rotation @ finger.tip)


def _trimmed(posed: PosedModel, fingers: Sequence[Finger], palm: str, frames: dict[str, Frame]) -> tuple[Finger, ...]:
    """The fingers without the joints before the palm, which carry the hand."""
    before = set(posed.chain(palm))
    found = []
    for finger in fingers:
        own = tuple(joint for joint in finger.joints if joint not in before)
        base = np.array([frames[posed.model.joints[own[0]].child].place, finger.base[1]])
        found.append(Finger(own, base, finger.last, finger.host, finger.along, finger.tip, finger.flexor))
    return tuple(found)


def _opposing_first(fingers: Sequence[Finger], frames: dict[str, Frame]) -> tuple[Finger, ...]:
    """The finger first that is farthest from the nearest other, at its first joint, its last and its tip: the thumb,
    where there is one."""
    places = np.array([[*finger.base, _place(finger, frames)] for finger in fingers])
    apart = np.linalg.norm(places[:, None] - places[None], axis=-1) + np.diag(np.full(len(places), np.inf))[..., None]
    thumb = int(np.argmax(np.round(apart.min(axis=1).sum(axis=-1), 4)))
    return (fingers[thumb], *fingers[:thumb], *fingers[thumb + 1 :])
