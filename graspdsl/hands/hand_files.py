"""A user's own hand: a YAML file beside a URDF, read, held against it and completed."""

from __future__ import annotations

import posixpath
from dataclasses import dataclass, replace

from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.hands.descriptions import Contact, Hand
from graspdsl.hands.hand_check import faults
from graspdsl.hands.mesh_check import check_mesh
from graspdsl.hands.robot_model import RobotModel, robot_model
from graspdsl.hands.urdf_check import undrawn
from graspdsl.spec.document import Document, parse_document
from graspdsl.spec.files import SIZE_LIMIT, with_plain_line_ends
from graspdsl.spec.mesh_places import MeshPlaces
from graspdsl.spec.named_files import SpecFolder, refusal
from graspdsl.spec.validation import validate_document

SUFFIXES = (".yaml", ".yml")


class HandFileError(Exception):
    """A hand file with faults: its name, its text and what is wrong with it, each with its place there."""

    def __init__(self, name: str, text: str, error: DiagnosticError) -> None:
        self.name, self.text, self.diagnostics = name, text, error.diagnostics
        super().__init__(name)


@dataclass(frozen=True, slots=True)
class FoundHand:
    """A hand that was read from a file, the text of its URDF, meshes named by where they are, and warnings."""

    hand: Hand
    model: str
    warnings: tuple[Diagnostic, ...] = ()


def names_a_file(name: str) -> bool:
    """Whether the name of a hand is that of a file."""
    return name.endswith(SUFFIXES)


def hand_in(files: SpecFolder, name: str) -> FoundHand:
    """The hand in a file.

    Raises DiagnosticError when the file cannot be read, HandFileError with every fault in it.
    """
    content = files.read(name)
    if len(content) > SIZE_LIMIT:
        message = f"{name} is too large: {len(content)} bytes, where a hand file may have {SIZE_LIMIT}"
        raise refusal("file-too-large", message, "check that this is the file you meant")
    text = with_plain_line_ends(content.decode("utf-8", errors="replace"))
    try:
        document = parse_document(text, name)
        hand = validate_document(document, Hand)
        model = _model(files, name, hand, document)
        found = faults(hand, model, document)
        if found:
            raise DiagnosticError(in_reading_order(found))
        places = MeshPlaces(files, _beside(name, hand.urdf))
        meshes = {mesh: _mesh(files, places, mesh, document) for mesh in model.meshes}
        drawn, undrawn_meshes = _drawn_meshes(files, places, model, document)
    except DiagnosticError as error:
        raise HandFileError(name, text, error) from None
    warnings = tuple(_placed(warning, document) for warning in (*model.warnings, *undrawn_meshes))
    return FoundHand(completed(hand, model), model.with_meshes({**meshes, **drawn}), warnings)


def completed(hand: Hand, model: RobotModel) -> Hand:
    """A hand with what its file leaves to its model.

    The root is the model's, the palm the root; a finger is all driven joints that move its tip; open is the
    place of each joint that is nearest to 0, closed where the joints that close have gone as far as they can.
    """
    limits = {name: model.joints[name].limits or (0.0, 0.0) for name in hand.joints}
    opened = {name: min(max(0.0, low), high) for name, (low, high) in limits.items()}
    closed = {
        name: limits[name][1] if joint.closes > 0 else limits[name][0] if joint.closes < 0 else opened[name]
        for name, joint in hand.joints.items()
    }
    postures = {
        "open": {**opened, **hand.postures.get("open", {})},
        "closed": {**closed, **hand.postures.get("closed", {})},
    }
    contacts = {name: _with_finger(contact, hand, model) for name, contact in hand.contacts.items()}
    root = hand.root or model.root
    changes = {
        "urdf": hand.urdf or hand.mjcf,
        "root": root,
        "palm": hand.palm or root,
        "postures": postures,
        "contacts": contacts,
    }
    return hand.model_copy(update=changes)


def _with_finger(contact: Contact, hand: Hand, model: RobotModel) -> Contact:
    if contact.finger:
        return contact
    movers = (hand.couplings[name].follows if name in hand.couplings else name for name in model.movers(contact.link))
    own = tuple(dict.fromkeys(name for name in movers if name in hand.joints))
    return contact.model_copy(update={"finger": own})


def _model(files: SpecFolder, name: str, hand: Hand, document: Document) -> RobotModel:
    file = hand.urdf or hand.mjcf
    if bool(hand.urdf) == bool(hand.mjcf):
        hint = "name the model: urdf: my_hand.urdf"
        raise DiagnosticError(
            [
                Diagnostic(
                    "missing-key", "a hand file names one model, a URDF or a MJCF", document.key_span(("hand",)), hint
                )
            ]
        )
    try:
        return robot_model(files.read(_beside(name, file)), file, hand.root)
    except DiagnosticError as error:
        raise _at(error, document) from None


def _mesh(files: SpecFolder, places: MeshPlaces, mesh: str, document: Document) -> str:
    """Where a mesh is that the engine can take."""
    try:
        name = places.name(mesh)
        check_mesh(mesh, files.read(name))
    except DiagnosticError as error:
        raise _at(error, document) from None
    return str(files.place(name).resolve())


def _drawn_meshes(
    files: SpecFolder, places: MeshPlaces, model: RobotModel, document: Document
) -> tuple[dict[str, str], tuple[Diagnostic, ...]]:
    """Where the meshes are that are only drawn, and a warning for each kind of those that cannot be."""
    found, faults = dict[str, str](), dict[str, Diagnostic]()
    for mesh in model.drawn:
        try:
            found[mesh] = _mesh(files, places, mesh, document)
        except DiagnosticError as error:
            fault = error.diagnostics[0]
            faults.setdefault(fault.code, undrawn(fault, "this mesh"))
    return found, tuple(faults.values())


def _beside(name: str, other: str) -> str:
    return other if posixpath.isabs(other) else posixpath.join(posixpath.dirname(name), other)


def _at(error: DiagnosticError, document: Document) -> DiagnosticError:
    """The same complaints, at the place where the model is named."""
    return DiagnosticError([_placed(diagnostic, document) for diagnostic in error.diagnostics])


def _placed(diagnostic: Diagnostic, document: Document) -> Diagnostic:
    key = "root" if diagnostic.code == "unknown-root" else "mjcf" if "mjcf" in document.data else "urdf"
    return replace(diagnostic, span=document.span((key,)))
