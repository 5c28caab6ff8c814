"""YAML to :class:`Spec`: models, overrides, JSON Schema."""

from graspdsl.spec.loading import LoadedSpec, json_schema, load_spec, load_spec_text
from graspdsl.spec.models import ControllerDefinition, Spec

__all__ = ["ControllerDefinition", "LoadedSpec", "Spec", "json_schema", "load_spec", "load_spec_text"]
