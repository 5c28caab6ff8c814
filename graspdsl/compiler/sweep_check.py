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
from graspdsl.spec.sweeping import Point, Steps, Sweep, setting, settings
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
    ``known``, nothing; of a kind that comes with what stands at one place of the sweep, one; the first MOST_TOLD."""
    told = dict[object, Diagnostic]()
    for number, point, found in points:
        for diagnostic in (one for one in found if one not in known):
            field = _named(diagnostic, point)
            if field is None:
                told.setdefault((diagnostic.code, diagnostic.message), _of_point(diagnostic, number, point))
            else:
                path = _place(sweep, field, point[field], number)
                told.setdefault(
                    (diagnostic.code, path), _of_value(diagnostic, setting(field, point[field]), path, document)
                )
    return list(told.values())[:MOST_TOLD]


def _named(diagnostic: Diagnostic, point: Point) -> str | None:
    """The field whose value at a point a complaint names."""
    named = (field for field in point if diagnostic.message.startswith(_introduction(setting(field, point[field]))))
    return next(named, None)


def _introduction(value: str) -> str:
    return f"{origin_of(value)}: "


def _of_point(diagnostic: Diagnostic, number: int, point: Point) -> Diagnostic:
    said = ", ".join(map(shortened, settings(point)))
    return replace(diagnostic, message=f"at point {number} of the sweep, {said}: {diagnostic.message}", fixes=())


def _of_value(diagnostic: Diagnostic, value: str, path: Path, document: Document) -> Diagnostic:
    message = f"at {shortened(value)}: {diagnostic.message.removeprefix(_introduction(value))}"
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
