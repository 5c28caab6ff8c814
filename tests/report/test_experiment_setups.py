"""Which programs are the chapter's experiments."""

from __future__ import annotations

from pathlib import Path

import pytest

from graspdsl.compiler.program import Program, program_of
from graspdsl.report.experiment_setups import SETUPS, departure
from graspdsl.report.points import EXPERIMENTS

SPECS = {path.stem[0]: path for path in (Path(__file__).parents[2] / "specs" / "experiments").glob("*.yaml")}


def program(number: str, *overrides: str, changes: tuple[tuple[str, str], ...] = ()) -> Program:
    """An experiment with changes."""
    text = SPECS[number].read_text("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    return program_of(text, SPECS[number].name, overrides)


@pytest.mark.slow
def test_each_experiment_is_itself() -> None:
    assert set(SETUPS) == set(EXPERIMENTS) == {program(number).spec.name for number in SPECS}
    assert [departure(program(number)) for number in SPECS] == [""] * len(SPECS)


@pytest.mark.parametrize(
    "override",
    [
        *("scene.mount=gantry", "scene.friction=0.9", "scene.sensing=exact", "trials.seed=1", "trials.count=3"),
        *("parameters.κ_f=1.0", "trials.start.roll=0.5", "control.moment_gain=2.0", "evaluate=[]"),
    ],
)
def test_variants_are_the_experiment_still(override: str) -> None:
    assert departure(program("1", override)) == ""


def test_what_resources_are_called_and_their_order_do_not_matter() -> None:
    renamed = (('Γ: "{γ1, <γ2, γ3>}"', 'G: "{<γ3, γ2>, γ1}"'), ("π_close|Γ Γ", "π_close|G G"))
    formula = ("π_s|Γ Γ (π_gx|Γ Γ)", "π_s|G G (π_gx|G G)")
    assert departure(program("1", changes=(*renamed, formula))) == ""


@pytest.mark.parametrize(
    ("number", "override", "said"),
    [
        ("1", "scene.object=squirt-bottle", "its object is squirt-bottle, not towel-roll"),
        ("3", "scene.object={like: squirt-bottle, mass: 2.0}", "its object is one of its own, not squirt-bottle"),
        ("1", "scene.hand=trio", "its hand is trio, not barrett"),
        ("2", "trials.start.approach=side", "the hand comes from the side, not from the top"),
        ("1", "control.displacement=probing", "by probing"),
        ("1", "scene.gravity=0", "nothing in it has weight"),
        ("1", 'trials.grid=[{"parameter": "roll", "low": 0, "high": 1, "cells": 3}]', "on a grid"),
        ("1", 'resources.Γ="{γ1, γ2, γ3}"', "acts on {finger-1, finger-2, finger-3}"),
        ("1", 'program=[{run: "π_close|Γ Γ", until: {contact: all}}]', "1 formulas, not 2"),
        ("1", "program.1.run=π_close|Γ Γ", "is not made of"),
    ],
)
def test_other_programs_of_its_name_are_not(number: str, override: str, said: str) -> None:
    needed = {
        "scene.hand=trio": tuple(f"resources.γ{n}=digit-{n}" for n in (1, 2, 3)),
        "scene.gravity=0": ("evaluate=[]",),
        "program.1.run=π_close|Γ Γ": ("program.1.until={contact: all}",),
    }
    overrides = (override, *needed.get(override, ()))
    assert said in departure(program(number, *overrides))
    assert departure(program(number, *overrides, "name=mine")) == ""


def test_floating_contacts_are_not() -> None:
    overrides = ("scene.world=floating", "scene.hand=points", "scene.sensing=exact", "trials.start={}", "evaluate=[]")
    formula = ('program=[{run: "π_gx|Γ Γ", until: {force_residual: 0.1}}]', "parameters={}")
    contacts = tuple(f"resources.γ{n}=point-{n}" for n in (1, 2, 3))
    assert departure(program("1", *overrides, *formula, *contacts, "scene.object={sphere: {diameter: 0.1}}")) != ""
