"""A user's own mount: a YAML file beside its model, read, held against it and completed."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from graspdsl.diagnostics import (
    Diagnostic,
    DiagnosticError,
    has_errors,
    in_reading_order,
    known_names_hint,
    likely,
    listed,
)
from graspdsl.hands.description_files import DescriptionFileError, described_in, model_of
from graspdsl.hands.descriptions import ALL, MOUNTING, Joint, Mount, base_pose
from graspdsl.hands.mount_levers import weighed
from graspdsl.hands.mount_model import carrying, frame_of
from graspdsl.models.joint_kinds import CONTINUOUS, HINGES
from graspdsl.models.model import Frame, Model
from graspdsl.places.document import Document
from graspdsl.places.document import Path as Keys
from graspdsl.places.files import SpecFolder
from graspdsl.places.folders import descriptions_in, told_of
from graspdsl.places.validation import validate_document
from graspdsl.places.wording import shortened

SAME_PLACE = 1e-3  # m or (1): how far what holds may be off the origin


@dataclass(frozen=True, slots=True)
class FoundMount:
    """A mount that was read from a file, with the text of its model, and warnings."""

    mount: Mount
    warnings: tuple[Diagnostic, ...] = ()


def mount_in(files: SpecFolder, name: str) -> FoundMount:
    """The mount in a file.

    Raises DiagnosticError when the file cannot be read, DescriptionFileError with every fault in it.
    """
    return described_in(files, name, "mount", _found)


def mounts_in(place: Path) -> dict[str, Mount]:
    """The mounts in a file, or in every mount file of a folder, by name, each with the text of its model.

    Raises DiagnosticError with the faults of the first file that has any, each told with its place in it.
    """
    return {mount.mount: mount for mount in map(_sound_mount, descriptions_in(place, "mount"))}


def _sound_mount(path: Path) -> Mount:
    try:
        return mount_in(SpecFolder(path.parent), path.name).mount
    except (DiagnosticError, DescriptionFileError) as error:
        raise DiagnosticError(told_of(path.name, error.diagnostics)) from None


def _found(files: SpecFolder, name: str, document: Document) -> FoundMount:
    mount = validate_document(document, Mount)
    model, complaints = model_of(files, name, mount, document)
    mount = mount.model_copy(update={"face": mount.face or _only_end(model, document)})
    complaints += mount_faults(mount, model, document)
    if has_errors(complaints):
        raise DiagnosticError(in_reading_order(complaints))
    listed_ones = bool(mount.joints)
    if not listed_ones:
        named = {joint: Joint(weight=1.0, closes=0) for joint in _moving(mount, model) if joint not in mount.still}
        mount = mount.model_copy(update={"joints": named})
    whole = carrying(mount, model)
    if not listed_ones and mount.joints:
        whole = whole.model_copy(update={"joints": weighed(whole)})
    return FoundMount(whole, tuple(complaints))


def _only_end(model: Model, document: Document) -> str:
    """The one link that nothing hangs on. Raises DiagnosticError where there are more."""
    parents = {joint.parent for joint in model.joints.values()}
    ends = [link for link in model.links if link not in parents]
    if len(ends) == 1:
        return ends[0]
    message = f"the model has {len(ends)} ends, of which one carries the hand"
    hint = f"say which link: face: … ({listed(ends[:8], 'or')})"
    raise DiagnosticError([Diagnostic("missing-key", message, document.key_span(("mount",)), hint)])


def _moving(mount: Mount, model: Model) -> list[str]:
    """The joints of the model that can move the face, the first one first."""
    return [name for name in model.movers(mount.face) if model.joints[name].kind in HINGES]


def mount_faults(mount: Mount, model: Model, document: Document) -> list[Diagnostic]:
    """What a mount file says that its model does not bear out."""
    return list(_Check(mount, model, document).all())


class _Check:
    def __init__(self, mount: Mount, model: Model, document: Document) -> None:
        self._mount, self._model, self._document = mount, model, document
        self._movable = {name: joint for name, joint in model.joints.items() if joint.kind in HINGES}

    def all(self) -> Iterator[Diagnostic]:
        mount, model = self._mount, self._model
        for key in ("face", "holds"):
            link = getattr(mount, key)
            if link and link not in model.links:
                yield self._unknown("link", link, (key,), model.links)
            elif not link and getattr(mount, f"{key}_at") is not None:
                hint = f"name the link that it is on: {key}: …"
                yield self._error("missing-key", f"{key}_at is a pose on no link", (f"{key}_at",), hint)
        if mount.face == model.root and mount.face_at is None:
            message, hint = (
                f"the face {mount.face} is the root of the model",
                "put a link before it, with a fixed joint",
            )
            yield self._error("face-is-root", message, ("face",), hint)
        if mount.face in model.links:
            yield from self._joints()
        if mount.holds in model.links:
            yield from self._holding()
        if MOUNTING in model.joints:
            message = f"the joint {MOUNTING} of the model has the name of the joint between mount and hand"
            yield self._error("name-taken", message, ("urdf",), "rename it in the model")
        yield from self._sets()

    def _joints(self) -> Iterator[Diagnostic]:
        mount, model = self._mount, self._model
        moving, cut = _moving(mount, model), model.below(mount.face) - {mount.face}
        for name in mount.joints:
            if name not in self._movable:
                yield self._unknown("joint", name, ("joints", name), self._movable)
            elif name not in moving:
                message, hint = (
                    f"the joint {name} does not move the face {mount.face}",
                    f"joints that do: {listed(moving)}" if moving else "name another face: none of the joints moves it",
                )
                yield self._error("wrong-joint", message, ("joints", name), hint)
            elif name in mount.still:
                message = f"the joint {name} is driven, and keeps still"
                yield self._error("declared-twice", message, ("still", name), "leave it out of one of the two")
            else:
                yield from self._limited(name, ("joints", name))
        for name, place in mount.still.items():
            if name not in self._movable:
                yield self._unknown("joint", name, ("still", name), self._movable)
                continue
            low, high = self._movable[name].limits or (-np.inf, np.inf)
            if not low - ROUNDING <= place <= high + ROUNDING:
                message = f"{name} moves from {low:g} to {high:g}, found {place:g}"
                yield self._error("out-of-range", message, ("still", name), "keep within the limits of the joint")
        for name, joint in self._movable.items():
            if name in mount.still or joint.child in cut:
                continue
            if name in moving and not mount.joints:
                yield from self._limited(name, ("urdf" if mount.urdf else "mjcf",))
            elif name not in mount.joints:
                hint = "list it" if name in moving else "it does not move the face"
                hint += f", or say where it keeps still: still: {{{name}: 0.0}}"
                keys: Keys = ("joints",) if mount.joints else ("mount",)
                message = f"the joint {name} of the model moves, but is not listed"
                yield self._error("joint-left-out", message, keys, hint)

    def _limited(self, name: str, keys: Keys) -> Iterator[Diagnostic]:
        joint = self._movable[name]
        if joint.limits is None and joint.kind != CONTINUOUS:
            hint = "give it a <limit> with lower and upper"
            yield self._error("joint-without-limits", f"the joint {name} has no limits in the model", keys, hint)

    def _holding(self) -> Iterator[Diagnostic]:
        mount = self._mount
        movers = [name for name in self._model.movers(mount.holds) if name in self._movable and name not in mount.still]
        if movers:
            message = f"{listed(movers)} move {mount.holds}, where what holds an object keeps still"
            yield self._error(
                "holds-moves", message, ("holds",), f"say where they keep still: still: {{{movers[0]}: 0.0}}"
            )
            return
        if mount.base is None or mount.still or mount.holds_at:
            return  # the base follows from it
        at = Frame(*base_pose(mount)).then(frame_of(self._model, mount.holds))
        if np.abs(at.place).max() > SAME_PLACE or np.abs(at.rotation - np.eye(3)).max() > SAME_PLACE:
            x, y, z = np.round(at.place, 4).tolist()
            message = (
                f"with this base {mount.holds} is at [{x}, {y}, {z}], not upright at the origin, where objects stand"
            )
            yield self._error("wrong-base", message, ("base",), "leave the base out: it follows from what holds")

    def _sets(self) -> Iterator[Diagnostic]:
        driven = self._mount.joints or dict.fromkeys(self._movable)
        for name, joints in self._mount.joint_sets.items():
            if name in (*self._model.joints, ALL):
                message = f"the joint set {name} has the name of a joint or of the set of all joints"
                yield self._error("name-taken", message, ("joint_sets", name), "give it another name")
            for number, joint in enumerate(joints):
                if joint not in driven:
                    yield self._unknown("joint", joint, ("joint_sets", name, number), driven)

    def _unknown(self, what: str, name: str, keys: Keys, known: Collection[str]) -> Diagnostic:
        hint = known_names_hint(name, known, f"{what}s")
        found = self._error(f"unknown-{what}", f"there is no {what} {shortened(name)!r}", keys, hint)
        written = self._document.has(keys) and name == self._document.get(keys)
        return replace(found, fixes=likely(name, known, found.span) if written else ())

    def _error(self, code: str, message: str, keys: Keys, hint: str | None) -> Diagnostic:
        return Diagnostic(code, message, self._document.span(keys), hint)


ROUNDING = 1e-6  # rad or m
