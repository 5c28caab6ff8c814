"""Every number of a spec has finite bounds: the models are walked, so that a new field is looked at too."""

from __future__ import annotations

import math
import types
from collections.abc import Iterator
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

from graspdsl.diagnostics import DiagnosticError
from graspdsl.spec import Spec, load_spec_text
from graspdsl.spec.distributions import Choice, Normal, Uniform

DISTRIBUTIONS = (Uniform, Normal, Choice)  # bounded by the fields that they stand in
WITHOUT_BOUNDS: dict[str, str] = {}  # "Model.field": why it needs none
ENORMOUS = (1e300, -1e300, math.inf, -math.inf, math.nan)
PLAUSIBLE = (0.0, 0.01, 0.3, 1.0, 3.0, 500.0)

Value = Any
Place = tuple[str, Any, int]  # Model.field, its annotation, which of its numbers


def models(model: type[BaseModel], seen: set[type[BaseModel]]) -> set[type[BaseModel]]:
    """A model and all those within it but for distributions."""
    if model not in seen and model not in DISTRIBUTIONS:
        seen.add(model)
        for field in model.model_fields.values():
            for inner in inside(field.annotation):
                models(inner, seen)
    return seen


def inside(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models in an annotation."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    elif get_origin(annotation) is not Literal:
        for part in get_args(annotation):
            yield from inside(part)


def with_number(annotation: Any, value: float, *, whole: bool = False) -> Iterator[Value]:
    """What an annotation takes, with the value in the place of one number after the other."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if annotation is (int if whole else float):
        yield value
    elif annotation is Uniform:
        yield from ({"uniform": [min(0.0, value), value]}, {"uniform": [value, max(0.0, value)]})
    elif annotation is Normal:
        yield from ({"normal": [value, 0.01]}, {"normal": [0.0, value]})
    elif annotation is Choice:
        yield {"choice": [0.0, value]}
    elif origin is Annotated:
        yield from with_number(parts[0], value, whole=whole)
    elif origin in (Union, types.UnionType):
        for part in parts:
            yield from with_number(part, value, whole=whole)
    elif origin is dict:
        yield from ({"key": found} for found in with_number(parts[1], value, whole=whole))
    elif origin is tuple:
        yield from ([*before, found, *after] for before, found, after in in_a_tuple(parts, value, whole=whole))


def in_a_tuple(
    parts: tuple[Any, ...], value: float, *, whole: bool
) -> Iterator[tuple[list[Value], Value, list[Value]]]:
    """The items before, the one with the value, and those behind it."""
    if parts[-1] is Ellipsis:
        yield from (([], found, []) for found in with_number(parts[0], value, whole=whole))
        return
    for index, part in enumerate(parts):
        found = list(with_number(part, value, whole=whole))
        yield from (([0.1] * index, item, [0.1] * (len(parts) - index - 1)) for item in found)


def places(*, whole: bool = False) -> list[Place]:
    """Every number of a spec: in which field, and which of the field's numbers it is."""
    found = []
    for model in sorted(models(Spec, set()), key=lambda model: model.__name__):
        for name, field in model.model_fields.items():
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            count = len(list(with_number(field.annotation, 0.0, whole=whole)))
            found += [(f"{model.__name__}.{name}", annotation, number) for number in range(count)]
    return found


def takes(annotation: Any, value: Value) -> bool:
    """Whether a field takes a value."""
    try:
        TypeAdapter(annotation).validate_python(value)
    except ValidationError:
        return False
    return True


FLOATS = places()
WHOLE = places(whole=True)


def test_the_walk_finds_the_numbers() -> None:
    fields = {name for name, _, _ in FLOATS}
    assert {"Control.step", "Box.size", "StartSettings.roll", "Until.force_residual", "Spec.parameters"} <= fields
    assert {"LoadCell.force_noise", "MonitorBounds.lean", "Progress.window", "GridAxis.low", "Mesh.scale"} <= fields
    assert [number for name, _, number in FLOATS if name == "StartSettings.posture"] == list(range(6))
    assert {name for name, _, _ in WHOLE} >= {"Trials.count", "Trials.seed", "Progress.probes", "GridAxis.cells"}
    assert set(WITHOUT_BOUNDS) <= fields


@pytest.mark.parametrize(("name", "annotation", "number"), FLOATS, ids=lambda part: part if type(part) is str else "")
def test_a_number_takes_plausible_values_and_none_beyond_bounds(name: str, annotation: Any, number: int) -> None:
    def of(value: float) -> Value:
        return list(with_number(annotation, value))[number]

    assert any(takes(annotation, of(value)) for value in PLAUSIBLE)
    if name not in WITHOUT_BOUNDS:
        assert [value for value in ENORMOUS if takes(annotation, of(value))] == []


@pytest.mark.parametrize(("name", "annotation", "number"), WHOLE, ids=lambda part: part if type(part) is str else "")
def test_a_whole_number_has_bounds(name: str, annotation: Any, number: int) -> None:
    for value in (10**30, -(10**30)):
        assert not takes(annotation, list(with_number(annotation, value, whole=True))[number]), name


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("κ_f: 0.5", "κ_f: 1e300", "expected a number of at most 10000, found 1e+300"),
        ("[0.1, 0, 1e-3]", "[0.1, -1e300, 1e-3]", "expected a number of at least -10000, found -1e+300"),
        ("standoff: 0.047", "standoff: {normal: [0, 1e300]}", "expected a standard deviation of at most 1 (m)"),
        ("{uniform: [-1.5, 1.5]}", "{normal: [1e300, 0.1]}", "expected numbers from -6.28319 to 6.28319 (rad)"),
        ("force_residual: 0.1", "force_residual: 1e300", "expected a number of at most 100, found 1e+300"),
        ("moment_residual: 0.005", "moment_residual: .inf", "expected a finite number (m), found .inf"),
    ],
)
def test_what_is_enormous_is_one_complaint_at_its_place(good: str, old: str, new: str, message: str) -> None:
    text = good.replace(old, new)
    with pytest.raises(DiagnosticError) as caught:
        load_spec_text(text, "test.yaml")
    [found] = caught.value.diagnostics
    assert found.message.startswith(message)
    assert found.span is not None
    assert text.split("\n")[found.span.line - 1] not in good.split("\n")
