"""Faulty specs: every fault with its code, its place, its words and the way out."""

from __future__ import annotations

import copy
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.compiler.program import known_names
from graspdsl.diagnostics import Diagnostic, DiagnosticError, in_reading_order
from graspdsl.places.document import parse_document
from graspdsl.places.validation import validate_document
from graspdsl.places.wording import Data
from graspdsl.spec import Spec, read_spec

from .conftest import GOOD


def complaints(text: str, overrides: tuple[str, ...] = ()) -> tuple[Diagnostic, ...]:
    """What is wrong with a spec."""
    try:
        found = read_spec(text, "test.yaml", overrides, known_names()).faults
    except DiagnosticError as error:
        return error.diagnostics
    assert found
    return tuple(in_reading_order(found))


def place(diagnostic: Diagnostic) -> str:
    """line:column"""
    return f"{diagnostic.span.line}:{diagnostic.span.column}" if diagnostic.span else "-"


DISTRIBUTION = "a number, {uniform: [low, high]}, {normal: [mean, sd]} or {choice: [a, b, …]}"
OBJECT = "the name of an object, or an object such as {cylinder: {diameter: 0.10, height: 0.20}}"
SHAPES = "cylinder, sphere, box, ellipsoid, superquadric, bottle, mesh, urdf, mjcf, or like"
SHAPE = f"an object has exactly one shape ({SHAPES}), found"


