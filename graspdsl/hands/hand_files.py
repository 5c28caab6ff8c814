"""A user's own hand: a YAML file beside a URDF, read, held against it and completed."""

from __future__ import annotations

import posixpath
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from graspdsl.arrays import Array
from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, in_reading_order
from graspdsl.hands.completion import completed
from graspdsl.hands.descriptions import Hand
from graspdsl.hands.fingertip_check import fingertip_complaints
from graspdsl.hands.hand_check import faults
from graspdsl.hands.mesh_check import mesh_corners
from graspdsl.hands.robot_model import FaultyModelError, RobotModel, robot_model
from graspdsl.hands.urdf_check import undrawn
from graspdsl.places.document import Document, parse_document
from graspdsl.places.files import SIZE_LIMIT, SpecFolder, refusal, with_plain_line_ends
from graspdsl.places.mesh_places import MeshPlaces
from graspdsl.places.validation import validate_document

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
        return _found(files, name, parse_document(text, name))
    except DiagnosticError as error:
        raise HandFileError(name, text, error) from None


def _found(files: SpecFolder, name: str, document: Document) -> FoundHand:
    hand = validate_document(document, Hand)
    model, of_model = _model(files, name, hand, document)
    places = MeshPlaces(files, _beside(name, hand.urdf))
    meshes, of_meshes = _meshes(files, places, model.meshes)
    drawn, of_drawn = _meshes(files, places, model.drawn)
    complaints = [*of_meshes.values(), *model.warnings, *_undrawn(of_drawn)]
    complaints = [*of_model, *(_placed(complaint, document) for complaint in complaints)]
    complaints += faults(hand, model, document)
    corners = {mesh: found.corners for mesh, found in meshes.items()}
    complaints += fingertip_complaints(hand, model, corners, document)
    if has_errors(complaints):
        raise DiagnosticError(in_reading_order(complaints))
    filenames = {mesh: found.place for mesh, found in (meshes | drawn).items()}
    return FoundHand(completed(hand, model), model.with_meshes(filenames), tuple(complaints))


def _model(files: SpecFolder, name: str, hand: Hand, document: Document) -> tuple[RobotModel, Sequence[Diagnostic]]:
    """The model as far as it can be read, and its faults."""
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
        return robot_model(files.read(_beside(name, file)), file, hand.root), ()
    except FaultyModelError as error:
        return error.model, [_placed(fault, document) for fault in error.diagnostics]
    except DiagnosticError as error:
        raise DiagnosticError([_placed(fault, document) for fault in error.diagnostics]) from None


class _FoundMesh(NamedTuple):
    """Where a mesh is that the engine can take, and its corners (c, 3) in the units of its file."""

    place: str
    corners: Array


def _meshes(
    files: SpecFolder, places: MeshPlaces, names: Iterable[str]
) -> tuple[dict[str, _FoundMesh], dict[str, Diagnostic]]:
    """The meshes of a model, and the faults of those that the engine cannot take."""
    found, faulty = dict[str, _FoundMesh](), dict[str, Diagnostic]()
    for mesh in names:
        try:
            name = places.name(mesh)
            corners = mesh_corners(mesh, files.read(name))
            found[mesh] = _FoundMesh(str(files.place(name).resolve()), corners)
        except DiagnosticError as error:
            faulty[mesh] = error.diagnostics[0]
    return found, faulty


def _undrawn(faulty: Mapping[str, Diagnostic]) -> Iterable[Diagnostic]:
    """A warning for each kind of fault in meshes that are only drawn."""
    kinds = dict[str, Diagnostic]()
    for fault in faulty.values():
        kinds.setdefault(fault.code, undrawn(fault, "this mesh"))
    return kinds.values()


def _beside(name: str, other: str) -> str:
    return other if posixpath.isabs(other) else posixpath.join(posixpath.dirname(name), other)


def _placed(diagnostic: Diagnostic, document: Document) -> Diagnostic:
    key = "root" if diagnostic.code == "unknown-root" else "mjcf" if "mjcf" in document.data else "urdf"
    return replace(diagnostic, span=document.span((key,)))
