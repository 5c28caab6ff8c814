"""YAML to :class:`Spec`: reading with the place of every node, models, overrides, JSON Schema."""

from graspdsl.spec.document import Document, parse_document, read_document
from graspdsl.spec.loading import LoadedSpec, json_schema, load_spec, load_spec_text
from graspdsl.spec.models import ControllerDefinition, Spec
from graspdsl.spec.validation import validate_document

__all__ = [
    "ControllerDefinition",
    "Document",
    "LoadedSpec",
    "Spec",
    "json_schema",
    "load_spec",
    "load_spec_text",
    "parse_document",
    "read_document",
    "validate_document",
]