@pytest.mark.parametrize(
    ("old", "new", "code", "where", "message", "hint"),
    [
        (
            "graspdsl: 1",
            "graspdsl: 2",
            "wrong-version",
            "1:11",
            "expected 1, the version of the spec's format, found 2",
            "write 1",
        ),
        (
            "graspdsl: 1",
            "graspdsl: true",
            "wrong-version",
            "1:11",
            "expected 1, the version of the spec's format, found true",
            "write 1",
        ),
        (
            "towel-roll-two-contacts",
            "../x y",
            "bad-name",
            "2:7",
            "expected a name of up to 60 letters, digits, '-', '_' and '.', found the text '../x y'",
            "write x-y",
        ),
        ("about: Exp", "abuot: Exp", "unknown-key", "3:1", "the file has no key 'abuot'", "did you mean about?"),
        (
            "sensing: load-cell",
            "sensing: lod-cell",
            "unknown-value",
            "10:12",
            "expected load-cell, skin, proximity or exact, found the text 'lod-cell'",
            "did you mean load-cell?",
        ),
        ("world: bullet", "wrld: bullet", "unknown-key", "5:3", "'scene' has no key 'wrld'", "did you mean world?"),
        (
            "height: {uniform: [0.06, 0.16]}",
            "height: {relative: 0.5, uniform: [0.06, 0.16]}",
            "wrong-form",
            "34:13",
            f"expected {DISTRIBUTION}, or {{relative: …}} with one of them, in m; found a mapping",
            "write exactly one of them",
        ),
        ("friction: 0.4", "friction: 1_0", "wrong-type", "9:13", "expected a number, found the text '1_0'", None),
        ("hand: barrett", "hand: 5", "wrong-type", "6:9", "expected text, found 5", 'put it in quotes: "5"'),
        ("object: towel-roll", "object: 5", "wrong-form", "8:11", f"expected {OBJECT}; found 5", None),
        (
            "object: towel-roll",
            "object: {cylnder: {diameter: 0.1, height: 0.2}}",
            "unknown-key",
            "8:12",
            "'object' has no key 'cylnder'",
            "did you mean cylinder?",
        ),
        (
            "object: towel-roll",
            "object: {sphere: {diameter: 0.1}, box: {size: [1, 1, 1]}}",
            "wrong-form",
            "8:11",
            f"{SHAPE} sphere and box",
            "for example {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}",
        ),
        (
            "object: towel-roll",
            "object: {mass: 1}",
            "wrong-form",
            "8:11",
            f"{SHAPE} none",
            "for example {cylinder: {diameter: 0.10, height: 0.20}, mass: 0.5}",
        ),
        (
            "object: towel-roll",
            "object: {sphere: {diameter: -0.1}}",
            "out-of-range",
            "8:31",
            "expected a number of at least 0.005 (m), found -0.1",
            "lengths are in metres",
        ),
        (
            "object: towel-roll",
            "object: {sphere: {diameter: 80}}",
            "out-of-range",
            "8:31",
            "expected a number of at most 2 (m), found 80",
            "lengths are in metres",
        ),
        (
            "moment_residual: 0.005",
            "moment_residual: 5",
            "out-of-range",
            "25:51",
            "expected a number of at most 0.5 (m), found 5",
            "lengths are in metres",
        ),
        (
            "trials:",
            "monitors: {lean: 20}\ntrials:",
            "out-of-range",
            "28:18",
            "expected a number of at most 3.1416 (rad), found 20",
            "angles are in radians",
        ),
        (
            "object: towel-roll",
            "object: {box: {size: [0.1, 0.1]}}",
            "wrong-length",
            "8:24",
            "expected [x, y, z]: three lengths (m), found 2 values",
            None,
        ),
        (
            "friction: 0.4",
            "friction: abc",
            "wrong-type",
            "9:13",
            "expected a number, found the text 'abc'",
            None,
        ),
        ("friction: 0.4", "friction: nan", "wrong-type", "9:13", "expected a number, found the text 'nan'", None),
        ("friction: 0.4", "friction: .nan", "not-finite", "9:13", "expected a finite number, found .nan", None),
        ("friction: 0.4", "friction: true", "wrong-type", "9:13", "expected a number, found true", None),
        ("friction: 0.4", "friction:", "wrong-type", "9:12", "expected a number, found nothing", None),
        ("friction: 0.4", "friction: 5.1", "out-of-range", "9:13", "expected a number of at most 5, found 5.1", None),
        (
            '"{γ1, <γ2,γ3>}"',
            "{γ1, <γ2,γ3>}",
            "unquoted-text",
            "15:6",
            "expected text, but without quotes YAML reads this as a mapping",
            'put it in quotes: "{γ1, <γ2,γ3>}"',
        ),
        (
            '"{γ1, <γ2,γ3>}"',
            "[γ1]",
            "unquoted-text",
            "15:6",
            "expected text, but without quotes YAML reads this as a list",
            'put it in quotes: "[γ1]"',
        ),
        (
            "{κ_f: 0.5,",
            "{κ_f: half,",
            "wrong-form",
            "16:19",
            "expected a number or a list of numbers; found the text 'half'",
            None,
        ),
        ("[0.1, 0, 1e-3]", "[0.1, x]", "wrong-type", "16:37", "expected a number, found the text 'x'", None),
        ("[0.1, 0, 1e-3]", "[]", "wrong-length", "16:31", "expected at least 1 item, found 0", None),
        (
            'is: "π_mine',
            'si: "π_mine',
            "missing-key",
            "19:3",
            "'π_two|Γ Γ' needs the key 'is'",
            "add 'is: π_s|Γ Γ' (what the name stands for: a formula)",
        ),
        (
            'equation: "4.30"',
            "equation: 4.30",
            "wrong-type",
            "19:54",
            "expected text, found 4.3",
            'put it in quotes: "4.30"',
        ),
        (
            "- run: π_close|Γ Γ\n    until",
            "- until",
            "missing-key",
            "21:5",
            "item 1 of 'program' needs the key 'run'",
            "add 'run: π_s|Γ Γ (π_gx|Γ Γ)' (the controller: a formula)",
        ),
        (
            "{contact: all, hold: 0.2}",
            "{hold: 0.2}",
            "missing-key",
            "22:12",
            "'until' needs contact, force_residual, moment_residual or force_error",
            "for example {contact: all}, or {force_residual: 0.1, moment_residual: 0.005}",
        ),
        (
            "contact: all",
            "contacts: all, force_residual: 1",
            "unknown-key",
            "22:13",
            "'until' has no key 'contacts'",
            "did you mean contact?",
        ),
        ("limit: 30", "limit: 601", "out-of-range", "26:12", "expected a number of at most 600 (s), found 601", None),
        (
            "[force-closure,",
            "[force-clsure,",
            "unknown-value",
            "27:12",
            "expected force-closure, ferrari-canny, grasp-matrix, lift or shake, found the text 'force-clsure'",
            "did you mean force-closure?",
        ),
        (
            "count: 58",
            'count: "58"',
            "wrong-type",
            "29:10",
            "expected a whole number, found the text '58'",
            "remove the quotes: 58",
        ),
        ("count: 58", "count: 1e3", "wrong-type", "29:10", "expected a whole number, found 1000", "write 1000"),
        (
            "count: 58",
            "count: 0",
            "out-of-range",
            "29:10",
            "expected a number of at least 1, found 0",
            None,
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{unifrom: [-1.5, 1.5]}",
            "wrong-form",
            "33:11",
            f"expected {DISTRIBUTION}, in rad; found a mapping",
            "did you mean uniform?",
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{uniform: [0, 1], normal: [0, 1]}",
            "wrong-form",
            "33:11",
            f"expected {DISTRIBUTION}, in rad; found a mapping",
            "write exactly one of them",
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{uniform: [1.5, -1.5]}",
            "out-of-range",
            "33:11",
            "the low end 1.5 is above the high end -1.5",
            "write [-1.5, 1.5]",
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{uniform: [-90, 90]}",
            "out-of-range",
            "33:11",
            "expected numbers from -6.28319 to 6.28319 (rad), found -90",
            "angles are in radians",
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{uniform: 3}",
            "wrong-type",
            "33:21",
            "expected [low, high]: two numbers, found 3",
            None,
        ),
        (
            "{uniform: [-1.5, 1.5]}",
            "{normal: [0, -1]}",
            "out-of-range",
            "33:11",
            "the standard deviation -1 is below 0",
            "write [mean, sd]",
        ),
        (
            "standoff: 0.047",
            "standoff: abc",
            "wrong-form",
            "35:15",
            f"expected {DISTRIBUTION}, in m; found the text 'abc'",
            None,
        ),
        (
            "trials:",
            "control: {step: '0.1'}\ntrials:",
            "wrong-type",
            "28:17",
            "expected a number (m), found the text '0.1'",
            "remove the quotes: 0.1",
        ),
    ],
)
def test_one_fault(good: str, old: str, new: str, code: str, where: str, message: str, hint: str | None) -> None:
    assert good.count(old) == 1
    found = complaints(good.replace(old, new))
    first = found[0]
    assert (first.code, place(first), first.message, first.hint) == (code, where, message, hint)
    assert len(found) == (2 if new.startswith("si:") else 1)  # not like enough to take one for the other


