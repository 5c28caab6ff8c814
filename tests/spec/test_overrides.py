"""Values from the command line: applied before validation, and named in complaints instead of a place."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.spec import load_spec_text

from .conftest import GOOD


def test_overrides_replace_values_in_their_order(good: str) -> None:
    overrides = [
        "scene.friction=0.6",
        "trials.count=40",
        "scene.object={cylinder: {diameter: 0.07, height: 0.2}}",
        "program.1.limit=10",
        "program.1.limit=11",
        "control.step=2e-3",
        "control.cap=0.002",
        "trials.start.roll.uniform.0=-1",
        "parameters.κ_g=1",
    ]
    spec = load_spec_text(good, "test.yaml", overrides).spec
    assert (spec.scene.friction, spec.trials.count, spec.program[1].limit) == (0.6, 40, 11.0)
    assert (spec.control.step, spec.control.cap) == (0.002, 0.002)
    assert spec.parameters["κ_g"] == 1.0
    assert spec.trials.start.model_dump()["roll"] == {"uniform": (-1.0, 1.5)}
    assert not isinstance(spec.scene.object, str)


def test_an_override_mends_a_fault_of_the_file(good: str) -> None:
    text = good.replace("friction: 0.4", "friction: abc")
    assert load_spec_text(text, "test.yaml", ["scene.friction=0.5"]).spec.scene.friction == 0.5


def test_an_overridden_formula_has_places_of_its_own(good: str) -> None:
    document = load_spec_text(good, "test.yaml", ["program.0.run=π_x|Γ Γ"]).document
    path = ("program", 0, "run")
    source = document.source_text(path)
    assert (source.text, source.places[0], document.span(path)) == ("π_x|Γ Γ", (1, 1), None)
    fault = Diagnostic("unknown-name", "there is no π_x", source.span(0, 3))
    assert document.attributed(path, fault) == Diagnostic(
        "unknown-name", "in --set program.0.run=π_x|Γ Γ: there is no π_x"
    )
    other = ("program", 1, "run")
    assert document.attributed(other, fault) == fault
    assert document.span(other) is not None


@pytest.mark.parametrize(
    ("override", "code", "message", "hint"),
    [
        ("foo", "bad-override", "expected path=value", "for example --set scene.friction=0.6"),
        ("=3", "bad-override", "expected path=value", "for example --set scene.friction=0.6"),
        ("a..b=3", "bad-override", "expected path=value", "for example --set scene.friction=0.6"),
        ("scene.friction=abc", "wrong-type", "expected a number, found the text 'abc'", None),
        ("scene.frictoin=3", "unknown-key", "'scene' has no key 'frictoin'", "did you mean friction?"),
        ("contrl.step=0.01", "unknown-key", "the file has no key 'contrl'", "did you mean control or controllers?"),
        (
            "program.2.limit=1",
            "unknown-path",
            "'program' is a list of 2, and '2' is no number of an item in it",
            "items are numbered from 0 to 1",
        ),
        ("trials.count.x=3", "unknown-path", "'trials.count' is 58, which has nothing inside", None),
        (
            "trials.start.roll.uniform.0=2",
            "out-of-range",
            "the low end 2 is above the high end 1.5",
            "write [1.5, 2]",
        ),
        ("program=[]", "wrong-length", "expected at least 1 item, found 0", None),
        ("name=", "wrong-type", "expected text, found nothing", None),
        (
            "scene={world: bullet}",
            "missing-key",
            "'scene' needs the key 'object'",
            "add 'object: towel-roll' (an object of the catalogue, or one described here)",
        ),
        (
            "resources.Γ={γ1, γ2}",
            "wrong-type",
            "expected text, found a mapping",
            "put quotes around the value as well as around what the shell takes",
        ),
        (
            "program=[",
            "open-bracket",
            "this '[' is not closed",
            "close it with ']'; a formula or a set of resources needs quotes around it",
        ),
    ],
)
def test_faulty_overrides(good: str, override: str, code: str, message: str, hint: str | None) -> None:
    with pytest.raises(DiagnosticError) as caught:
        load_spec_text(good, "test.yaml", [override])
    assert caught.value.diagnostics == (Diagnostic(code, f"in --set {override}: {message}", None, hint),)


PART = st.sampled_from(["scene", "program", "0", "7", "²", "run", "trials", "start", "", "x", "κ_f", "parameters"])
VALUE = st.text(alphabet="a1{}[]:,.'\"&*!|>- \n\\", max_size=12)


@pytest.mark.slow
@given(st.lists(PART, max_size=4).map(".".join), VALUE)
def test_no_override_breaks_the_loader(path: str, value: str) -> None:
    found: tuple[Diagnostic, ...] = ()
    try:
        assert load_spec_text(GOOD, "test.yaml", [f"{path}={value}"]).document.overrides
    except DiagnosticError as error:
        found = error.diagnostics
    assert all(d.message.startswith("in --set ") and d.span is None for d in found)
