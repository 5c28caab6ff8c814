"""How the links of a URDF hang together: one tree, every name once."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import chain, islice
from xml.etree import ElementTree

from graspdsl.diagnostics import Diagnostic, DiagnosticError, known_names_hint, listed
from graspdsl.models.source import MOST_FAULTS, place
from graspdsl.places.files import refusal
from graspdsl.places.wording import shortened

MOST_LINKS = 2000
LONGEST_NAME = 100  # characters


@dataclass(frozen=True, slots=True)
class TreeJoint:
    """A joint of the file: its kind and the links it joins."""

    element: ElementTree.Element
    kind: str
    parent: str
    child: str


@dataclass(frozen=True, slots=True)
class KinematicTree:
    """The links and joints of a robot by their names, the one link that has no parent, and the links below each."""

    links: Mapping[str, ElementTree.Element]
    joints: Mapping[str, TreeJoint]
    root: str
    _inside: Mapping[str, list[str]]

    @classmethod
    def of(cls, robot: ElementTree.Element, file: str) -> KinematicTree:
        """The tree of a URDF's <robot>. Raises DiagnosticError when its links and joints do not form one."""
        return _Reading(robot, file).tree()

    def below(self, root: str) -> frozenset[str]:
        """A link and all that hang on it."""
        return frozenset(_reached(root, self._inside))


def _reached(root: str, inside: Mapping[str, list[str]]) -> set[str]:
    found, waiting = {root}, [root]
    while waiting:
        for link in inside.get(waiting.pop(), ()):
            if link not in found:
                found.add(link)
                waiting.append(link)
    return found


class _Reading:
    def __init__(self, robot: ElementTree.Element, file: str) -> None:
        self._robot, self._file = robot, file

    def tree(self) -> KinematicTree:
        links, joints = self._robot.findall("link"), self._robot.findall("joint")
        if max(len(links), len(joints)) > MOST_LINKS:
            message = f"{self._file} has {max(len(links), len(joints))} links, where a model may have {MOST_LINKS}"
            raise refusal("too-many-links", message, "leave out what is no part of the hand")
        if not links:
            raise refusal("no-root", f"{self._file} has no links", "a hand has at least one")
        named = {link.get("name", ""): link for link in links}
        misnamed = list(self._names(links))
        # What joins a link of a wrong name is not known.
        loose = () if misnamed else (fault for joint in joints for fault in self._ends(joint, named))
        self._refuse(chain(misnamed, self._names(joints), loose))
        ends = {joint.get("name", ""): self._joint(joint) for joint in joints}
        self._refuse(self._parents(ends))
        inside: dict[str, list[str]] = {}
        for joint in ends.values():
            inside.setdefault(joint.parent, []).append(joint.child)
        children = {joint.child for joint in ends.values()}
        tops = [link for link in named if link not in children]
        self._refuse(self._one_tree(tops, named, ends, inside))
        return KinematicTree(named, ends, tops[0], inside)

    def _refuse(self, faults: Iterable[Diagnostic]) -> None:
        found = list(islice(faults, MOST_FAULTS))
        if found:
            raise DiagnosticError(found)

    def _names(self, elements: list[ElementTree.Element]) -> Iterator[Diagnostic]:
        seen: dict[str, ElementTree.Element] = {}
        for element in elements:
            name = element.get("name", "")
            if not name or len(name) > LONGEST_NAME or not name.isprintable() or name != name.strip():
                found = repr(shortened(name)) if name else "none"
                message = f"expected a name of up to {LONGEST_NAME} characters for a <{element.tag}>, found {found}"
                yield self._fault(element, "bad-name", message, f'for example <{element.tag} name="{element.tag}-1">')
            elif name in seen:
                message = f"there are two {element.tag}s {name!r}; the first is at {place(seen[name])}"
                yield self._fault(element, "declared-twice", message, "give each a name of its own")
            else:
                seen[name] = element

    def _ends(self, joint: ElementTree.Element, links: Mapping[str, ElementTree.Element]) -> Iterator[Diagnostic]:
        name = joint.get("name", "")
        for tag in ("parent", "child"):
            ends = joint.findall(tag)
            link = ends[0].get("link", "") if ends else ""
            if len(ends) != 1:
                message = f"the joint {name} has {len(ends)} <{tag}>, where it has one"
                yield self._fault(joint, "wrong-joint", message, f'write <{tag} link="…"/> once')
            elif link not in links:
                message = f"the {tag} of the joint {name} is {shortened(link)!r}, which is no link"
                yield self._fault(ends[0], "unknown-link", message, known_names_hint(link, links, "links"))

    def _joint(self, joint: ElementTree.Element) -> TreeJoint:
        parent, child = joint.find("parent"), joint.find("child")
        assert parent is not None
        assert child is not None
        return TreeJoint(joint, joint.get("type", ""), parent.get("link", ""), child.get("link", ""))

    def _parents(self, joints: Mapping[str, TreeJoint]) -> Iterator[Diagnostic]:
        before: dict[str, str] = {}
        for name, joint in joints.items():
            if joint.child in before:
                message = f"the link {joint.child} has two parents, by the joints {before[joint.child]} and {name}"
                yield self._fault(joint.element, "two-parents", message, "a link hangs on one joint")
            before.setdefault(joint.child, name)

    def _one_tree(
        self,
        tops: list[str],
        links: Mapping[str, ElementTree.Element],
        joints: Mapping[str, TreeJoint],
        inside: Mapping[str, list[str]],
    ) -> Iterator[Diagnostic]:
        reached = {link for top in tops for link in _reached(top, inside)}
        cycle = [joint for joint in joints.values() if joint.child not in reached]
        if cycle:
            names = listed([joint.child for joint in cycle][:5])
            message = f"the joints form a cycle: {names} hang on one another and on no root"
            yield self._fault(cycle[0].element, "joint-cycle", message, "let one joint have another child")
        elif len(tops) > 1:
            message = f"{len(tops)} links have no parent, where a robot has one: {', '.join(tops[:5])}"
            yield self._fault(links[tops[1]], "no-root", message, "join them, or leave out what is no part of the hand")

    def _fault(self, element: ElementTree.Element, code: str, message: str, hint: str) -> Diagnostic:
        return Diagnostic(code, f"{place(element)}: {message}", hint=hint)
