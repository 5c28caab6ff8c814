"""A hand file held against its model: every fault and warning with its place."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from pydantic_core import PydanticCustomError

from graspdsl.diagnostics import Diagnostic, Severity, known_names_hint, likely, listed
from graspdsl.hands.completion import finger_of, open_and_closed
from graspdsl.hands.descriptions import ALL, MOUNTING, Contact, Coupling, Hand
from graspdsl.hands.fitted import ROUNDING, coupled_range, is_slightly_beyond
from graspdsl.models.joint_kinds import CONTINUOUS, FIXED, HINGES
from graspdsl.models.model import Model
from graspdsl.places.document import Document, Path
from graspdsl.places.wording import shortened
from graspdsl.spec.models import folder_name


def faults(hand: Hand, model: Model, document: Document) -> list[Diagnostic]:
    """What a hand file says that its model does not bear out, and warnings of what is passed over."""
    check = _Check(hand, model, document)
    return [
        *check.names(),
        *check.links(),
        *check.joints(),
        *check.couplings(),
        *check.contacts(),
        *check.motions(),
        *check.joint_sets(),
        *check.postures(),
    ]


class _Check:
    def __init__(self, hand: Hand, model: Model, document: Document) -> None:
        self._hand, self._model, self._document = hand, model, document

    def names(self) -> Iterator[Diagnostic]:
        """Names of the hand's own, which stand in formulas and on pages, and those that every robot has already."""
        own: dict[Path, Collection[str]] = {
            ("contacts",): self._hand.contacts,
            ("joint_sets",): self._hand.joint_sets,
            ("postures",): self._hand.postures,
        }
        for path, names in own.items():
            for name in names:
                try:
                    folder_name(name)
                except PydanticCustomError as error:
                    context = error.context or {}
                    yield self._error(error.type, context["message"], (*path, name), context["hint"], key=True)
        if MOUNTING in self._model.joints:
            message = f"the joint {MOUNTING} of the model has the name of the joint between mount and hand"
            key = "mjcf" if self._hand.mjcf else "urdf"
            yield self._error("name-taken", message, (key,), "rename it in the model")
        others = {**dict.fromkeys(self._model.joints, "a joint"), ALL: "the set of all joints"}
        for name in self._hand.joint_sets:
            if name in others:
                message = f"the joint set {name} has the name of {others[name]}"
                yield self._error("name-taken", message, ("joint_sets", name), "give it another name", key=True)
        for name in sorted({*self._hand.joints} & {ALL}):
            message = f"the joint {name} has the name of the set of all joints"
            yield self._error("name-taken", message, ("joints", name), "rename it in the model", key=True)

    def links(self) -> Iterator[Diagnostic]:
        for key, link in (("root", self._hand.root), ("palm", self._hand.palm)):
            if link and link not in self._model.links:
                yield self._unknown("link", link, (key,), self._model.links)

    def joints(self) -> Iterator[Diagnostic]:
        movable = {name for name, joint in self._model.joints.items() if joint.kind in HINGES}
        for name in self._hand.joints:
            yield from self._movable(name, ("joints", name), movable)
            yield from self._passed_over(name)
        spoken_for = {*self._hand.joints, *self._hand.couplings}
        # A name that is not there is most likely one of those left out, misspelt.
        for name in sorted(movable - spoken_for) if spoken_for <= {*self._model.joints} else ():
            message = f"the joint {name} of the model moves, but is neither among the joints nor coupled to one"
            yield self._error(
                "joint-left-out", message, ("joints",), "list it, couple it, or make it fixed in the model"
            )

    def _passed_over(self, name: str) -> Iterator[Diagnostic]:
        """A driven joint goes where it is told, whatever joint it mimics in the model."""
        joint = self._model.joints.get(name)
        if joint is not None and joint.mimic is not None:
            leader, ratio = shortened(joint.mimic.joint), joint.mimic.multiplier
            message = f"in the model {name} mimics {leader}: that is passed over, for it is driven here"
            hint = f"to couple it, write under couplings: {name}: {{follows: {leader}, ratio: {ratio:g}}}"
            span = self._document.key_span(("joints", name))
            yield Diagnostic("mimic-passed-over", message, span=span, hint=hint, severity=Severity.WARNING)

    def _movable(self, name: str, path: Path, movable: Collection[str], coupled: bool = False) -> Iterator[Diagnostic]:
        joint = self._model.joints.get(name)
        if joint is None:
            yield self._unknown("joint", name, path, movable, key=True)
        elif joint.kind not in HINGES:
            locked = "" if joint.limits is None else f", for its limits are both {joint.limits[0]:g},"
            message = f"the joint {name} is {joint.kind} in the model{locked} and cannot be driven"
            yield self._error("joint-not-movable", message, path, "only revolute and prismatic joints move", key=True)
        elif joint.limits is None and not (coupled and joint.kind == CONTINUOUS):
            message = f"the joint {name} has no limits in the model"
            yield self._error("joint-without-limits", message, path, "make it revolute, with a <limit>", key=True)

    def couplings(self) -> Iterator[Diagnostic]:
        movable = {name for name, joint in self._model.joints.items() if joint.kind in HINGES}
        for name, coupling in self._hand.couplings.items():
            path: Path = ("couplings", name)
            yield from self._movable(name, path, movable, coupled=True)
            if name in self._hand.joints:
                message = f"{name} is driven and coupled at once"
                yield self._error("driven-and-coupled", message, path, "leave it out of one of the two", key=True)
            if coupling.follows in self._hand.couplings:
                message = f"{name} follows {coupling.follows}, which itself follows another joint"
                yield self._error("wrong-coupling", message, (*path, "follows"), "follow a driven joint")
            elif coupling.follows not in self._hand.joints:
                yield self._unknown("joint", coupling.follows, (*path, "follows"), self._hand.joints)
            elif coupling.ratio == 0.0:
                yield self._error("wrong-coupling", f"{name} never moves: its ratio is 0", (*path, "ratio"), None)
            else:
                yield from self._coupled_range(name, coupling)
                yield from self._mimicked(name, coupling)

    def _coupled_range(self, name: str, coupling: Coupling) -> Iterator[Diagnostic]:
        led, leader = self._limits(name), coupling.follows
        if led is None or self._limits(leader) is None:
            return
        low, high = coupled_range(self._model, name, coupling) or led
        if led[0] - ROUNDING <= low and high <= led[1] + ROUNDING:
            return
        message = f"{name} would move from {low:g} to {high:g}, beyond its limits {led[0]:g} to {led[1]:g}"
        path: Path = ("couplings", name, "ratio")
        if is_slightly_beyond(self._model.joints[name], low, high):
            span = self._document.span(path)
            message, hint = f"{message}: {leader} goes only as far as these let it", f"narrow the limits of {leader}"
            yield Diagnostic("clipped-range", message, span=span, hint=hint, severity=Severity.WARNING)
        elif self._model.origin_of_motion(name).joint == self._model.origin_of_motion(leader).joint:
            # ROS passes over the limits of a joint that mimics another.
            message, span = f"{message}, which are passed over: so the model couples it", self._document.span(path)
            yield Diagnostic("mimic-beyond-limits", message, span=span, severity=Severity.WARNING)
        else:
            yield self._error("wrong-coupling", message, path, f"narrow the limits of {leader}")

    def _mimicked(self, name: str, coupling: Coupling) -> Iterator[Diagnostic]:
        """What the model says by <mimic> and the hand file by a coupling must be the same."""
        own = self._model.origin_of_motion(name)
        leading = self._model.origin_of_motion(coupling.follows)
        path: Path = ("couplings", name)
        if own.joint != leading.joint:
            if own.joint != name:
                message = f"{name} mimics {shortened(own.joint)} in the model, and follows {coupling.follows} here"
                yield self._error("wrong-coupling", message, (*path, "follows"), "let both say the same")
            return
        if abs(own.multiplier - coupling.ratio * leading.multiplier) > SAME * abs(own.multiplier):
            ratio = f"{own.multiplier / leading.multiplier:.4g}" if leading.multiplier else "no number of"
            message = f"by the model {name} is {ratio} times {coupling.follows}, found {coupling.ratio:g}"
            yield self._error("wrong-coupling", message, (*path, "ratio"), "let both say the same")
        offset = own.offset - coupling.ratio * leading.offset
        if abs(offset - coupling.offset) > ROUNDING:
            message = f"by the model {name} is at {offset:g} where {coupling.follows} is 0, found {coupling.offset:g}"
            yield self._error("wrong-coupling", message, (*path, "offset"), f"write offset: {offset:g}")

    def contacts(self) -> Iterator[Diagnostic]:
        for name, contact in self._hand.contacts.items():
            path: Path = ("contacts", name)
            if not contact.host:
                message = f"the contact {name} has no link"
                yield self._error("missing-key", message, path, "name its link and its shape", key=True)
                continue
            yield from self._finger(contact, (*path, "finger"))
            if contact.host not in self._model.links:
                key = "link" if contact.link else "onto"
                yield self._unknown("link", contact.host, (*path, key), self._model.links)
            elif contact.cell:
                yield from self._cell(contact.cell, contact.link, (*path, "cell"))

    def _finger(self, contact: Contact, path: Path) -> Iterator[Diagnostic]:
        movers = self._model.movers(contact.host)
        coupled = {self._hand.couplings[name].follows for name in movers if name in self._hand.couplings}
        moving = [name for name in self._hand.joints if name in movers or name in coupled]
        yield from self._joint_list(contact.finger, path)
        for place, joint in enumerate(contact.finger):
            known = joint in self._model.joints and contact.host in self._model.links
            if known and joint in self._hand.joints and joint not in moving:
                message = f"the joint {joint} does not move {contact.host}"
                hint = f"joints that do: {', '.join(moving)}" if moving else "name another link or another joint"
                yield self._error("wrong-finger", message, (*path, place), hint)

    def _joint_list(self, joints: Sequence[str], path: Path) -> Iterator[Diagnostic]:
        for place, joint in enumerate(joints):
            if joint not in self._hand.joints:
                yield self._unknown("joint", joint, (*path, place), self._hand.joints)
            elif joint in joints[:place]:
                yield self._error(
                    "declared-twice", f"{joint} stands twice in this list", (*path, place), "keep one of them"
                )

    def _cell(self, name: str, link: str, path: Path) -> Iterator[Diagnostic]:
        cell = self._model.joints.get(name)
        fixed = [joint for joint, found in self._model.joints.items() if found.kind == FIXED]
        if cell is None:
            yield self._unknown("joint", name, path, fixed)
        elif cell.kind != FIXED or cell.child != link:
            message = f"{name} is no load cell of {link}: it is a {cell.kind} joint before {cell.child}"
            before = [
                joint for joint, found in self._model.joints.items() if found.kind == FIXED and found.child == link
            ]
            hint = f"use {before[0]}" if before else f"put a fixed joint before {link} in the model"
            yield self._error("wrong-load-cell", message, path, hint)

    def motions(self) -> Iterator[Diagnostic]:
        """A finger closes from open to closed until its tip touches."""
        opened, closed = open_and_closed(self._hand, self._model)
        for name, contact in self._hand.contacts.items():
            finger = finger_of(contact, self._hand, self._model)
            known = [joint for joint in finger if self._limits(joint) is not None and joint in self._hand.joints]
            if contact.host not in self._model.links or len(known) < len(finger):
                continue
            if all(opened[joint] == closed[joint] for joint in known):
                where = (
                    f"{listed(known)} stay where they are from open to closed" if known else "no driven joint moves it"
                )
                message = f"the fingertip {name} cannot close: {where}"
                hint = "say which way its joints close, by closes: 1 or closes: -1, or let the two postures differ"
                yield self._error("never-closes", message, ("contacts", name), hint, key=True)
        stated = self._hand.postures.get("open", {}).keys() & self._hand.postures.get("closed", {}).keys()
        for joint, said in self._hand.joints.items():
            first, last = opened[joint], closed[joint]
            if joint in stated and said.closes * (last - first) < 0.0:
                message = f"{joint} has closes: {said.closes}, but goes from {first:g} open to {last:g} closed"
                hint = f"write closes: {-said.closes}, or mend the postures"
                yield self._error("wrong-closing", message, ("joints", joint), hint, key=True)

    def joint_sets(self) -> Iterator[Diagnostic]:
        for name, joints in self._hand.joint_sets.items():
            yield from self._joint_list(joints, ("joint_sets", name))

    def postures(self) -> Iterator[Diagnostic]:
        for posture, joints in self._hand.postures.items():
            for name, place in joints.items():
                path: Path = ("postures", posture, name)
                limits = self._limits(name)
                if name not in self._hand.joints:
                    yield self._unknown("joint", name, path, self._hand.joints, key=True)
                elif limits is not None and not limits[0] - ROUNDING <= place <= limits[1] + ROUNDING:
                    message = f"{name} moves from {limits[0]:g} to {limits[1]:g}, found {place:g}"
                    yield self._error("out-of-range", message, path, "keep within the limits of the joint")

    def _limits(self, name: str) -> tuple[float, float] | None:
        joint = self._model.joints.get(name)
        return None if joint is None or joint.kind not in HINGES else joint.limits

    def _unknown(self, what: str, name: str, path: Path, known: Collection[str], key: bool = False) -> Diagnostic:
        hint = known_names_hint(name, known, f"{what}s")
        if what == "joint" and name in self._model.joints:
            return self._error("joint-not-driven", f"{name} is not among the driven joints", path, hint, key)
        found = self._error(f"unknown-{what}", f"there is no {what} {shortened(name)!r} in the model", path, hint, key)
        written = name == path[-1] if key else self._document.has(path) and name == self._document.get(path)
        return replace(found, fixes=likely(name, known, found.span) if written else ())

    def _error(self, code: str, message: str, path: Path, hint: str | None, key: bool = False) -> Diagnostic:
        span = self._document.key_span(path) if key else self._document.span(path)
        return Diagnostic(code, message, span=span, hint=hint)


SAME = 1e-3  # of a multiplier: files have few digits