def test_what_is_missing_at_the_top_is_said_at_the_top() -> None:
    found = complaints("graspdsl: 1\n")
    assert {d.message for d in found} == {
        f"the file needs the key '{key}'" for key in ("name", "scene", "resources", "program")
    }
    assert {place(d) for d in found} == {"1:1"}
    assert all(d.hint and d.hint.startswith("add '") for d in found)


def test_all_faults_at_once_in_reading_order() -> None:
    text = GOOD.replace("sensing: load-cell", "sensing: moon").replace("friction: 0.4", "friction: 0.4\n  friction: 9")
    text = text.replace("limit: 8.0", "limit: -1").replace("count: 58", 'count: "58"').replace("seed: 2006", "sede: 1")
    found = complaints(text, ("scene.hand=3", "oops"))
    assert [(d.code, place(d)) for d in found] == [
        ("bad-override", "-"),
        ("wrong-type", "-"),
        ("duplicate-key", "10:3"),
        ("unknown-value", "11:12"),
        ("out-of-range", "24:12"),
        ("wrong-type", "30:10"),
        ("unknown-key", "31:3"),
    ]


def test_what_could_not_be_read_has_one_complaint(good: str) -> None:
    found = complaints(good.replace('"{γ1, <γ2,γ3>}"', "{{γ1,γ2}, γ3}"))
    assert [d.code for d in found] == ["key-not-text"]


def _paths(data: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    inner = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    return [path, *(found for key, value in inner for found in _paths(value, (*path, key)))]


ODD: list[Data] = [None, True, "odd", 10**60, -1, float("nan"), [], [1, "x"], {"odd": 1}, [[]], {"uniform": [1]}]


@pytest.mark.slow
@given(st.sampled_from(_paths(yaml.safe_load(GOOD))[1:]), st.sampled_from(ODD))
def test_one_odd_value_brings_one_complaint_for_each_odd_thing(path: tuple[str | int, ...], odd: Data) -> None:
    document = parse_document(GOOD, "test.yaml").with_value(path, copy.deepcopy(odd), "in a test")
    found: tuple[Diagnostic, ...] = ()
    try:
        validate_document(document, Spec)
    except DiagnosticError as error:
        found = error.diagnostics
    # A mapping may lack several keys; any other value is wrong once, or once for each item.
    assert len(found) <= (4 if isinstance(odd, dict) else 2 if isinstance(odd, list) else 1)
    assert all(d.message.startswith("in a test: ") and d.span is None for d in found)
    assert not any(word in d.message.lower() for d in found for word in ("input", "valid", "pydantic"))
