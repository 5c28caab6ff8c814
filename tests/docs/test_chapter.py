"""The page on the chapter: all 41 equations, their formulas as the prelude has them, their code, their specs."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.entry import Entry
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.prelude import Definition, prelude
from graspdsl.basis.sensors import SENSORS
from graspdsl.compiler.program import Program, program_of
from graspdsl.notation.parser import parse_expression, parse_head
from graspdsl.notation.printer import to_unicode

from .pages import PAGES, ROOT, blocks_of

PAGE = PAGES["chapter.md"]
SECTIONS = dict(re.findall(r"^### (4\.\d+) [^\n]*\n(.*?)(?=^##|\Z)", PAGE, flags=re.S | re.M))
NUMBERED = [definition for definition in prelude().values() if re.fullmatch(r"4\.\d+", definition.equation)]
SPECS = sorted((ROOT / "specs" / "chapter").glob("*.yaml"))


def formulas(text: str) -> list[str]:
    """What a text has in the notation, a head before ≡ and what it stands for."""
    return [block.text.strip() for block in blocks_of(text) if block.language == "notation"]


def test_all_equations_are_there_in_their_order() -> None:
    assert [*SECTIONS] == [f"4.{number}" for number in range(1, 42)]
    assert all(section.count("$$") == 2 and "\nCode: " in section for section in SECTIONS.values())


@pytest.mark.parametrize("definition", NUMBERED, ids=lambda definition: definition.equation)
def test_a_definition_is_the_preludes(definition: Definition) -> None:
    [formula] = formulas(SECTIONS[definition.equation])
    head, _, body = formula.partition(" ≡ ")
    assert parse_head(head) == definition.head
    assert parse_expression(body) == definition.body


def test_formulas_that_have_no_number_or_no_name() -> None:
    others = [
        formula
        for formula in formulas(PAGE)
        if formula.partition(" ≡ ")[0] not in {to_unicode(d.head) for d in NUMBERED}
    ]
    unnumbered = [
        f"{to_unicode(d.head)} ≡ {to_unicode(d.body)}" for d in prelude().values() if d.body and d not in NUMBERED
    ]
    assert [formula for formula in others if "≡" in formula] == unnumbered
    [nameless] = [formula for formula in others if "≡" not in formula]
    assert f"run: {nameless} # Eq. 4.25" in (ROOT / "specs/chapter/4_26_slide_with_posture.yaml").read_text("utf-8")


@pytest.mark.parametrize(
    "entry", [*POTENTIALS.values(), *SENSORS.values(), *EFFECTORS.values()], ids=lambda e: e.symbol
)
def test_what_has_an_equation_is_named_beside_it(entry: Entry) -> None:
    """Those of the chapter's numbered equations."""
    if entry.equation in SECTIONS:
        assert (
            f"[`{type(entry).__name__}`](../{Path(*type(entry).__module__.split('.'))}.py)" in SECTIONS[entry.equation]
        )


@pytest.mark.parametrize("path", SPECS, ids=lambda path: path.stem)
def test_a_spec_stands_beside_what_it_shows(path: Path) -> None:
    """Under the equation of a controller that it runs, or beneath a formula without a number."""
    program = program_of(path.read_text("utf-8"), path.name)
    places = [section for section in SECTIONS.values() if f"specs/chapter/{path.name})" in section]
    assert any(ran(program, formula) for section in places for formula in formulas(section))


def ran(program: Program, formula: str) -> bool:
    """Whether a program runs a controller by its name, or as it is written."""
    used = {to_unicode(definition.head) for phase in program.phases for definition in phase.uses}
    return formula.partition(" ≡ ")[0] in used | {phase.label for phase in program.phases}
