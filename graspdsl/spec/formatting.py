"""A spec in the one way to write it: keys in the order of the schema, formulas as the notation prints them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from pydantic import BaseModel

from graspdsl.diagnostics import DiagnosticError
from graspdsl.notation.names import ascii_name, canonical
from graspdsl.notation.parser import parse_expression, parse_head, parse_resources
from graspdsl.notation.printer import Printable, to_ascii, to_unicode
from graspdsl.places.document import Path
from graspdsl.places.files import refusal
from graspdsl.places.folders import HAND_FILE, MOUNT_FILE
from graspdsl.places.tidying import Style, tidied
from graspdsl.places.validation import slot
from graspdsl.spec.loading import load_spec_text
from graspdsl.spec.models import Spec

Read = Callable[[str], Printable]


def formatted(text: str, *, in_ascii: bool = False) -> str:
    """The text of a spec without errors, formatted; ``in_ascii``: its formulas and names in ASCII, not in Unicode.

    Comments stay, and what the spec means does. Applied twice it changes nothing. Raises DiagnosticError for a text
    that cannot be read as a spec.
    """
    refuse_others(text)
    before = meaning(text)
    written = tidied(text, _SpecStyle(to_ascii if in_ascii else to_unicode, ascii_name if in_ascii else str))
    if meaning(written) != before:
        raise RuntimeError("formatting would have changed what the spec means")
    return written


def refuse_others(text: str) -> None:
    """Raises DiagnosticError for a hand or a mount file, which are not formatted."""
    for kind, pattern in (("hand", HAND_FILE), ("mount", MOUNT_FILE)):
        if pattern.match(text):
            message = f"this is a {kind} file; only specs are formatted"
            hint = "trials are known by the bytes of their hand and mount files, which stay as they are"
            raise refusal("not-a-spec", message, hint)


def meaning(text: str) -> dict[str, Any]:
    """What a spec says, in whatever spelling and order of keys. Raises DiagnosticError for a text that is none."""
    spec = load_spec_text(text, "spec.yaml").spec
    said = spec.model_dump(warnings=False)
    said["resources"] = {canonical(name): _tree(value, _resources) for name, value in spec.resources.items()}
    said["parameters"] = {canonical(name): value for name, value in spec.parameters.items()}
    said["controllers"] = [
        (_tree(head, parse_head), _tree(known.body, parse_expression), known.equation, known.about)
        for head, known in spec.definitions().items()
    ]
    for phase in said["program"]:
        phase["run"] = _tree(phase["run"], parse_expression)
    return said


def _resources(text: str) -> Printable:
    """The tree of what is more than a name, which may be that of a contact; raises DiagnosticError for that."""
    if text.lstrip()[:1].isalnum():
        raise DiagnosticError([])
    return parse_resources(text)


def _tree(text: str, read: Read) -> Printable | str:
    """The tree of a formula; what is none is a text."""
    try:
        return read(text)
    except DiagnosticError:
        return text


class _SpecStyle(Style):
    def __init__(self, printed: Callable[[Printable], str], name: Callable[[str], str]) -> None:
        self._printed, self._name = printed, name

    def ranks(self, path: Path, keys: Sequence[str]) -> Sequence[int]:
        for model in slot(Spec, path).models:
            order = [
                model.model_fields[name].alias or name for name in sorted(model.model_fields, key=_inherited(model))
            ]
            if set(keys) <= set(order):
                return [order.index(key) for key in keys]
        return [0] * len(keys)

    def spelt(self, path: Path, text: str, *, key: bool) -> str | None:
        read: Read
        match path, key:
            case ("resources" | "parameters", _), True:
                return self._name(canonical(text))
            case ("controllers", _), True:
                read = parse_head
            case ("resources", _), False:
                read = _resources
            case ((("controllers", _) | ("controllers", _, "is") | ("program", _, "run")), False):
                read = parse_expression
            case _:
                return None
        tree = _tree(text, read)
        return None if isinstance(tree, str) else self._printed(tree)


def _inherited(model: type[BaseModel]) -> Callable[[str], int]:
    """From how far above a model has a field: what it adds itself is written before what it has in common."""
    above = [kind for kind in model.__mro__[1:] if issubclass(kind, BaseModel)]
    return lambda name: sum(name in kind.model_fields for kind in above)
