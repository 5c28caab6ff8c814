"""Names of resources → weights over the hand's contacts and gravity, or sets of joints."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from copy import copy
from dataclasses import dataclass, replace

from graspdsl.basis.resources import ContactResource, ContactSet, JointSet
from graspdsl.compiler.complaints import Complaints, span_of
from graspdsl.compiler.declarations import Declaration
from graspdsl.diagnostics import DiagnosticError, Span, known_names_hint, likely
from graspdsl.hands.descriptions import Robot
from graspdsl.notation.latex import plain
from graspdsl.notation.names import canonical
from graspdsl.notation.parser import defines, parse_resource_definition
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import Name, Resource, Resources, ResourceSet, Virtual
from graspdsl.places.document import Path

GRAVITY = "γ_g"


@dataclass(frozen=True, slots=True)
class _Declared:
    meaning: int | JointSet | Resources
    place: Span
    path: Path


@dataclass(frozen=True, slots=True)
class _Meant:
    """What a declared name stands for: a contact or virtual contact alone, a set of them, or a set of joints."""

    members: tuple[ContactResource, ...]
    is_set: bool
    joints: JointSet | None = None


class ResourceTable:
    """The resources that a spec declares over a robot's contacts.

    Each declaration is resolved once and its faults are reported there; what is made of a faulty one, or of one that
    is ``unread``, is passed over in silence, and so is what only a robot could tell where there is none.
    ``other_hand`` is the way out of a contact that the hand has not; where all is ``weightless``, γ_g is a fault.
    """

    def __init__(
        self,
        entries: Sequence[Declaration],
        robot: Robot | None,
        complaints: Complaints,
        *,
        senses_gravity: bool,
        weightless: bool = False,
        unread: Sequence[str] = (),
        other_hand: str | None = None,
    ) -> None:
        self._robot, self._complaints, self.senses_gravity = robot, complaints, senses_gravity
        self._weightless = weightless
        self._contacts = robot.contacts if robot else ()
        self._joint_sets = robot.joint_sets if robot else {}
        self._other_hand = other_hand
        self._declared: dict[str, _Declared] = {}
        self._meant: dict[str, _Meant | None] = dict.fromkeys(unread)
        self._open: list[str] = []
        for entry in entries:
            complaints.about(entry.path)
            self._declare(entry)
        for name, declared in self._declared.items():
            self._named(Name(name, declared.place))

    def _declare(self, entry: Declaration) -> None:
        name = canonical(entry.key.text)
        if name == GRAVITY:
            self._complaints.error(
                "reserved-name", "γ_g is gravity and cannot be declared", span_of(entry.key), "choose another name"
            )
        elif name in self._declared or name in self._meant:
            self._complaints.error(
                "declared-twice",
                f"{name} is declared twice, in two spellings",
                span_of(entry.key),
                "keep one of them",
            )
        else:
            meaning = self._meaning(entry)
            if meaning is None:
                self._meant[name] = None
            else:
                self._declared[name] = _Declared(meaning, span_of(entry.value), entry.path)

    def _meaning(self, entry: Declaration) -> int | JointSet | Resources | None:
        if entry.value.text in self._contacts:
            return self._contacts.index(entry.value.text)
        if entry.value.text in self._joint_sets:
            return self._joint_set(entry.value.text)
        if is_formula(entry.value.text):
            return self._written(entry)
        if self._robot is None:
            return None
        name, known = entry.value.text, [*self._contacts, *self._joint_sets]
        self._complaints.error(
            "unknown-contact",
            f"the hand {self._robot.hand.hand} has no contact and no joint set {name!r}",
            span_of(entry.value),
            self._other_hand or known_names_hint(name, known, "contacts and joint sets"),
            () if self._other_hand else likely(name, known, span_of(entry.value)),
        )
        return None

    def _written(self, entry: Declaration) -> Resources | None:
        """A resource that is written out, alone or as a definition of the name that it is declared by."""
        try:
            defined, meaning = parse_resource_definition(entry.value)
        except DiagnosticError as error:
            self._complaints.take(error)
            return None
        name = canonical(entry.key.text)
        if defined is not None and defined.text != name:
            message = f"the definition is of {defined.text}, its key is {name}"
            hint = f"let the key be {defined.text}, or leave out the left side here"
            self._complaints.error("other-head", message, defined.span, hint)
        return meaning

    def _joint_set(self, name: str) -> JointSet:
        order = list(self._robot.joints if self._robot else ())
        return JointSet(name, tuple(order.index(joint) for joint in self._joint_sets[name]), len(order))

    def with_unknown(self, names: Collection[str]) -> ResourceTable:
        """This table with names of which nothing is known, as are the parameters of a definition."""
        table = copy(self)
        table._meant = {**self._meant, **dict.fromkeys(names)}
        table._declared = {name: declared for name, declared in self._declared.items() if name not in names}
        return table

    @property
    def names(self) -> tuple[str, ...]:
        """The declared names."""
        return tuple(self._declared)

    def resolve(self, tree: Resources) -> ContactSet | None:
        """The set of contacts that a resource expression means; None after a complaint."""
        meant = self._meaning_of(tree)
        if meant is None:
            return None
        if meant.joints is not None:
            self._not_contacts(tree)
            return None
        return ContactSet(to_unicode(tree), meant.members, len(self._contacts))

    def _not_contacts(self, tree: Resources) -> None:
        self._complaints.error(
            "not-contacts",
            f"{to_unicode(tree)} is a set of joints; contacts are needed here",
            tree.span,
            "joint sets are for σ_k and τ_k, one to each",
        )

    def resolve_any(self, tree: Resources) -> ContactSet | JointSet | None:
        """The set that a resource expression means, of contacts or of joints; None after a complaint."""
        meant = self._meaning_of(tree)
        if meant is None:
            return None
        return meant.joints or ContactSet(to_unicode(tree), meant.members, len(self._contacts))

    def resolve_joints(self, tree: Resources) -> JointSet | None:
        """The set of joints that a resource expression means; None after a complaint."""
        meant = self._meaning_of(tree)
        if meant is None:
            return None
        if meant.joints is None:
            self._complaints.error(
                "not-joints",
                f"{to_unicode(tree)} is a set of contacts; joints are needed here",
                tree.span,
                f"declare a joint set, Γ_k: flexion; known joint sets: {', '.join(self._joint_sets)}",
            )
            return None
        return JointSet(to_unicode(tree), meant.joints.joints, meant.joints.count)

    def has_gravity(self, tree: Resources) -> bool:
        """Whether γ_g is somewhere in a resource expression."""
        waiting: list[Resources] = [tree]
        seen: set[str] = set()
        while waiting:
            part = waiting.pop()
            if not isinstance(part, Name):
                waiting += part.members
            elif part.text == GRAVITY:
                return True
            elif part.text not in seen and (declared := self._declaration(part.text)) is not None:
                seen.add(part.text)
                waiting += [] if isinstance(declared.meaning, int | JointSet) else [declared.meaning]
        return False

    def _declaration(self, name: str) -> _Declared | None:
        """What declares a name. γ_α, where only a set α is, is the virtual contact of its members (Eq. 4.32)."""
        declared = self._declared.get(name)
        group = self._declared.get(name.removeprefix("γ_")) if declared is None else None
        if group is None or not isinstance(group.meaning, ResourceSet):
            return declared
        return replace(group, meaning=Virtual(group.meaning.members, group.meaning.span))

    def _meaning_of(self, tree: Resources) -> _Meant | None:
        if isinstance(tree, Name):
            return self._named(tree)
        if isinstance(tree, Virtual):
            single = self._virtual(tree)
            return None if single is None else _Meant((single,), is_set=False)
        if not tree.members:
            self._complaints.error(
                "empty-set", "a set without resources", tree.span, "name at least one resource, {γ1}"
            )
            return None
        members = self._each(tree.members)
        if members is None:
            return None
        self._warn_of_shared(tree.members, members)
        return _Meant(members, is_set=True)

    def _warn_of_shared(self, trees: Sequence[Resource], members: Sequence[ContactResource]) -> None:
        """Warn of a contact in two members of a set: its force would be set against itself."""
        owners: dict[int, str] = {}
        for tree, member in zip(trees, members, strict=True):
            for contact in [contact for contact, _ in member.weights if contact < len(self._contacts)]:
                if contact in owners:
                    name = self._contacts[contact]
                    self._complaints.warning(
                        "contact-twice",
                        f"{name} is in {owners[contact]} and in {member.label}: it opposes itself",
                        tree.span,
                        "let each contact be in one member of a set",
                    )
                owners[contact] = member.label

    def _named(self, name: Name) -> _Meant | None:
        if name.text == GRAVITY:
            return self._gravity(name)
        if name.text in self._meant:
            return self._meant[name.text]
        declared = self._declaration(name.text)
        if declared is None and name.text in self._joint_sets:
            return _Meant((), is_set=True, joints=self._joint_set(name.text))
        if declared is None and self._robot is None and name.text[:1] not in {"γ", "Γ"}:
            return None  # it may be a joint set of the hand that is not known
        if declared is None:
            from graspdsl.notation.slips import resource_slip

            slip, known = resource_slip(name.text), self._declared.keys() | self._meant.keys()
            self._complaints.error(
                "unknown-resource",
                f"there is no resource {name.text}",
                name.span,
                slip or known_names_hint(name.text, known, "resources"),
                () if slip else likely(name.text, known, name.span),
            )
            return None
        if name.text in self._open:
            cycle = " → ".join([*self._open[self._open.index(name.text) :], name.text])
            self._complaints.error(
                "resource-cycle", f"{name.text} is declared by itself: {cycle}", name.span, "declare it by contacts"
            )
            return None
        self._open.append(name.text)
        before = self._complaints.about(declared.path)
        self._meant[name.text] = self._declared_as(name.text, declared.meaning)
        self._complaints.about(before)
        self._open.pop()
        return self._meant[name.text]

    def _gravity(self, name: Name) -> _Meant | None:
        if not self.senses_gravity:
            self._complaints.error(
                "gravity-not-sensed",
                "γ_g has no place here: the centre of mass is known only of an object that is held",
                name.span,
                "add 'held: true' to the object, or leave γ_g out",
            )
        elif self._weightless:
            self._complaints.error(
                "no-gravity",
                "γ_g pulls at nothing: the scene's gravity is 0",
                name.span,
                "leave γ_g out, or leave scene.gravity at 9.81",
            )
        if self._robot is None or not self.senses_gravity or self._weightless:
            return None
        return _Meant((ContactResource(GRAVITY, ((len(self._contacts), 1.0),)),), is_set=False)

    def _declared_as(self, name: str, meaning: int | JointSet | Resources) -> _Meant | None:
        if isinstance(meaning, JointSet):
            return _Meant((), is_set=True, joints=meaning)
        if isinstance(meaning, int):
            return _Meant((ContactResource(name, ((meaning, 1.0),)),), is_set=False)
        meant = self._meaning_of(meaning)
        if meant is None or meant.is_set:
            return meant
        return _Meant((ContactResource(name, meant.members[0].weights),), is_set=False)

    def _each(self, trees: Sequence[Resource]) -> tuple[ContactResource, ...] | None:
        members = [self._single(tree) for tree in trees]
        complete = [member for member in members if member is not None]
        if len(complete) < len(members):
            return None
        seen: dict[tuple[tuple[int, float], ...], str] = {}
        for tree, member in zip(trees, complete, strict=True):
            if member.weights in seen:
                self._complaints.error(
                    "repeated-member", f"{member.label} is in the set twice", tree.span, "leave one of them out"
                )
                return None
            seen[member.weights] = member.label
        return tuple(complete)

    def _single(self, tree: Resource) -> ContactResource | None:
        if isinstance(tree, Virtual):
            return self._virtual(tree)
        meant = self._named(tree)
        if meant is None:
            return None
        if meant.joints is not None:
            self._not_contacts(tree)
            return None
        if meant.is_set:
            self._complaints.error(
                "set-in-set",
                f"{tree.text} is a set; a member must be a contact or a virtual contact",
                tree.span,
                f"to make the contacts of {tree.text} act as one, write them in < >",
            )
            return None
        return meant.members[0]

    def _virtual(self, tree: Virtual) -> ContactResource | None:
        if len(tree.members) < 2:
            from graspdsl.notation.slips import resource_slip

            empty = not tree.members
            meant = resource_slip(tree.members[0].text) if tree.members and isinstance(tree.members[0], Name) else None
            self._complaints.error(
                "empty-virtual-contact" if empty else "single-virtual-contact",
                f"a virtual contact {'without members' if empty else 'with one member'}",
                tree.span,
                meant or "a virtual contact joins at least two contacts, <γ2, γ3>",
            )
            return None
        members = self._each(tree.members)
        if members is None:
            return None
        shares: dict[int, float] = {}
        for member in members:
            for contact, weight in member.weights:
                if contact in shares:
                    name = [*self._contacts, GRAVITY][contact]
                    self._complaints.error(
                        "repeated-member", f"{name} is in the virtual contact twice", tree.span, "name it once"
                    )
                    return None
                shares[contact] = weight / len(members)
        return ContactResource(to_unicode(tree), tuple(sorted(shares.items())))


def is_formula(resource: str) -> bool:
    """Whether a resource is written out, as a set, a virtual contact, another resource or a definition; else it is
    named, a contact of the hand or a set of its joints."""
    text = plain(resource).strip()
    return text[:1] in {"{", "<"} or canonical(text)[:1] in {"γ", "Γ"} or defines(text)
