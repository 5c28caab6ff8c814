"""Write docs/reference.md: every key of a spec, what it is and its default, from the models themselves.

Run it with the package installed: python docs/render_reference.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from graspdsl.compiler.program import known_names
from graspdsl.spec.loading import json_schema

PLACE = Path(__file__).resolve().parent / "reference.md"
HEAD = """# The keys of a spec

Each table is of one part of a spec, under its place in the file. `graspdsl schema` prints the same as a JSON Schema,
for editors. Made by `docs/render_reference.py`.
"""

Schema = Mapping[str, Any]


def reference() -> str:
    """The page: a table for the spec itself and for each part that it refers to, in the order of first mention."""
    whole = json_schema(known_names())
    places: dict[str, str] = {}
    sections = [HEAD, _section("The whole", whole)]
    waiting = list(_parts(whole, ""))
    while waiting:
        place, name = waiting.pop(0)
        if name in places:
            continue
        places[name] = place
        part = whole["$defs"][name]
        sections.append(_section(f"`{place}`", part))
        waiting = [*_parts(part, place), *waiting]
    return "\n".join(sections)


def _parts(schema: Schema, place: str) -> Iterator[tuple[str, str]]:
    """The parts that a schema's properties refer to: the place of each and its name."""
    for key, field in schema.get("properties", {}).items():
        for name in _references(field):
            yield f"{place}.{key}".lstrip("."), name


def _references(field: Any) -> Iterator[str]:
    if isinstance(field, Mapping):
        if "$ref" in field:
            yield str(field["$ref"]).rpartition("/")[2]
        for key, inner in field.items():
            if key not in ("default", "examples"):
                yield from _references(inner)
    elif isinstance(field, list):
        for inner in field:
            yield from _references(inner)


def _section(title: str, schema: Schema) -> str:
    properties = schema.get("properties")
    if not properties:
        return f"## {title}\n\n{_line(schema.get('description', ''))}\n"
    required = schema.get("required", [])
    rows = [
        f"| `{key}` | {_line(field.get('description', ''))} | {_default(field, key in required)} |"
        for key, field in properties.items()
    ]
    about = _line(schema.get("description", ""))
    return "\n".join([f"## {title}", "", about, "", "| key | what it is | default |", "|---|---|---|", *rows, ""])


def _line(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def _default(field: Schema, required: bool) -> str:
    if required:
        return "needed"
    default = field.get("default")
    if default is None or default in ("", {}, []):
        return ""
    if isinstance(default, dict):
        return "as below"
    return f"`{json.dumps(default, ensure_ascii=False)}`".replace("|", "\\|")


if __name__ == "__main__":
    PLACE.write_text(reference(), "utf-8")
