"""What a model says about the place of a fault: the fields known there, and the unit of a number."""

from __future__ import annotations

import types
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from graspdsl.spec.constructing import Path
from graspdsl.spec.fields import Model, Unit


@dataclass(frozen=True, slots=True)
class Slot:
    """What may stand at a path: the models, and for a number its unit."""

    models: tuple[type[BaseModel], ...]
    unit: str | None

    def fields(self) -> dict[str, FieldInfo]:
        """The fields that may stand here, by the keys they have in a file."""
        return {field.alias or name: field for model in self.models for name, field in model.model_fields.items()}

    def meant_by(self, key: str) -> str | None:
        """The hint for a key that none of the models has, where one of them knows what is meant by it."""
        hints = (model.meant_by.get(key) for model in self.models if issubclass(model, Model))
        return next((hint for hint in hints if hint is not None), None)


def slot(model: type[BaseModel], path: Path) -> Slot:
    """What ``model`` says about ``path``; nothing for a path it does not know."""
    here: list[Any] = [model]
    for step in path:
        here = [inner for annotation in here for inner in _inside(annotation, step)]
    parts = [part for annotation in here for part in _parts(annotation)]
    models = tuple(part for part in parts if isinstance(part, type) and issubclass(part, BaseModel))
    unit = next((part.symbol for part in parts if isinstance(part, Unit)), None)
    return Slot(models, unit)


def _parts(annotation: Any) -> Iterator[Any]:
    """The alternatives of an annotation, and what is attached to them."""
    origin = get_origin(annotation)
    if origin is Annotated or origin in (Union, types.UnionType):
        for part in get_args(annotation):
            yield from _parts(part)
    else:
        yield annotation


def _inside(annotation: Any, step: str | int) -> Iterator[Any]:
    """The annotations of what stands under ``step`` in a value."""
    for part in _parts(annotation):
        origin, arguments = get_origin(part), get_args(part)
        if isinstance(part, type) and issubclass(part, BaseModel):
            for name, field in part.model_fields.items():
                if (field.alias or name) == step:
                    yield field.annotation
                    yield from field.metadata
        elif origin is dict and isinstance(step, str):
            yield arguments[1]
        elif origin is tuple and isinstance(step, int):
            yield arguments[0]
