"""Declared fingertips held against the collision geometry of the model: the one is sensed with, the other looks so."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.diagnostics import Diagnostic, Severity, listed
from graspdsl.hands.completion import finger_of
from graspdsl.hands.descriptions import Contact, Hand
from graspdsl.hands.fingertips import directions_around, reach
from graspdsl.models.joint_kinds import FIXED, ROTATING
from graspdsl.models.model import Link, Model, Solid
from graspdsl.places.document import Document

DIRECTIONS = 4000  # about 3 degrees apart
EQUAL = 1e-6  # m, between two spheres or two capsules: files have few digits
# m, between a round shape and what stands for it, as facets do: a fingertip gives way by as much under 1 N.
ALIKE = 2.0 / 3.0 * 1e-3
STILL = 1e-9  # m per rad or m: no motion


def fingertip_complaints(hand: Hand, model: Model, document: Document) -> Iterator[Diagnostic]:
    """What of a hand's fingertips its model does not bear out.

    A declared shape reaches h(n) = max n · p over its points p along a unit vector n, and so does the collision
    geometry of its link: a flat or gently curved object with the normal −n touches there first. They must agree where
    the fingertip is to touch: in each direction n with n · v ≥ 0, where v is the way in which the closing joints of its
    finger move it, and in which it reaches beyond the link that it is fixed to, or away from the joint that moves it.
    Joints are where they are nearest to 0. A link without collision geometry is nothing to compare: worlds give it the
    declared shape.
    """
    check = _Check(model, document)
    known = {name: contact for name, contact in hand.contacts.items() if contact.link in model.links}
    yield from check.masses(known)
    for name, contact in known.items():
        yield from check.fingertip(name, contact, hand)


class _Check:
    def __init__(self, model: Model, document: Document) -> None:
        self._model, self._document = model, document

    def masses(self, contacts: dict[str, Contact]) -> Iterator[Diagnostic]:
        """One warning of all fingertips without mass."""
        light = [name for name, contact in contacts.items() if self._model.links[contact.link].mass == 0.0]
        if light:
            message = f"the model gives no mass to the fingertips {listed(light)}: they have no weight"
            hint = f"where that is not meant, give {contacts[light[0]].link} an <inertial> in the model"
            yield self._said("no-mass", message, ("contacts", light[0], "link"), hint, Severity.WARNING)

    def fingertip(self, name: str, contact: Contact, hand: Hand) -> Iterator[Diagnostic]:
        kind = "sphere" if contact.sphere else "capsule" if contact.capsule else "ellipsoid"
        path = ("contacts", name, kind)
        link = self._model.links[contact.link]
        ahead = self._ahead(contact, hand)
        declared = reach(contact.shape, ahead)
        outward, above = self._outward(contact, ahead, declared)
        if not outward.any():
            message = f"the {kind} of {name} reaches nowhere beyond {above} on the side to which its finger closes"
            hint = f"{above} would touch first: move the centre outwards, or make the {kind} larger"
            yield self._said("hidden-fingertip", message, path, hint, Severity.WARNING)
            outward[:] = True
        found = self._reach(link, ahead)
        if found is None:
            return
        apart = np.where(outward, np.abs(declared - found), 0.0)
        shapes = [solid.kind for solid in _touching(link)]
        worst = int(np.argmax(apart))
        if apart[worst] <= (EQUAL if shapes == [kind] else ALIKE):
            return
        from_centre = ahead[worst] @ np.array(contact.shape.centre)
        mine, theirs = (1e3 * (float(far[worst]) - from_centre) for far in (declared, found))
        direction = ", ".join(f"{component:.2f}" for component in ahead[worst])
        message = (
            f"the {kind} of {name} reaches {mine:.4g} mm from its centre along [{direction}] of {contact.link}, where "
            f"the collision geometry of the model reaches {theirs:.4g} mm"
        )
        yield self._said("other-fingertip", message, path, self._hint(link, contact.link))

    def _hint(self, link: Link, name: str) -> str:
        """The shape to declare where that is plain."""
        other = f"or name a link without collision geometry, fixed to {name}: it is given the declared shape"
        match _touching(link):
            case [Solid(kind="sphere", sizes=(radius,), frame=frame)]:
                x, y, z = frame.place.tolist()
                return f"declare sphere: {{centre: [{x:.6g}, {y:.6g}, {z:.6g}], radius: {radius:g}}}, {other}"
        return f"declare the shape that the model has, {other}"

    def _ahead(self, contact: Contact, hand: Hand) -> Array:
        """The directions (d, 3) in the frame of a fingertip that are not against the way in which it closes; all of
        one that does not."""
        motion, finger = np.zeros(3), finger_of(contact, hand, self._model)
        for name in self._model.movers(contact.link):
            coupling = hand.couplings.get(name)
            driven, ratio = (coupling.follows, coupling.ratio) if coupling else (name, 1.0)
            if driven not in finger or driven not in hand.joints:
                continue
            place, rotation = self._pose(contact.link, self._model.joints[name].child)
            axis = rotation @ self._model.joints[name].axis
            lever = np.array(contact.shape.centre) - place
            turns = self._model.joints[name].kind in ROTATING
            motion += hand.joints[driven].closes * ratio * (np.cross(axis, lever) if turns else axis)
        directions = directions_around(DIRECTIONS)
        return directions if np.linalg.norm(motion) < STILL else directions[directions @ motion >= 0.0]

    def _pose(self, link: str, other: str) -> tuple[Array, Array]:
        """The place (3,) and the rotation (3, 3) of another link, in the frame of a link that hangs on it."""
        place, rotation = np.zeros(3), np.eye(3)
        at = {joint.child: name for name, joint in self._model.joints.items()}
        while link != other:
            joint = self._model.joints[at[link]]
            low, high = joint.limits or (0.0, 0.0)
            moved, turned = joint.at(min(max(0.0, low), high))
            # What is at p in the frame of the child is at moved + turned p in that of its parent.
            place, rotation = place - rotation @ turned.T @ moved, rotation @ turned.T
            link = joint.parent
        return place, rotation

    def _outward(self, contact: Contact, ahead: Array, declared: Array) -> tuple[Flags, str]:
        """In which directions a fingertip reaches beyond the link that it is fixed to, and which that is.

        Where nothing that it is fixed to has collision geometry: those from the joint that moves it to its centre.
        """
        above = {joint.child: joint for joint in self._model.joints.values()}
        at = contact.link
        while at in above and above[at].kind == FIXED:
            at = above[at].parent
            place, rotation = self._pose(contact.link, at)
            far = self._reach(self._model.links[at], ahead @ rotation)
            if far is not None:
                return declared > far + ahead @ place, at
        return ahead @ (np.array(contact.shape.centre) - self._pose(contact.link, at)[0]) >= 0.0, at

    def _reach(self, link: Link, directions: Array) -> Array | None:
        """How far (d,) [m] the collision geometry of a link reaches along directions (d, 3), both in the link's frame;
        None where it has none."""
        found = [solid.reach(directions) for solid in _touching(link)]
        return np.max(found, axis=0) if found else None

    def _said(
        self, code: str, message: str, path: tuple[str, ...], hint: str, severity: Severity = Severity.ERROR
    ) -> Diagnostic:
        return Diagnostic(code, message, span=self._document.key_span(path), hint=hint, severity=severity)


def _touching(link: Link) -> list[Solid]:
    return [solid for solid in link.solids if solid.touches]
