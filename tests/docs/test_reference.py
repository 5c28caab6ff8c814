"""The reference is what the program itself says, and what its pages show is right."""

from __future__ import annotations

import re
import runpy
from pathlib import Path
from typing import Any

import pytest

from graspdsl.compiler.program import examine
from graspdsl.reference.diagnostics import examples
from graspdsl.reference.keys import parts
from graspdsl.reference.kinds import KINDS

DOCS = Path(__file__).resolve().parents[2] / "docs"
PLACE = DOCS / "reference"


@pytest.fixture(scope="module")
def made() -> dict[str, str]:
    """What the script makes now."""
    script: dict[str, Any] = runpy.run_path(str(DOCS / "render_reference.py"))
    pages: dict[str, str] = script["pages"]()
    return pages


def test_the_folder_holds_what_is_made_now(made: dict[str, str]) -> None:
    there = {str(path.relative_to(PLACE)): path for path in PLACE.rglob("*.*")}
    assert {*there} == {*made}
    assert [name for name, path in there.items() if path.read_text("utf-8") != made[name]] == []


def test_every_part_and_key_has_its_line(made: dict[str, str]) -> None:
    for part in parts():
        assert part.about
        for key in part.keys:
            assert f"| `{key.name}` | {key.type} |" in made["spec.md"]
            assert key.about, key.name
            assert key.type, key.name


def test_every_row_of_every_kind_is_on_a_page(made: dict[str, str]) -> None:
    shown = "".join(made.values())
    for kind, of in KINDS.items():
        assert f"`graspdsl list {kind}`" in made["index.md"]
        for row in of.rows():
            name = next(iter(row.values())).rpartition(".")[2].replace("|", r"\|")
            assert name in shown
    assert [code for code in examples() if f"### `{code}`" not in made["diagnostics.md"]] == []


def test_links_and_pictures_lead_somewhere(made: dict[str, str]) -> None:
    for name, text in made.items():
        for link in re.findall(r"\]\(([^)]+)\)", text) if name.endswith(".md") else ():
            assert link in made, link


def test_the_spec_on_the_page_of_the_grammar_is_sound(made: dict[str, str]) -> None:
    [spec] = re.findall(r"```yaml\n(.*?)```", made["grammar.md"], flags=re.S)
    assert "then" in spec
    assert examine(spec, "spec.yaml").diagnostics == ()
