"""Numbers with units and the like: what they mean, and what is said of them in a spec."""

from __future__ import annotations

import math

import pytest

from graspdsl.units import number_meant

from .conftest import GOOD
from .test_faults import complaints


@pytest.mark.parametrize(
    ("text", "number", "unit"),
    [
        ("30 s", 30.0, "s"),
        ("30s", 30.0, "s"),
        ("20 ms", 0.02, "s"),
        ("2 min", 120.0, "s"),
        ("0.5 N", 0.5, "N"),
        ("500 mN", 0.5, "N"),
        ("0,5 N", 0.5, "N"),
        ("5mm", 0.005, "m"),
        ("10 cm", 0.1, "m"),
        ("10\u202fcm", 0.1, "m"),
        ("10 µm", 1e-5, "m"),
        ("1 kg", 1.0, "kg"),
        ("500 g", 0.5, "kg"),
        ("90°", math.pi / 2, "rad"),
        ("−90º", -math.pi / 2, "rad"),
        ("45 deg", math.pi / 4, "rad"),
        ("π/2", math.pi / 2, "rad"),
        ("-2*pi/3", -2 * math.pi / 3, "rad"),
        ("20 mm/s", 0.02, "m/s"),
        ("2 N·m", 2.0, "N·m"),
        ("1/4", 0.25, None),
        ("½", 0.5, None),
        ("30,5", 30.5, None),
        ("0,005", 0.005, None),
        ("−5", -5.0, None),
        ("1 000", 1000.0, None),
        ("1_000", 1000.0, None),
    ],
)
def test_numbers_as_people_write_them(text: str, number: float, unit: str | None) -> None:
    meant = number_meant(text)
    assert meant is not None
    assert meant[0] == pytest.approx(number, rel=1e-12)
    assert meant[1] == unit


@pytest.mark.parametrize("text", ["", "pinch", "5 parsec", "1,000", "1/0", "1e999 m", "1.2.3", "12:30", "9" * 1000])
def test_what_means_no_number(text: str) -> None:
    assert number_meant(text) is None


@pytest.mark.parametrize(
    ("old", "new", "hint"),
    [
        ("limit: 30", "limit: 30 s", "write the bare number, in s: 30"),
        ("limit: 30", "limit: 500ms", "write the bare number, in s: 0.5"),
        ("limit: 30", "limit: 30 cm", "write the bare number, in s"),
        ("limit: 30", 'limit: "30"', "remove the quotes: 30"),
        ("limit: 30", "limit: “30”", "remove the quotes: 30"),
        ("standoff: 0.047", "standoff: 47 mm", "write the bare number, in m: 0.047"),
        ("[-1.5, 1.5]", "[-1.5, 90°]", "write the bare number, in rad: 1.5708"),
        ("{uniform: [-1.5, 1.5]}", "45 deg", "write the bare number, in rad: 0.785398"),
        ("κ_f: 0.5", "κ_f: 0.5 N", "write the bare number: 0.5"),
        ("κ_f: 0.5", "κ_f: 500 mN", "write the bare number, in N: 0.5"),
        ("friction: 0.4", 'friction: "0,4"', "write the bare number: 0.4"),
        ("count: 58", "count: 58 trials", "write the bare number: 58"),
    ],
)
def test_the_bare_number_is_told_in_the_unit_of_the_field(old: str, new: str, hint: str) -> None:
    assert GOOD.count(old) == 1
    (found,) = complaints(GOOD.replace(old, new))
    assert found.hint == hint
