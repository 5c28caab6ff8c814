"""A user's own hand: a YAML file beside a URDF, read, held against it and completed."""

from __future__ import annotations

import posixpath
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, in_reading_order
from graspdsl.hands.completion import completed
from graspdsl.hands.descriptions import Hand
from graspdsl.hands.fingertip_check import fingertip_complaints
from graspdsl.hands.hand_check import faults
from graspdsl.hands.model_meshes import meshes_of
from graspdsl.hands.robot_model import FaultyModelError, RobotModel, robot_model
from graspdsl.places.document import Document, parse_document
from graspdsl.places.files import SIZE_LIMIT, SpecFolder, refusal, with_plain_line_ends
from graspdsl.places.folders import SUFFIXES, descriptions_in, told_of
from graspdsl.places.validation import validate_document


class HandFileError(Exception):
    """A hand file with faults: its name, its text and what is wrong with it, each with its place there."""

    def __init__(self, name: str, text: str, error: DiagnosticError) -> None:
        self.name, self.text, self.diagnostics = name, text, error.diagnostics
        super().__init__(name)


@dataclass(frozen=True, slots=True)
class FoundHand:
    """A hand that was read from a file, with the text of its model, and warnings."""

    hand: Hand
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


def hands_in(place: Path) -> dict[str, Hand]:
    """The hands in a file, or in every hand file of a folder, by name, each with the text of its model.

    Raises DiagnosticError with the faults of the first file that has any, each told with its place in it.
    """
    return {hand.hand: hand for hand in map(_sound_hand, descriptions_in(place, "hand"))}


def _sound_hand(path: Path) -> Hand:
    try:
        return hand_in(SpecFolder(path.parent), path.name).hand
    except (DiagnosticError, HandFileError) as error:
        raise DiagnosticError(told_of(path.name, error.diagnostics)) from None


def _found(files: SpecFolder, name: str, document: Document) -> FoundHand:
    hand = validate_document(document, Hand)
    model, of_model = _model(files, name, hand, document)
    meshes = meshes_of(files, _beside(name, hand.urdf), model)
    complaints = [*of_model, *(_placed(complaint, document) for complaint in (*meshes.complaints, *model.warnings))]
    complaints += faults(hand, model, document)
    complaints += fingertip_complaints(hand, model, meshes.corners, document)
    if has_errors(complaints):
        raise DiagnosticError(in_reading_order(complaints))
    return FoundHand(completed(hand, model).with_model(model.with_meshes(meshes.places)), tuple(complaints))


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


def _beside(name: str, other: str) -> str:
    return other if posixpath.isabs(other) else posixpath.join(posixpath.dirname(name), other)


def _placed(diagnostic: Diagnostic, document: Document) -> Diagnostic:
    key = "root" if diagnostic.code == "unknown-root" else "mjcf" if "mjcf" in document.data else "urdf"
    return replace(diagnostic, span=document.span((key,)))
