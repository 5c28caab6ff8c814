"""Mounts of elsewhere: YAML files, each beside its URDF, read and held against it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, in_reading_order, known_names_hint
from graspdsl.hands.descriptions import ALL, MOUNTING, Mount
from graspdsl.hands.model_meshes import meshes_of
from graspdsl.hands.robot_model import RobotModel, robot_model
from graspdsl.hands.urdf_rules import HINGES
from graspdsl.places.document import Document, parse_document
from graspdsl.places.document import Path as Keys
from graspdsl.places.files import SpecFolder, read_text
from graspdsl.places.folders import descriptions_in, told_of
from graspdsl.places.validation import validate_document
from graspdsl.places.wording import shortened


def mounts_in(place: Path) -> dict[str, Mount]:
    """The mounts in a file, or in every mount file of a folder, by name, each with the text of its model.

    Raises DiagnosticError with the faults of the first file that has any, each told with its place in it.
    """
    return {mount.mount: mount for mount in map(_sound_mount, descriptions_in(place, "mount"))}


def mount_in(path: Path) -> Mount:
    """The mount in a file, with the text of its model. Raises DiagnosticError with the faults of the file."""
    document = parse_document(read_text(path), path.name)
    mount = validate_document(document, Mount)
    files = SpecFolder(path.parent)
    model = robot_model(files.read(mount.urdf), mount.urdf, "")
    meshes = meshes_of(files, mount.urdf, model)
    complaints = [*mount_faults(mount, model, document), *meshes.complaints]
    if has_errors(complaints):
        raise DiagnosticError(in_reading_order(complaints))
    return mount.with_model(model.with_meshes(meshes.places))


def _sound_mount(path: Path) -> Mount:
    try:
        return mount_in(path)
    except DiagnosticError as error:
        raise DiagnosticError(told_of(path.name, error.diagnostics)) from None


def mount_faults(mount: Mount, model: RobotModel, document: Document) -> Iterator[Diagnostic]:
    """What a mount file says that its model does not bear out."""

    def error(code: str, message: str, keys: Keys, hint: str) -> Diagnostic:
        return Diagnostic(code, message, document.span(keys), hint)

    def unknown(what: str, name: str, keys: Keys, known: Collection[str]) -> Diagnostic:
        hint = known_names_hint(name, known, f"{what}s")
        return error(f"unknown-{what}", f"there is no {what} {shortened(name)!r}", keys, hint)

    if mount.face not in model.links:
        yield unknown("link", mount.face, ("face",), model.links)
    elif mount.face == model.root:
        message, hint = f"the face {mount.face} is the root of the model", "put a link before it, with a fixed joint"
        yield error("face-is-root", message, ("face",), hint)
    movable = {name: joint for name, joint in model.joints.items() if joint.kind in HINGES}
    for name in mount.joints:
        if name not in movable:
            yield unknown("joint", name, ("joints", name), movable)
        elif movable[name].limits is None:
            hint = "give it a <limit> with lower and upper"
            yield error("joint-without-limits", f"the joint {name} has no limits in the model", ("joints", name), hint)
    for name in movable.keys() - mount.joints.keys():
        hint = "list it, or make it fixed in the model"
        yield error("joint-left-out", f"the joint {name} of the model moves, but is not listed", ("joints",), hint)
    if MOUNTING in model.joints:
        message = f"the joint {MOUNTING} of the model has the name of the joint between mount and hand"
        yield error("name-taken", message, ("urdf",), "rename it in the model")
    for name, joints in mount.joint_sets.items():
        if name in (*model.joints, ALL):
            message = f"the joint set {name} has the name of a joint or of the set of all joints"
            yield error("name-taken", message, ("joint_sets", name), "give it another name")
        for number, joint in enumerate(joints):
            if joint not in mount.joints:
                yield unknown("joint", joint, ("joint_sets", name, number), mount.joints)
