"""Which links of a robot never touch each other, for their models overlap where they are joined."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

from graspdsl.hands.descriptions import Robot

SPAN = 2  # joints between links that never touch: those of a Barrett hand overlap by up to 1.6 mm, also two links apart


def neighbours(tree: ET.Element, robot: Robot) -> Iterator[tuple[str, str]]:
    """The pairs of links of a robot's joined URDF that are near each other along it, or are not both of its hand.

    Links without collision geometry are not counted: several joints of one body are a chain of such links.
    """
    parents = {_end(joint, "child"): _end(joint, "parent") for joint in tree.iterfind("joint")}
    links = [link.get("name", "") for link in tree.iterfind("link")]
    bare = {link.get("name", "") for link in tree.iterfind("link") if link.find("collision") is None}
    beside: dict[str, set[str]] = {link: set() for link in links}
    for child, parent in parents.items():
        beside[child].add(parent)
        beside[parent].add(child)
    hand = set(links_of_hand(tree, robot))
    for number, link in enumerate(links):
        found, frontier = {link}, {link}
        for _ in range(SPAN):
            frontier = _next(frontier, beside) - found
            while through := frontier & bare:
                found |= through
                frontier = (frontier | _next(through, beside)) - found
            found |= frontier
        for other in links[number + 1 :]:
            if other in found or not {link, other} <= hand:
                yield link, other


def links_of_hand(tree: ET.Element, robot: Robot) -> list[str]:
    """The links of a robot's joined URDF that are its hand's."""
    found = [robot.hand.root]
    for link in found:
        found += [_end(joint, "child") for joint in tree.iterfind("joint") if _end(joint, "parent") == link]
    return found


def _next(links: set[str], beside: dict[str, set[str]]) -> set[str]:
    return set().union(*(beside[link] for link in links))


def _end(joint: ET.Element, tag: str) -> str:
    end = joint.find(tag)
    return "" if end is None else end.get("link", "")
