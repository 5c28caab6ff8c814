"""Fingertips that a hand file puts on links of its model: each behind a load cell of its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from graspdsl.hands.descriptions import Hand
from graspdsl.models.joint_kinds import FIXED
from graspdsl.models.model import HERE, Joint, Link, Model

SHARE = 0.01  # of the mass of a link, for the fingertip on it
RADIUS = 0.005  # m, of gyration of a fingertip


def put_on(hand: Hand, model: Model) -> tuple[Hand, Model]:
    """A hand and its model, whose fingertips that are put ``onto`` a link are links of their own.

    Such a fingertip is fixed to its link by a joint that is its load cell, and has a small share of the link's mass.
    What of the link touches gives way to it: the declared shape stands for that.
    """
    links, joints, contacts = dict(model.links), dict(model.joints), dict(hand.contacts)
    for name, contact in hand.contacts.items():
        if not contact.onto:
            continue
        host = links[contact.onto]
        drawn = any(solid.seen for solid in host.solids)
        solids = tuple(replace(solid, touches=False, seen=solid.seen or not drawn) for solid in host.solids)
        mass = SHARE * host.mass
        links[contact.onto] = replace(host, mass=host.mass - mass, solids=solids)
        tip, cell = f"{name}:tip", f"{name}:cell"
        centre = np.array(contact.shape.centre)
        links[tip] = Link(mass, centre, mass * RADIUS**2 * np.eye(3), (), host.where)
        joints[cell] = Joint(FIXED, contact.onto, tip, HERE, np.zeros(3), None, 0.0, 0.0, 0.0, host.where)
        contacts[name] = contact.model_copy(update={"onto": "", "link": tip, "cell": cell})
    return hand.model_copy(update={"contacts": contacts}), replace(model, links=links, joints=joints)
