"""Whatever stands in a spec, there is an answer: a program that gives finite commands, or complaints."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from notation import strategies as notation

from graspdsl.basis.spaces import GradientSpace
from graspdsl.compiler.lowering import compile_controller
from graspdsl.compiler.program import Examination, examine, examine_expression
from graspdsl.diagnostics import has_errors
from graspdsl.notation.printer import to_ascii, to_unicode
from graspdsl.notation.tree import Expression, Head, Resources
from graspdsl.spec.program import Control

from . import strategies
from .observations import TARGET, observation
from .specs import spec

pytestmark = pytest.mark.slow

UNHURRIED = settings(deadline=None)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)


def _answered(text: str, *overrides: str) -> Examination:
    found = examine(text, "spec.yaml", overrides)
    assert (found.program is None) == has_errors(found.diagnostics)
    for diagnostic in found.diagnostics:
        assert diagnostic.code
        assert diagnostic.message
        assert diagnostic.span is None or 1 <= diagnostic.span.line <= text.count("\n") + 1
    return found


@UNHURRIED
@given(tree=notation.expressions)
def test_any_formula(tree: Expression) -> None:
    _answered(spec(_quoted(to_unicode(tree))))


@UNHURRIED
@given(tree=notation.expressions)
def test_any_formula_on_the_command_line(tree: Expression) -> None:
    found = _answered(spec(), f"program.0.run={_quoted(to_ascii(tree))}")
    assert all(diagnostic.span is None for diagnostic in found.diagnostics)


@UNHURRIED
@given(tree=notation.resources, declared=st.lists(notation.resources, max_size=3))
def test_any_resources(tree: Resources, declared: list[Resources]) -> None:
    names = {f"γ{5 + i}": _quoted(to_unicode(meaning)) for i, meaning in enumerate(declared)}
    _answered(spec(_quoted(f"π_close|{to_unicode(tree)} γ5"), resources=names))


@UNHURRIED
@given(head=notation.heads, body=notation.expressions, second=strategies.formulas)
def test_any_definition(head: Head, body: Expression, second: Expression) -> None:
    definitions = {_quoted(to_unicode(head)): _quoted(to_unicode(body)), "π_mine|Γ Γ": _quoted(to_unicode(second))}
    use = f"{head.name.text}|Γ Γ ◁ π_mine|Γ Γ then {head.name.text}"
    _answered(spec(_quoted(use), controllers=definitions))


@UNHURRIED
@given(
    calls=st.lists(st.sampled_from(["π_a|Γ Γ", "π_b|Γ Γ", "π_c|Γ Γ", "π_close|Γ Γ"]), min_size=6, max_size=6),
    joints=st.lists(st.sampled_from([" ◁ ", " then "]), min_size=3, max_size=3),
)
def test_any_web_of_definitions(calls: list[str], joints: list[str]) -> None:
    bodies = [joint.join(calls[2 * i : 2 * i + 2]) for i, joint in enumerate(joints)]
    _answered(spec("π_a|Γ Γ", controllers=dict(zip(("π_a|Γ Γ", "π_b|Γ Γ", "π_c|Γ Γ"), bodies, strict=True))))


@UNHURRIED
@given(
    meanings=st.lists(
        st.sampled_from(["γ5", "γ6", "γ7", "'{γ5, γ1}'", "<γ6, γ7>", "<γ5, γ2>", "finger-1", "γ_g"]),
        min_size=3,
        max_size=3,
    )
)
def test_any_web_of_resources(meanings: list[str]) -> None:
    _answered(spec("π_close|γ5 γ5", resources=dict(zip(("γ5", "γ6", "γ7"), meanings, strict=True))))


@UNHURRIED
@given(tree=strategies.formulas)
def test_any_formula_of_known_names(tree: Expression) -> None:
    _answered(spec(_quoted(to_unicode(tree))))


@pytest.mark.parametrize("space", GradientSpace)
@UNHURRIED
@given(data=st.data(), lost=st.sets(st.integers(0, 2)))
def test_sound_formulas_give_finite_commands(space: GradientSpace, data: st.DataObject, lost: set[int]) -> None:
    phase, _ = examine_expression(to_unicode(data.draw(strategies.sound(space))))
    control = Control(
        nullspace=data.draw(st.sampled_from(["task", "gradient"])),
        virtual=data.draw(st.sampled_from(["members", "common"])),
        surface=data.draw(st.sampled_from(["tangent", "spherical"])),
        origin=data.draw(st.sampled_from(["centroid", "object", "world"])),
        displacement=data.draw(st.sampled_from(["sliding", "probing"])),
    )
    seen = observation()
    seen.touching[list(lost)] = False
    (stage,) = phase.stages
    target = replace(TARGET, control=control, held=data.draw(st.booleans()))
    tick = compile_controller(stage, phase.grasp, target).evaluate(seen)
    assert stage.gradient_space is space
    assert tick.command.space == ("x" if space is GradientSpace.SURFACE else space.value)
    assert all(rank >= 0 for rank in tick.ranks)
    assert np.all(np.isfinite(tick.command.displacement))
    assert np.all(np.isfinite(tick.disturbances))
