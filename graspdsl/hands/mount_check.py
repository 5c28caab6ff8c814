"""A hand on a mount: names that both have, and that one robot may have once."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree import ElementTree

from graspdsl.diagnostics import Diagnostic
from graspdsl.hands.descriptions import Robot


def taken_names(robot: Robot) -> Iterator[Diagnostic]:
    """A complaint for each name of a link, a joint or a joint set of the hand that its mount has already."""
    if len(robot.models) < 2:
        return
    mount, hand = (_names(model) for model in robot.models)
    of = f"of the mount {robot.mount.mount}"
    hint = "rename it in the model of the hand, or use another mount"
    for what in ("link", "joint"):
        for name in sorted(hand[what] & mount[what]):
            message = f"the {what} {name} of the hand has the name of a {what} {of}"
            yield Diagnostic("name-taken", message, hint=hint)
    sets = {*robot.mount.joint_sets}
    for name in sorted({*robot.hand.joints} & sets):
        message = f"the joint {name} of the hand has the name of a joint set {of}"
        yield Diagnostic("name-taken", message, hint=hint)
    for name in sorted({*robot.hand.joint_sets} & (sets | mount["joint"])):
        message = f"the joint set {name} of the hand has the name of a joint or a joint set {of}"
        yield Diagnostic("name-taken", message, hint="give it another name, or use another mount")


def _names(model: str) -> dict[str, set[str]]:
    tree = ElementTree.fromstring(model)
    return {tag: {element.get("name", "") for element in tree.findall(tag)} for tag in ("link", "joint")}
