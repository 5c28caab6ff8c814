"""What is wrong with the points of a sweep, told where the sweep has their values."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from graspdsl.compiler.complaints import Complaints
from graspdsl.diagnostics import Diagnostic
from graspdsl.places.document import Document, Path
from graspdsl.places.wording import Data, shortened
from graspdsl.spec.models import Spec
from graspdsl.spec.overrides import origin_of
from graspdsl.spec.sweeping import Point, Steps, Sweep, setting
from graspdsl.spec.trials import MOST_TRIALS

MOST_TOLD = 20  # complaints about points that differ


def check_sweep(spec: Spec, document: Document, complaints: Complaints) -> None:
    """Complain about a sweep that has more trials in all than a run may have."""
    points = len(spec.sweep.points()) if spec.sweep else 0
    if points * spec.trials.count > MOST_TRIALS:
        complaints.about(("sweep",))
        message = f"{points} points of {spec.trials.count} trials are more than the {MOST_TRIALS} of a run"
        hint = f"write count: {MOST_TRIALS // points}, or use fewer points"
        complaints.error("out-of-range", message, document.key_span(("sweep",)), hint)


def complaints_at(
    sweep: Sweep,
    document: Document,
    points: Iterable[tuple[int, Point, Sequence[Diagnostic]]],
    known: Collection[Diagnostic],
) -> list[Diagnostic]:
    """The complaints about points of a sweep, given those about the spec of each: of what the spec itself is told of,
    ``known``, nothing; of what comes with one value, once, at its place; the first MOST_TOLD."""
    told = dict[object, Diagnostic]()
    for number, point, found in points:
        for diagnostic in found:
            if diagnostic not in known:
                about = _about(diagnostic, point)
                key = (about, diagnostic.code, diagnostic.message)
                if key not in told and len(told) < MOST_TOLD:
                    told[key] = _placed(diagnostic, about, number, point, sweep, document)
    return list(told.values())


def _about(diagnostic: Diagnostic, point: Point) -> tuple[str, str] | None:
    """The field and the setting that a complaint about a point names."""
    for field, value in point.items():
        if diagnostic.message.startswith(f"{origin_of(setting(field, value))}: "):
            return field, setting(field, value)
    return None


def _placed(
    diagnostic: Diagnostic,
    about: tuple[str, str] | None,
    number: int,
    point: Point,
    sweep: Sweep,
    document: Document,
) -> Diagnostic:
    if about is None:
        said = ", ".join(shortened(setting(*value)) for value in point.items())
        return replace(diagnostic, message=f"at point {number} of the sweep, {said}: {diagnostic.message}", fixes=())
    field, value = about
    path = _place(sweep, field, point[field], number)
    message = f"at {shortened(value)}: {diagnostic.message.removeprefix(f'{origin_of(value)}: ')}"
    return document.attributed(path, replace(diagnostic, message=message, span=document.span(path), fixes=()))


def _place(sweep: Sweep, field: str, value: Data, number: int) -> Path:
    """Where a sweep has a value of a field, at a point."""
    if sweep.listed is not None:
        return "sweep", "list", number, field
    if sweep.random is not None:
        return "sweep", "random", "over", field
    values = (sweep.grid or {})[field]
    if isinstance(values, Steps):
        return "sweep", "grid", field
    return "sweep", "grid", field, [setting(field, one) for one in values].index(setting(field, value))
