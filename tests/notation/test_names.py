"""The spellings of names."""

from __future__ import annotations

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from graspdsl.diagnostics import DiagnosticError
from graspdsl.notation.characters import LOOKALIKES, fold
from graspdsl.notation.names import ascii_name, canonical
from graspdsl.notation.parser import parse_head, parse_resources
from graspdsl.notation.printer import to_unicode
from graspdsl.notation.tree import Head, Name

from . import strategies

CANONICAL = [
    ("phi_fr", "φ_fr"),
    ("tau_frx", "τ_frx"),
    ("sigma_n", "σ_n"),
    ("pi_gx", "π_gx"),
    ("kappa_f", "κ_f"),
    ("G", "Γ"),
    ("Gamma", "Γ"),
    ("G_m", "Γ_m"),
    ("Gamma_m", "Γ_m"),
    ("G_sigma", "Γ_σ"),
    ("G_tau", "Γ_τ"),
    ("g", "γ"),
    ("g1", "γ1"),
    ("gamma1", "γ1"),
    ("gamma_1", "γ1"),
    ("γ_1", "γ1"),
    ("γ₁", "γ1"),
    ("γ₂₃", "γ23"),
    ("g_g", "γ_g"),
    ("phi1", "φ1"),
    ("pi_gtheta", "π_gθ"),
    ("pi_rgtheta", "π_rgθ"),
    ("alpha__x", "αx"),
    ("x__alpha2", "xα2"),
    ("x_ref", "x_ref"),
    ("gripper", "gripper"),
    ("phase", "phase"),
    ("g_phase", "γ_phase"),
    ("x_1", "x_1"),
    ("a__b", "a__b"),
    ("g__1", "g__1"),
    ("𝜑_𝑓𝑟", "φ_fr"),
    ("ϕ_fr", "φ_fr"),
    ("ϕ＿ｆｒ", "φ_fr"),
    ("π_gϑ", "π_gθ"),
    ("ς_n", "σ_n"),
    ("ɸ_fr", "ɸ_fr"),
    ("Г_m", "Г_m"),
    ("γ¹", "γ¹"),
    ("finger-3", "finger-3"),
    ("", ""),
]

ASCII = [
    ("φ_fr", "phi_fr"),
    ("Γ", "G"),
    ("Γ_m", "G_m"),
    ("Γ_σ", "G_sigma"),
    ("γ1", "g1"),
    ("γ_g", "g_g"),
    ("π_gθ", "pi_gtheta"),
    ("κ_f", "kappa_f"),
    ("αx", "alpha__x"),
    ("γx", "gamma__x"),
    ("x_Γβ", "x_Gamma__beta"),
    ("xθ", "x__theta"),
]


@pytest.mark.parametrize(("written", "expected"), CANONICAL)
def test_canonical_spelling(written: str, expected: str) -> None:
    assert canonical(written) == expected


@pytest.mark.parametrize(("name", "expected"), ASCII)
def test_ascii_spelling(name: str, expected: str) -> None:
    assert ascii_name(name) == expected
    assert canonical(expected) == name


@given(st.text() | strategies.words)
def test_canonical_is_idempotent(name: str) -> None:
    assert canonical(canonical(name)) == canonical(name)


@pytest.mark.slow
@given(strategies.words)
def test_ascii_reads_back(word: str) -> None:
    name = canonical(word)
    assert ascii_name(name).isascii()
    assert canonical(ascii_name(name)) == name


@pytest.mark.slow
@given(strategies.names)
def test_names_of_the_grammar_are_names(name: Name) -> None:
    assert to_unicode(parse_resources(name.text)) == name.text


@pytest.mark.slow
@given(strategies.words)
def test_a_word_means_its_canonical_name(word: str) -> None:
    name = canonical(word)
    assume(name != "then" and not strategies.has_role(name))
    assert parse_resources(word) == parse_resources(name) == Name(name)


@pytest.mark.slow
@given(st.sampled_from(["φ", "phi", "τ", "tau", "σ", "sigma", "π", "pi"]), strategies.subscripts)
def test_a_role_survives_canonical_spelling(head: str, subscripts: str) -> None:
    name = canonical(head + subscripts)
    if strategies.has_role(name) and name[0] == "π":
        assert parse_head(head + subscripts) == parse_head(name) == Head(Name(name))
    elif strategies.has_role(name):
        for word in (head + subscripts, name):
            with pytest.raises(DiagnosticError):
                parse_resources(word)
    else:
        assert parse_resources(head + subscripts) == parse_resources(name) == Name(name)


@pytest.mark.parametrize("word", ["then", "", "1x", "_x", "x_", "x___y", "x__1", "é", "a b", "finger-3"])
def test_what_is_no_name(word: str) -> None:
    with pytest.raises(DiagnosticError):
        parse_resources(word)


def test_folding_keeps_columns_and_comes_to_rest() -> None:
    everything = "".join(map(chr, range(0x2FFFF)))
    folded = fold(everything)
    assert len(folded) == len(everything)
    assert fold(folded) == folded


def test_lookalikes_stay_as_they_are() -> None:
    assert all(fold(letter) == letter for letter in LOOKALIKES)
