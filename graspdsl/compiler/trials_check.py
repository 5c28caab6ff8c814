"""Do the trials that a spec asks for differ, and do they fill their grid."""

from __future__ import annotations

import math

from graspdsl.compiler.complaints import Complaints
from graspdsl.places.document import Document, Path
from graspdsl.spec.models import Spec

HINT = "or let a number of 'start' differ, as in roll: {uniform: [-0.5, 0.5]}"


def check_trials(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Warn of more trials asked for than can differ, and of cells of a grid that no trial begins in."""
    trials, different = spec.trials, spec.different_trials
    if "count" in trials.model_fields_set and trials.count > different:
        message = f"only {different:g} of {trials.count} trials can differ: the others repeat them"
        if different == 1:
            message = f"nothing is drawn at random: all {trials.count} trials are equal"
        _warn(document, complaints, "equal-trials", message, ("trials", "count"), f"write count: {different:g}, {HINT}")
    cells = math.prod(axis.cells for axis in trials.grid or ())
    if cells > trials.count:
        message = (
            f"{trials.count} trials begin in the first {trials.count} of the grid's {cells} cells, and in no other"
        )
        hint = f"write count: {cells}, or use fewer cells"
        _warn(document, complaints, "empty-cells", message, ("trials", "grid"), hint)


def _warn(document: Document, complaints: Complaints, code: str, message: str, path: Path, hint: str) -> None:
    complaints.about(path)
    complaints.warning(code, message, document.key_span(path), hint)
