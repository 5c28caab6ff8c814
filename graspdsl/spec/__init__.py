"""YAML to :class:`Spec`: models, overrides, JSON Schema."""

from graspdsl.spec.loading import Reading, json_schema, load_spec_text, read_spec
from graspdsl.spec.models import ControllerDefinition, Spec

__all__ = ["ControllerDefinition", "Reading", "Spec", "json_schema", "load_spec_text", "read_spec"]
