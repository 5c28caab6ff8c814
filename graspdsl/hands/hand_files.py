"""A user's own hand: a YAML file beside a URDF, read, held against it and completed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from graspdsl.diagnostics import Diagnostic, DiagnosticError, has_errors, in_reading_order
from graspdsl.hands.completion import completed, coupled
from graspdsl.hands.description_files import DescriptionFileError, described_in, model_of
from graspdsl.hands.descriptions import Hand
from graspdsl.hands.fingertip_check import fingertip_complaints
from graspdsl.hands.fitted import fitted
from graspdsl.hands.hand_check import faults
from graspdsl.hands.put_on import put_on
from graspdsl.models.urdf_text import urdf_text
from graspdsl.places.document import Document
from graspdsl.places.files import SpecFolder
from graspdsl.places.folders import descriptions_in, told_of
from graspdsl.places.validation import validate_document


@dataclass(frozen=True, slots=True)
class FoundHand:
    """A hand that was read from a file, with the text of its model, and warnings."""

    hand: Hand
    warnings: tuple[Diagnostic, ...] = ()


def hand_in(files: SpecFolder, name: str) -> FoundHand:
    """The hand in a file.

    Raises DiagnosticError when the file cannot be read, DescriptionFileError with every fault in it.
    """
    return described_in(files, name, "hand", _found)


def hands_in(place: Path) -> dict[str, Hand]:
    """The hands in a file, or in every hand file of a folder, by name, each with the text of its model.

    Raises DiagnosticError with the faults of the first file that has any, each told with its place in it.
    """
    return {hand.hand: hand for hand in map(_sound_hand, descriptions_in(place, "hand"))}


def _sound_hand(path: Path) -> Hand:
    try:
        return hand_in(SpecFolder(path.parent), path.name).hand
    except (DiagnosticError, DescriptionFileError) as error:
        raise DiagnosticError(told_of(path.name, error.diagnostics)) from None


def _found(files: SpecFolder, name: str, document: Document) -> FoundHand:
    said = validate_document(document, Hand)
    model, complaints = model_of(files, name, said, document)
    hand = coupled(said, model)
    complaints += faults(hand, model, document)
    if not has_errors(complaints):
        hand, model = put_on(*fitted(hand, model))
        complaints += fingertip_complaints(hand, model, document)
    if has_errors(complaints):
        raise DiagnosticError(in_reading_order(complaints))
    return FoundHand(completed(hand, model).with_model(urdf_text(model)), tuple(complaints))
