"""Models of a spec that get keys while the program runs, one for each thing that enters a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any, ClassVar

from pydantic import BaseModel, SerializerFunctionWrapHandler, TypeAdapter, model_serializer
from pydantic.fields import FieldInfo

from graspdsl.places.fields import Model


class Growing(Model):
    """A model with a key for each thing of a table. Under a key that came ``later``, ``silent`` is as good as no key:
    what was made before the key came has none, and what is dumped leaves it out."""

    later: ClassVar[set[str]]
    silent: ClassVar[Any] = None

    def given(self, key: str) -> Any:
        """What stands under the key of a thing."""
        return getattr(self, key, self.silent)

    @model_serializer(mode="wrap")
    def _without_silent(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        return {key: value for key, value in dump(self).items() if key not in self.later or value != self.silent}


Place = tuple[type[BaseModel], str]  # a model and the name of its field


def grow(fields: Mapping[Place, FieldInfo], around: Sequence[type[BaseModel]]) -> None:
    """Give models other fields, the inner models first, and make anew the models that are ``around`` them.

    Raises what pydantic raises for a field that cannot be, and leaves all as it was.
    """
    before = {(model, name): model.model_fields.get(name) for model, name in fields}
    for (model, name), field in fields.items():
        model.model_fields[name] = field
    models = (*dict.fromkeys(model for model, _ in fields), *around)
    try:
        _make_anew(models)
    except Exception:
        for (model, name), old in before.items():
            model.model_fields.pop(name)
            if old is not None:
                model.model_fields[name] = old
        _make_anew(models)
        raise


def _make_anew(models: Sequence[type[BaseModel]]) -> None:
    for model in models:
        model.model_rebuild(force=True)
    adapter.cache_clear()
    schema_of.cache_clear()


@cache
def adapter(annotation: Any) -> TypeAdapter[Any]:
    """What validates a value of an annotation."""
    return TypeAdapter(annotation)


@cache
def schema_of(model: type[BaseModel]) -> Mapping[str, Any]:
    """The JSON Schema of a model, not to be changed."""
    return model.model_json_schema(by_alias=True)
