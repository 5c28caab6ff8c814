"""From text to graph: names, resources and definitions resolved."""

from __future__ import annotations

import pytest

from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.graph import (
    Composition,
    ControllerGraph,
    ControllerNode,
    ControllerReference,
    SensorReference,
    VectorReference,
    controllers_in,
)
from graspdsl.compiler.program import Program, examine_expression

from .observations import FIRST, SECOND, THUMB
from .specs import program


def graph(formula: str) -> ControllerGraph:
    """The one graph of a formula in the default scene."""
    (found,) = examine_expression(formula)[0].stages
    return found


def only(checked: Program) -> ControllerGraph:
    """The one graph of a program."""
    ((found,),) = [phase.stages for phase in checked.phases]
    return found


def shape(found: ControllerGraph) -> object:
    """A graph in short: the potentials, a list for ◁, a pair for a controller with its reference."""
    match found:
        case Composition(terms):
            return [shape(term) for term in terms]
        case ControllerNode(reference=ControllerReference(controller)):
            return found.potential.symbol, shape(controller)
        case ControllerNode(reference=SensorReference(label=label) | VectorReference(label=label)):
            return found.potential.symbol, label
    return found.potential.symbol


def resources(formula: str, **declared: str) -> ContactSet:
    """What the resources of π_close mean."""
    (node,) = controllers_in(only(program(f"π_close|{formula} {formula}", resources=declared)))
    return node.sensor_resources


@pytest.mark.parametrize(
    ("formula", "expected"),
    [
        ("π_close|Γ Γ", ("φ_f", "κ_f σ_n(Γ)")),
        ("π_gx|Γ Γ", ["φ_mr", "φ_fr"]),
        ("π_gx|γ1 {γ1, γ2}", ["φ_mr", "φ_fr"]),
        ("π_s|Γ Γ (π_gx|Γ Γ)", [("φ_p", ["φ_mr", "φ_fr"]), ("φ_f", "κ_f σ_n(Γ)")]),
        ("π_sgx|Γ Γ", [("φ_p", ["φ_mr", "φ_fr"]), ("φ_f", "κ_f σ_n(Γ)")]),
        ("π_s|γ1 γ1 (1, 2, 3)", [("φ_p", "(1, 2, 3)"), ("φ_f", "κ_f σ_n(γ1)")]),
        ("(π_mr|Γ Γ ◁ π_mr|γ1 Γ) ◁ π_fr|Γ Γ", [["φ_mr", "φ_mr"], "φ_fr"]),
        ("φ_f|τ_f(Γ) σ_f(Γ) (2 σ_n(Γ))", ("φ_f", "2 σ_n(Γ)")),
        ("φ_p|τ_p(γ1) σ_p(γ1) (σ_p(γ2))", ("φ_p", "σ_p(γ2)")),
    ],
)
def test_formula_in_the_default_scene(formula: str, expected: object) -> None:
    assert shape(graph(formula)) == expected


def test_spellings_give_one_graph() -> None:
    assert graph("pi_s|G G (pi_gx|G G)") == graph("π_s|Γ Γ (π_gx|Γ Γ)")


def test_abbreviation_is_what_it_stands_for() -> None:
    written_out = "φ_mr|τ_mrx(γ1) σ_mr(Γ) ◁ φ_fr|τ_frx(γ1) σ_fr(Γ)"
    assert graph("π_gx|γ1 Γ") == graph(written_out)


@pytest.mark.parametrize(
    ("formula", "controllers"),
    [
        ("π_close|Γ Γ then π_s|Γ Γ (π_gx|Γ Γ)", {}),
        ("π_a", {"π_a": "π_close|Γ Γ then π_sgx|Γ Γ"}),
        ("π_b|Γ Γ", {"π_a|Γ Γ": "π_close|Γ Γ then π_sgx|Γ Γ", "π_b|Γ Γ": "π_a|Γ Γ"}),
    ],
)
def test_sequence_becomes_stages(formula: str, controllers: dict[str, str]) -> None:
    (phase,) = program(formula, controllers=controllers).phases
    assert [shape(stage) for stage in phase.stages] == [
        ("φ_f", "κ_f σ_n(Γ)"),
        [("φ_p", ["φ_mr", "φ_fr"]), ("φ_f", "κ_f σ_n(Γ)")],
    ]


def test_names_in_ascii_keys_meet_unicode_formulas() -> None:
    checked = program(
        "π_mine|Γ_tau Γ_τ (x_ref)",
        resources={"G_tau": '"{g1, γ_2}"'},
        parameters="kappa_f: 2, x_ref: [1, 2, 3, 4, 5, 6]",
        controllers={"pi_mine|G_m G_m (y)": "π_s|Γ_m Γ_m (y)"},
    )
    position, force = controllers_in(only(checked))
    assert [member.label for member in position.sensor_resources.members] == ["γ1", "γ2"]
    assert position.reference == VectorReference("x_ref", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0))
    assert isinstance(force.reference, SensorReference)
    assert force.reference.factor == 2.0


