"""Every controller of the prelude where it is used: checked, compiled, explained, and what the chapter has."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest

from graspdsl.basis.prelude import prelude
from graspdsl.compiler.explain import explained
from graspdsl.compiler.graph import controllers_in
from graspdsl.compiler.program import Program, program_of
from graspdsl.notation.printer import to_ascii, to_unicode

from .observations import JOINTS, compiled, observation
from .points import of_points
from .specs import floating, spec

HELD = "world: bullet, object: {like: towel-roll, held: true}"


@dataclass(frozen=True)
class Use:
    """A use of a controller, where it fits, and what it commands in each of its stages."""

    formula: str
    spaces: tuple[str, ...]
    scene: str = ""
    control: str = ""

    @property
    def program(self) -> Program:
        """The checked program."""
        until = "contact: all"
        if self.scene == "floating":
            return program_of(floating(self.formula, until=until, control=self.control), "test.yaml")
        scene = {"scene": HELD} if self.scene == "held" else {}
        parameters = "κ_f: 0.5, f_ref: [0, 0, 0.5, 0, 0, -0.5]"
        return program_of(
            spec(self.formula, until=until, parameters=parameters, control=self.control, **scene), "test.yaml"
        )


USES = {
    "π_fr": Use("π_fr|Γ Γ", ("ψ",), "floating"),
    "π_mr": Use("π_mr|Γ Γ", ("ψ",), "floating"),
    "π_cstar": Use("π_cstar|Γ Γ", ("ψ", "ψ"), "floating"),
    "π_g": Use("π_g|Γ Γ", ("ψ",), control="displacement: probing"),
    "π_gx": Use("π_gx|Γ {γ1, <γ2, γ3>, γ_g}", ("x",), "floating"),
    "π_h": Use("π_h|Γ Γ (σ_p(Γ))", ("q",)),
    "π_s": Use("π_s|Γ Γ (π_gx|Γ Γ)", ("q",)),
    "π_sq": Use("π_sq|(Γ, all) (Γ, flexion) (π_gx|Γ Γ)", ("q",)),
    "π_sgx": Use("π_sgx|Γ Γ", ("q",)),
    "π_gθ": Use("φ_r|τ_r(γ1) σ_r(γ1) (π_gθ|γ1 {γ1, γ_g})", ("q",), "held"),
    "π_rgθ": Use("π_rgθ|γ1 {γ1, γ_g}", ("q",), "held"),
    "π_close": Use("π_close|Γ Γ", ("q",)),
}
EACH_DEFINITION = pytest.mark.parametrize("name", prelude())
EACH_USE = pytest.mark.parametrize("use", USES.values(), ids=USES)


def test_every_controller_has_a_use() -> None:
    assert set(USES) == set(prelude())
    assert all(name in use.formula for name, use in USES.items())


@EACH_DEFINITION
def test_definition_is_of_the_chapter(name: str) -> None:
    definition = prelude()[name]
    assert definition.in_prelude
    assert re.fullmatch(r"4\.\d+|Sec\. 4(\.\d+)+", definition.equation)


def test_equations_are_of_one_controller_each() -> None:
    equations = [definition.equation for definition in prelude().values()]
    assert len(set(equations)) == len(equations)


@EACH_USE
def test_use_compiles_to_finite_commands(use: Use) -> None:
    (phase,), (stages,) = use.program.phases, use.program.pipelines()
    assert tuple(stage.gradient_space.value for stage in phase.stages) == use.spaces
    for pipeline in stages:
        for seed in range(10):
            seen = of_points(seed) if use.scene == "floating" else observation(seed)
            tick = pipeline.evaluate(seen)
            shape = (JOINTS,) if use.spaces[0] == "q" else seen.points.shape
            assert tick.command.displacement.shape == shape
            assert tick.command.space == ("q" if use.spaces[0] == "q" else "x")
            assert np.all(np.isfinite(tick.command.displacement))
            assert np.linalg.norm(tick.command.displacement) > 0.0
            assert np.all(np.isfinite(tick.disturbances))


@EACH_USE
def test_use_is_the_same_in_every_spelling(use: Use) -> None:
    (phase,) = use.program.phases
    for printed in (to_unicode, to_ascii):
        again = Use(printed(phase.formula), use.spaces, use.scene, use.control).program.phases
        assert [stage.stages for stage in again] == [phase.stages]


@EACH_USE
def test_use_is_explained(use: Use) -> None:
    (phase,) = use.program.phases
    [explanation] = explained(use.program)
    text = explanation.text()
    for stage in phase.stages:
        for node in controllers_in(stage):
            for part in (node.potential, node.sensor, node.effector):
                cited = part.equation if part.equation.startswith("Sec.") else f"Eq. {part.equation}"
                assert f"({cited})" in text
                assert part.symbol in text
    assert "Eq. Sec." not in text


@pytest.mark.slow
@pytest.mark.parametrize(
    ("formula", "written_out"),
    [
        ("π_fr|γ1 Γ", "φ_fr|τ_fr(γ1) σ_fr(Γ)"),
        ("π_mr|γ1 Γ", "φ_mr|τ_mr(γ1) σ_mr(Γ)"),
        ("π_g|Γ Γ", "φ_mr|τ_mr(Γ) σ_mr(Γ) ◁ φ_fr|τ_fr(Γ) σ_fr(Γ)"),
        ("π_gx|γ1 Γ", "φ_mr|τ_mrx(γ1) σ_mr(Γ) ◁ φ_fr|τ_frx(γ1) σ_fr(Γ)"),
        ("π_s|Γ Γ (σ_p(Γ))", "φ_p|τ_p(Γ) σ_p(Γ) (σ_p(Γ)) ◁ φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))"),
        (
            "π_sq|(Γ, all) (Γ, flexion) (σ_p(Γ))",
            "φ_p|τ_p(Γ) σ_p(Γ) (σ_p(Γ)) ◁ φ_k|τ_k(all) σ_k(flexion) ◁ φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))",
        ),
        ("π_sgx|Γ Γ", "π_s|Γ Γ (π_gx|Γ Γ)"),
        ("π_gθ|γ1 {γ1, γ_g}", "φ_mr|τ_mrr(γ1) σ_mr({γ1, γ_g}) ◁ φ_fr|τ_frr(γ1) σ_fr({γ1, γ_g})"),
        ("π_rgθ|γ1 {γ1, γ_g}", "φ_r|τ_r(γ1) σ_r({γ1, γ_g}) (π_gθ|γ1 {γ1, γ_g})"),
        ("π_close|Γ Γ", "φ_f|τ_f(Γ) σ_f(Γ) (κ_f σ_n(Γ))"),
    ],
)
def test_controller_is_the_chapters(formula: str, written_out: str) -> None:
    """Step by step, so that nothing but the formula makes them."""
    one, other = compiled(formula), compiled(written_out)
    assert [step.label for step in one.steps] == [step.label for step in other.steps]
    for seed in range(3):
        ticks = [pipeline.evaluate(observation(seed)) for pipeline in (one, other)]
        np.testing.assert_array_equal(ticks[0].command.displacement, ticks[1].command.displacement)
