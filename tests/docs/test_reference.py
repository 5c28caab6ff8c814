"""The reference of specs is what the models say."""

from __future__ import annotations

import runpy
from pathlib import Path

from graspdsl.spec.loading import json_schema

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_reference_is_made_from_the_models() -> None:
    made = runpy.run_path(str(DOCS / "render_reference.py"))["reference"]()
    assert (DOCS / "reference.md").read_text("utf-8") == made


def test_every_part_and_key_has_its_line() -> None:
    text = (DOCS / "reference.md").read_text("utf-8")
    schema = json_schema()
    for part in (schema, *schema["$defs"].values()):
        for key, field in part.get("properties", {}).items():
            assert f"| `{key}` |" in text
            assert field.get("description"), key