@pytest.mark.parametrize(
    ("formula", "declared", "weights"),
    [
        ("γ1", {}, [{THUMB: 1.0}]),
        ("Γ", {}, [{THUMB: 1.0}, {FIRST: 0.5, SECOND: 0.5}]),
        ("{<γ3, <γ1, γ2>>}", {}, [{SECOND: 0.5, THUMB: 0.25, FIRST: 0.25}]),
        ("{γ_v, γ1}", {"γ_v": '"<γ2, γ3>"'}, [{FIRST: 0.5, SECOND: 0.5}, {THUMB: 1.0}]),
        ("{<γ_v, γ1>}", {"γ_v": '"<γ2, γ3>"'}, [{FIRST: 0.25, SECOND: 0.25, THUMB: 0.5}]),
        ("γ_t", {"γ_t": "γ1"}, [{THUMB: 1.0}]),
        ("Γ_m", {"Γ_m": "Γ"}, [{THUMB: 1.0}, {FIRST: 0.5, SECOND: 0.5}]),
        ("Γ_n", {"Γ_n": "Γ_m", "Γ_m": '"{γ2, γ1}"'}, [{FIRST: 1.0}, {THUMB: 1.0}]),
    ],
)
def test_resources_become_weights(formula: str, declared: dict[str, str], weights: list[dict[int, float]]) -> None:
    assert [dict(member.weights) for member in resources(formula, **declared).members] == weights


def test_the_same_resources_may_have_two_names() -> None:
    position, _ = controllers_in(only(program("π_s|Γ Γ_b (σ_p(Γ))", resources={"Γ_b": '"{<γ3, γ2>, γ1}"'})))
    assert position.sensor_resources.same_as(position.effector_resources)


def test_rows_of_a_servo_stand_in_one_order() -> None:
    node = graph("φ_f|τ_f({γ1, γ2}) σ_f({γ2, γ1}) (σ_n({γ1, γ2}))")
    assert isinstance(node, ControllerNode)
    assert isinstance(node.reference, SensorReference)
    for rows in (node.effector_resources, node.sensor_resources, node.reference.resources):
        assert [member.label for member in rows.members] == ["γ2", "γ1"]


@pytest.mark.parametrize(("given", "factor"), [("0.7", 0.7), ("κ_g", 3.0), ("κ_f", 0.5)])
def test_a_definition_may_scale_a_sensor_by_its_reference(given: str, factor: float) -> None:
    """Its parameter hides one of the spec's by the same name."""
    checked = program(
        f"π_press|Γ Γ ({given})",
        parameters="κ_f: 0.5, κ_g: 3, k: 9",
        controllers={"π_press|Γ Γ (k)": "φ_f|τ_f(Γ) σ_f(Γ) (k σ_n(Γ))"},
    )
    node = only(checked)
    assert isinstance(node, ControllerNode)
    assert isinstance(node.reference, SensorReference)
    assert node.reference.factor == factor


def test_arguments_are_not_taken_for_parameters() -> None:
    checked = program(
        "π_swap|(Γ_a, Γ_b) Γ_b",
        resources={"Γ_a": "γ1", "Γ_b": "γ2"},
        controllers={"π_swap|(Γ_b, Γ_a) Γ_a": "π_s|Γ_a Γ_a (σ_p(Γ_b))"},
    )
    position, _ = controllers_in(only(checked))
    assert isinstance(position.reference, SensorReference)
    assert position.sensor_resources.contacts == (FIRST,)
    assert position.reference.resources.contacts == (THUMB,)


def test_members_of_an_argument_join_the_set() -> None:
    checked = program("π_a|{γ2, γ3} {γ2, γ3}", controllers={"π_a|Γ Γ": '"π_close|{γ1, Γ} {γ1, Γ}"'})
    (node,) = controllers_in(only(checked))
    assert node.sensor_resources.contacts == (THUMB, FIRST, SECOND)


@pytest.mark.parametrize(
    ("formula", "label"),
    [
        ("π_s|Γ Γ (π_gx|γ1 {γ1, γ2})", "{γ1, γ2}"),
        ("π_close|γ2 γ2", "γ2"),
        ("π_close|γ2 γ2 then π_gx|Γ γ3", "γ3"),
    ],
)
def test_residuals_are_of_the_residual_sensors(formula: str, label: str) -> None:
    assert examine_expression(formula)[0].grasp.label == label
