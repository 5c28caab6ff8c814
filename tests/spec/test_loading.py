"""Specs as values: what the good one says, how it is written out, and other models read in the same way."""

from __future__ import annotations

import json
from typing import Any

import pytest
import yaml
from pydantic import Field

from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.objects.box import Box
from graspdsl.objects.cylinder import Cylinder
from graspdsl.objects.sphere import Sphere
from graspdsl.objects.superquadric import Superquadric
from graspdsl.places.document import parse_document
from graspdsl.places.fields import Metres, Model
from graspdsl.places.validation import validate_document
from graspdsl.spec import Spec, json_schema, load_spec_text, read_spec
from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.program import Control
from graspdsl.spec.trials import Trials


def place(diagnostic: Diagnostic) -> str:
    """line:column"""
    return f"{diagnostic.span.line}:{diagnostic.span.column}" if diagnostic.span else "-"


def test_the_good_spec(good: str) -> None:
    loaded = load_spec_text(good, "towel.yaml")
    assert (loaded.document.name, loaded.document.text) == ("towel.yaml", good)
    spec = loaded.spec
    assert spec.scene.object == "towel-roll"
    assert spec.resources["Γ"] == "{γ1, <γ2,γ3>}"
    assert spec.parameters == {"κ_f": 0.5, "x_ref": (0.1, 0.0, 0.001)}
    assert spec.definitions()["π_mine|Γ_τ Γ_σ"].body == "φ_fr|τ_fr(Γ_τ) σ_fr(Γ_σ)"
    assert spec.definitions()["π_two|Γ Γ"].equation == "4.30"
    assert spec.program[1].until.moment_residual == 0.005
    assert spec.program[1].limit == 30.0
    assert spec.trials.start.roll == Uniform(uniform=(-1.5, 1.5))
    assert spec.control.cap is None
    assert spec.control.nullspace == "gradient"
    assert spec.evaluate == ("force-closure", "ferrari-canny", "lift", "shake")


def test_a_spec_survives_being_written_out(good: str) -> None:
    spec = load_spec_text(good, "test.yaml").spec
    assert Spec.model_validate(spec.model_dump(mode="json", by_alias=True)) == spec
    text = yaml.safe_dump(spec.model_dump(mode="json", by_alias=True), allow_unicode=True)
    assert load_spec_text(text, "test.yaml").spec == spec


def test_formulas_know_their_places(good: str) -> None:
    document = load_spec_text(good, "test.yaml").document
    rows = good.split("\n")
    for source in [
        document.source_text(("program", 1, "run")),
        document.source_text(("resources", "Γ")),
        document.source_text(("controllers", "π_two|Γ Γ", "is")),
        document.key_source_text(("controllers", "π_mine|Γ_τ Γ_σ")),
    ]:
        assert source.text
        assert "".join(rows[line - 1][column - 1] for line, column in source.places[:-1]) == source.text


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("{normal: [0, 0.5]}", Normal(normal=(0, 0.5))),
        ("{choice: [0, 1, 2]}", Choice(choice=(0, 1, 2))),
        ("1", 1.0),
    ],
)
def test_distributions(good: str, written: str, read: object) -> None:
    assert load_spec_text(good, "test.yaml", [f"trials.start.roll={written}"]).spec.trials.start.roll == read


@pytest.mark.parametrize(
    ("written", "shape"),
    [
        ("{sphere: {diameter: 0.1}, name: ball}", Sphere(diameter=0.1)),
        ("{box: {size: [0.1, 0.1, 0.2]}, mass: 1}", Box(size=(0.1, 0.1, 0.2))),
        ("{cylinder: {diameter: 0.1, height: 0.2}}", Cylinder(diameter=0.1, height=0.2, edge=0.005)),
        ("{superquadric: {size: [0.1, 0.1, 0.2], exponent: 4}}", Superquadric(size=(0.1, 0.1, 0.2), exponent=4)),
        ("{like: towel-roll, held: true}", None),
    ],
)
def test_objects(good: str, written: str, shape: object) -> None:
    found = load_spec_text(good, "test.yaml", [f"scene.object={written}"]).spec.scene.object
    assert not isinstance(found, str)
    assert found.shape == shape


class Finger(Model):
    """A model of another kind of file."""

    length: Metres = Field(gt=0.0)
    joints: tuple[str, ...] = ()


def test_other_models_are_read_in_the_same_way() -> None:
    document = parse_document("length: 0.1\njoints: [a, b]\n", "hand.yaml")
    assert validate_document(document, Finger) == Finger(length=0.1, joints=("a", "b"))
    with pytest.raises(DiagnosticError) as caught:
        validate_document(parse_document("lenght: 0.1\njoints: [a, 1]\n", "hand.yaml"), Finger)
    assert [(d.code, place(d)) for d in caught.value.diagnostics] == [
        ("unknown-key", "1:1"),
        ("wrong-type", "2:13"),
    ]


def _described(schema: dict[str, Any]) -> bool:
    return all("description" in field for field in schema.get("properties", {}).values())


def test_the_schema_describes_every_field() -> None:
    schema = json.loads(json.dumps(json_schema()))
    assert schema["title"] == "graspdsl spec"
    assert set(schema["required"]) == {"graspdsl", "name", "scene", "resources", "program"}
    assert "is" in schema["$defs"]["ControllerDefinition"]["properties"]
    assert all(_described(part) for part in [schema, *schema["$defs"].values()])
    assert schema["additionalProperties"] is False


@pytest.mark.parametrize("override", ["scene.friction=x", "scene.world=7", "scene.object=7", "scene=7", "trials=7"])
def test_what_has_no_faults_is_read_beside_what_has(good: str, override: str) -> None:
    sound, reading = read_spec(good, "test.yaml"), read_spec(good, "test.yaml", [override])
    section = override.split("=")[0].split(".")[0]
    assert reading.faults
    assert not reading.is_sound(section)
    for name in Spec.model_fields.keys() - {section}:
        assert reading.is_sound(name)
        assert getattr(reading.spec, name) == getattr(sound.spec, name)


def test_a_faulty_section_keeps_what_can_be_read_of_it(good: str) -> None:
    faulty = (
        "scene.friction=x",
        "scene.object={box: {size: [1]}, held: true}",
        "resources.γ1=7",
        "parameters.κ_f=[1, x]",
        "program.0.run=7",
        "program.1.until.hold=x",
        "evaluate=[lift, 7, shake]",
    )
    spec = read_spec(good, "test.yaml", faulty).spec
    assert (spec.scene.world, spec.scene.hand, spec.scene.friction) == ("bullet", "barrett", None)
    assert not isinstance(spec.scene.object, str)
    assert (spec.scene.object.held, spec.scene.object.fixed) == (True, False)
    assert (spec.resources["γ1"], spec.resources["γ2"]) == (None, "finger-1")
    assert (spec.parameters["κ_f"], spec.parameters["x_ref"]) == (None, (0.1, 0.0, 0.001))
    assert [phase.run for phase in spec.program] == [None, "π_s|Γ Γ (π_gx|Γ Γ)"]
    assert (spec.program[1].until.hold, spec.program[1].until.force_residual) == (None, 0.1)
    assert spec.evaluate == ("lift", None, "shake")


def test_a_spec_of_nothing_reads_as_its_defaults() -> None:
    spec = read_spec("about: 7", "test.yaml").spec
    assert (spec.name, spec.scene.world, spec.scene.object, spec.scene.hand) == (None, None, None, "barrett")
    assert (dict(spec.resources), spec.program, spec.trials, spec.control) == ({}, (), Trials(), Control())
