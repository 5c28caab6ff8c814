"""Every complaint that there is has its example: the wrong text gets it, the right one does not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from plugins.conftest import site

from graspdsl.diagnostics import Severity
from graspdsl.reference.diagnostics import FORMS, Example, examples, rules

from . import examples as used
from .arranged import ARRANGED
from .codes import patterns

__all__ = ["site"]  # a fixture
EXAMPLES = examples()
OF_OTHERS = EXAMPLES["plugin-unfit"].section
KNOWN = [*EXAMPLES, *rules()]
GOLDEN = (
    (Path(__file__).parents[1] / "golden" / "diagnostics.txt", r"^spec\.yaml\S* (?:error|warning)\[(\S+)\]"),
    (Path(__file__).parents[1] / "notation" / "errors.txt", r"^([a-z-]+): expected"),
)
EACH_EXAMPLE = pytest.mark.parametrize("example", EXAMPLES.values(), ids=lambda example: example.code)


def test_every_code_that_the_source_can_raise_has_its_example() -> None:
    assert [code for code in sorted(patterns()) if not any(re.fullmatch(code, known) for known in KNOWN)] == []


def test_every_example_is_of_a_code_that_the_source_can_raise() -> None:
    assert [known for known in KNOWN if not any(re.fullmatch(code, known) for code in patterns())] == []


def test_a_code_without_an_example_would_be_found() -> None:
    assert {"wrong-sensor", "unknown-[a-z-]+", "tendon", "unexpected-sign", "wrong-form"} <= patterns()
    assert len(patterns()) > 220


@pytest.mark.parametrize(("file", "told"), GOLDEN, ids=lambda each: getattr(each, "name", ""))
def test_every_code_that_other_tests_meet_has_its_example(file: Path, told: str) -> None:
    """Also those that the source puts together."""
    met = {*re.findall(told, file.read_text("utf-8"), flags=re.M)}
    assert len(met) > 3
    assert met <= {*KNOWN}


def test_what_an_example_says_in_words_is_done() -> None:
    assert {*ARRANGED} == {example.code for example in EXAMPLES.values() if example.form == "words"}
    assert {example.form for example in EXAMPLES.values()} == {*FORMS}


@pytest.fixture
def folder(request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working directory, with what examples name; those of packages have a place to install them."""
    if request.node.callspec.params["example"].section == OF_OTHERS:
        request.getfixturevalue("site")
    monkeypatch.chdir(tmp_path)
    used.furnish(tmp_path)
    return tmp_path


@pytest.mark.slow
@EACH_EXAMPLE
def test_the_wrong_text_gets_the_complaint(example: Example, folder: Path) -> None:
    said = used.said(folder, example, wrong=True)
    assert (example.code, example.severity) in [(each.code, each.severity) for each in said], said


@pytest.mark.slow
@EACH_EXAMPLE
def test_the_right_text_gets_it_not_and_is_accepted(example: Example, folder: Path) -> None:
    said = used.said(folder, example, wrong=False)
    assert [each for each in said if each.code == example.code or each.severity is Severity.ERROR] == []
