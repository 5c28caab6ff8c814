"""The language server, asked as editors ask it."""

from __future__ import annotations

import random
import subprocess
import sys
from pathlib import Path

import pytest
from cli.program import PROGRAM, TIMEOUT
from lsprotocol import types
from pygls.exceptions import JsonRpcException
from shipped import SPECS

from graspdsl.compiler.program import examine
from graspdsl.editor.finding import PRELUDE
from graspdsl.spec.formatting import formatted

from .client import Editor, applied, each_action, offset, units

pytestmark = pytest.mark.slow

SPEC = (SPECS / "towel_roll_two_contacts.yaml").read_text("utf-8")
# Letters that take one code unit of UTF-16, two of UTF-8; and characters that take two of UTF-16.
WIDE = "about: ναί 🖐𝛾🤖 to the left of what is told"
OWN = """controllers:
  π_mine|Γ_a Γ_b (x_r): {is: "π_s|Γ_a Γ_b (x_r)", equation: "7", about: a test}
  pi_two|G G: π_mine|G G (π_gx|Γ G)
"""
MISTAKES = {
    "name: towel-roll-two-contacts\n": "",
    "hand: barrett": "hand: baret",
    "friction: 0.4": "frction: 0.4",
    "limit: 30.0": "limit: 30 s",
    "(π_gx|": "(π_gxx|",
    "count: 58": "count: 58.0",
}


def mended(editor: Editor, uri: str) -> str:
    """A text after the first fix of each complaint, until there are no complaints."""
    for _ in range(10):
        if not editor.shown[uri]:
            return editor.texts[uri]
        [edits] = [
            list(actions[0].edit.changes[uri])
            for _, actions in [next((said, each) for said, each in each_action(editor, uri) if each)]
        ]
        editor.write(uri, applied(editor.texts[uri], edits))
        editor.diagnostics(uri)
    raise AssertionError(editor.shown[uri])


def test_planted_mistakes_are_mended_by_the_messages_of_the_protocol_alone(editor: Editor, tmp_path: Path) -> None:
    text = SPEC
    for right, wrong in MISTAKES.items():
        assert right in text
        text = text.replace(right, wrong, 1)
    uri = editor.open(tmp_path / "mistakes.yaml", text)
    said = editor.diagnostics(uri)
    codes = {each.code for each in said}
    assert codes == {"missing-key", "unknown-hand", "unknown-key", "wrong-type", "unknown-controller"}
    assert {each.severity for each in said} == {types.DiagnosticSeverity.Error}
    sound = mended(editor, uri)
    examination = examine(sound, "mended.yaml")
    assert examination.program is not None
    assert examination.diagnostics == ()
    assert examination.program.spec == examine(SPEC, "towel.yaml").program.spec
    editor.close(uri)


def test_places_are_counted_in_code_units_of_utf_16(editor: Editor, tmp_path: Path) -> None:
    text = SPEC.replace("scene:\n  world: bullet", f"{WIDE}\nscene: {{world: bullet, about: '🖐𝛾', wrld: x}}\nold:")
    text = text.replace("  γ1: finger-3", '  "γ1": "𝛾γ" # 🤖').replace("about: Experiment", "# about: Experiment")
    uri = editor.open(tmp_path / "wide.yaml", text)
    marked = [text[offset(text, said.range.start) : offset(text, said.range.end)] for said in editor.diagnostics(uri)]
    assert {"wrld", "about", "old"} <= set(marked)
    spec = SPEC.replace("run: π_s|Γ Γ (π_gx|Γ Γ)", "run: π_s|Γ Γ (π_gx|Γ Γ) # 🖐").replace(
        "until: {contact: all, hold: 0.2}", "until: {? '🖐🖐🖐🖐🖐🖐🖐🖐' : 1, contact: all, hold: 0.2}"
    )
    editor.write(uri, spec)
    [said] = editor.diagnostics(uri)
    assert spec[offset(spec, said.range.start) : offset(spec, said.range.end)] == "'🖐🖐🖐🖐🖐🖐🖐🖐'"
    answer = editor.ask("text_document_hover", types.HoverParams(**editor.at(uri, "hold: 0.2", 1)))
    assert units(spec.split("\n")[answer.range.start.line].partition("hold")[0]) == answer.range.start.character
    assert "how long the conditions must hold" in answer.contents.value
    editor.close(uri)


def test_hover_tells_what_a_name_and_a_key_are(editor: Editor, tmp_path: Path) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC + OWN)
    assert editor.diagnostics(uri) == []
    said = editor.hover(uri, "π_s|Γ Γ (π_gx", 1)
    assert "Eq. 4.24" in said
    assert "φ_p|τ_p(Γ) σ_p(Γ) (φ_mr|τ_mrx(Γ) σ_mr(Γ) ◁ φ_fr|τ_frx(Γ) σ_fr(Γ)) ◁ φ_f|τ_f(Γ) σ_f(Γ)" in said
    assert "phi_p|tau_p(G)" in said
    assert "gradient space q" in said
    assert "contact positions (m)" in said
    assert "Eq. 7" in editor.hover(uri, "π_mine|G G", 3)
    assert "`{γ1, <γ2, γ3>}`" in editor.hover(uri, "Γ Γ (π_gx")
    assert "given in this place where `π_mine|Γ_a Γ_b (x_r)` is used" in editor.hover(uri, "Γ_a", which=1)
    assert "`0.5`" in editor.hover(uri, "κ_f")
    friction = editor.hover(uri, "friction")
    assert "a number" in friction
    assert "by default `0.4`" in friction
    assert "in s" in editor.hover(uri, "limit: 30")
    assert "`gradient`" not in friction
    assert editor.hover(uri, "# the thumb", 4) == ""
    editor.close(uri)


@pytest.mark.parametrize(
    ("instead", "wanted", "unwanted"),
    [
        ("  wor", "world:", "hand:"),
        ("  world: ", "mujoco", "barrett"),
        ("  mount: ", "gantry", "ball"),
        ("  sensing: ", "skin", "lift"),
        ("  object: ", "towel-roll", "bullet"),
        ("  object: {cylin", "cylinder:", "world:"),
        ("  physics:\n    ", "time_step:", "world:"),
    ],
)
def test_keys_and_values_of_the_scene_are_offered(
    editor: Editor, tmp_path: Path, instead: str, wanted: str, unwanted: str
) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC.replace("  world: bullet", f"{instead}"))
    offered = {item.label for item in editor.complete(uri, f"scene:\n{instead}")}
    assert wanted in offered
    assert unwanted not in offered
    editor.close(uri)


FORMULAS = {
    "φ_fr|": ({"τ_fr", "τ_frx", "τ_frr"}, {"τ_mr", "Γ"}),
    "φ_fr|τ_frx(Γ) ": ({"σ_fr"}, {"σ_mr", "◁"}),
    "φ_fr|τ_frx(": ({"Γ", "γ1"}, {"σ_fr", "γ_g"}),
    "φ_k|τ_k(fl": ({"flexion"}, {"Γ"}),
    "π_s|Γ Γ (k": ({"κ_f"}, {"Γ"}),
    "π_s|Γ Γ (π_gx|Γ Γ) \\triangle": ({"◁"}, {"φ_fr"}),
    "π_s|Γ Γ (π_gx|Γ Γ) <|": ({"◁"}, {"φ_fr"}),
    "ph": ({"φ_fr", "φ"}, {"π_s"}),
    "\\phi_{fr": ({"φ_fr"}, {"φ_mr"}),
    "pi_g": ({"π_gx", "π_gθ", "π_g"}, {"π_s"}),
    "π_s|G": ({"Γ"}, {"γ1"}),
    "π_s|Γ \\gamma_1": ({"γ1"}, {"γ2"}),
    "π_s|Γ Γ ◁ ": ({"π_close", "φ_f"}, {"then"}),
}


@pytest.mark.parametrize("begun", FORMULAS)
def test_names_and_signs_of_a_formula_are_offered_in_any_spelling(editor: Editor, tmp_path: Path, begun: str) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC.replace("π_s|Γ Γ (π_gx|Γ Γ)", begun))
    items = editor.complete(uri, f"run: {begun}")
    wanted, unwanted = FORMULAS[begun]
    offered = {item.label for item in items}
    assert wanted <= offered
    assert not unwanted & offered
    text = editor.texts[uri]
    for item in items:
        written = text[offset(text, item.text_edit.range.start) : offset(text, item.text_edit.range.end)]
        assert begun.endswith(written)
        assert item.filter_text in (None, written)
    editor.close(uri)


@pytest.mark.parametrize(
    ("right", "begun", "wanted"),
    [
        ("{contact: all, hold: 0.2}", "{ho", {"hold:", "force_residual:"}),
        ("γ2: finger-1", "γ2: fi", {"finger-2", "flexion"}),
        ("γ2: finger-1", "gamma_2", {"γ2"}),
        ("trials:", "evaluate: [force-closure, ", {"lift", "shake"}),
        ("trials:", "evaluate:\n  - ", {"lift", "shake"}),
        ("trials:", "monitors: {palm: ", {"off", "stop"}),
        ("approach: side", "posture: {", {"spread-1:"}),
        ("roll: {uniform: [-1.5, 1.5]}", "roll: {", {"uniform:", "normal:"}),
        ("parameters:", "control:\n  nullspace: ", {"gradient", "task"}),
    ],
)
def test_keys_and_values_of_other_sections_are_offered(
    editor: Editor, tmp_path: Path, right: str, begun: str, wanted: set[str]
) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC.replace(right, begun, 1))
    assert wanted <= {item.label for item in editor.complete(uri, begun)}
    editor.close(uri)


def test_definitions_are_found_in_the_file_and_in_the_prelude(editor: Editor, tmp_path: Path) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC + OWN)
    text = editor.texts[uri]

    def found(what: str, after: int = 0, which: int = 0) -> tuple[str, str]:
        answer = editor.ask("text_document_definition", types.DefinitionParams(**editor.at(uri, what, after, which)))
        there = text if answer.uri == uri else PRELUDE.read_text("utf-8")
        line = there[: offset(there, answer.range.start)].count("\n")
        return Path(answer.uri).name, there.split("\n")[line].strip()

    assert found("Γ Γ (π_gx") == ("spec.yaml", 'Γ: "{γ1, <γ2, γ3>}"')
    assert found("γ2", which=1) == ("spec.yaml", "γ2: finger-1")
    assert found("π_mine|G G", 2)[1].startswith("π_mine|Γ_a Γ_b (x_r):")
    assert found('x_r)"')[1].startswith("π_mine|Γ_a Γ_b (x_r):")
    assert found("κ_f") == ("spec.yaml", "κ_f: 0.5 # N")
    assert found("π_s|Γ Γ (π_gx", 12) == ("prelude.yaml", "π_gx|Γ_τ Γ_σ:")
    assert editor.ask("text_document_definition", types.DefinitionParams(**editor.at(uri, "bullet"))) is None
    editor.close(uri)


@pytest.mark.parametrize(
    ("found", "which", "name", "has", "has_not"),
    [
        ("Γ Γ (π_gx", 0, "Γ_all", ['Γ_all: "{γ1', "π_s|Γ_all Γ_all (π_gx|Γ_all Γ_all)", "(π_gx|Γ G)"], ["|Γ Γ"]),
        ("γ2", 1, "gamma_5", ["γ5: finger-1", "<γ5, γ3>"], ["γ2"]),
        ("π_mine|Γ", 0, "π_ours", ["π_ours|Γ_a Γ_b (x_r):", ": π_ours|G G"], ["π_mine"]),
        ("pi_two", 0, "π_three", ["pi_three|G G: π_mine"], ["pi_two"]),
        ("Γ_a", 1, "Γ_m", ["π_mine|Γ_m Γ_b (x_r)", "π_s|Γ_m Γ_b"], ["Γ_a"]),
        ("G G", 1, "Γ_m", ["pi_two|G_m G_m: π_mine|G_m G_m (π_gx|Γ_m G_m)"], []),
    ],
)
def test_a_name_is_changed_wherever_it_stands(
    editor: Editor, tmp_path: Path, found: str, which: int, name: str, has: list[str], has_not: list[str]
) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC + OWN)
    text = editor.rename(uri, found, name, which)
    assert all(piece in text for piece in has)
    assert not any(piece in text for piece in has_not)
    assert examine(text, "spec.yaml").diagnostics == ()
    before, after = (examine(each, "spec.yaml").program for each in (SPEC + OWN, text))
    assert before is not None
    assert after is not None
    assert [phase.stages == other.stages for phase, other in zip(before.phases, after.phases, strict=True)]
    editor.close(uri)


def test_a_name_is_changed_in_latex_and_in_definitions(editor: Editor, tmp_path: Path) -> None:
    text = SPEC.replace('"{γ1, <γ2, γ3>}"', r"'\{\gamma_1, \langle\gamma_2, γ3\rangle\}'")
    text = text.replace("run: π_close|Γ Γ", r"run: '\pi_{near}|_{\Gamma}'")
    text = text.replace("γ2: finger-1", "γ2: finger-1\n  Γ_m: Γ_m = {γ1, γ2}")
    text += "controllers: {π_near: π_near|Γ_a Γ_b = π_g|Γ_a Γ_b}\n"
    uri = editor.open(tmp_path / "an own grasp, Γ.yaml", text)
    assert r"\{\gamma_{9}, \langle" in editor.rename(uri, "γ1", "γ9")
    assert r"'\pi_{near}|_{\mathit{thumbs}}'" in editor.rename(uri, "Γ:", "thumbs")
    assert "  Γ_c: Γ_c = {γ1, γ2}" in editor.rename(uri, "Γ_m: ", "Γ_c")
    assert "{π_far: π_far|Γ_a Γ_b = π_g|" in editor.rename(uri, "π_near: ", "π_far")
    editor.close(uri)


@pytest.mark.parametrize(
    ("found", "which", "name", "reason"),
    [
        ("π_s|", 0, "π_x", "not defined in this file"),
        ("κ_f", 0, "κ_n", "takes κ_f by this name"),
        ("γ2", 1, "γ3", "already"),
        ("γ2", 1, "γ_g", "gravity"),
        ("γ2", 1, "Γ_a", "already"),
        ("Γ_a", 1, "Γ", "already"),
        ("γ2", 1, "two fingers", "cannot be the name of a resource"),
        ("γ2", 1, "π_2", "cannot be the name of a resource"),
        ("γ2", 1, "null", "would be read as something else"),
        ("π_mine|Γ", 0, "π_gx", "in the prelude"),
        ("π_mine|Γ", 0, "mine", "cannot be the name of a controller"),
        ("friction", 0, "x", "there is no name"),
    ],
)
def test_a_name_that_cannot_be_changed_is_refused_with_the_reason(
    editor: Editor, tmp_path: Path, found: str, which: int, name: str, reason: str
) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC + OWN)
    with pytest.raises(JsonRpcException, match=reason) as refusal:
        editor.rename(uri, found, name, which)
    assert refusal.value.code == types.LSPErrorCodes.RequestFailed.value
    editor.close(uri)


def test_a_spec_is_formatted_as_the_command_does_it(editor: Editor, tmp_path: Path) -> None:
    """Left alone once it is; refused, with the reason, while it cannot be read."""
    written = SPEC.replace("π_close|Γ Γ", "pi_close|G  G # first").replace("friction: 0.4", "friction:   0.4")
    uri = editor.open(tmp_path / "askew.yaml", written)
    editor.diagnostics(uri)
    asked = types.DocumentFormattingParams(types.TextDocumentIdentifier(uri), types.FormattingOptions(2, True))
    tidy = applied(written, editor.ask("text_document_formatting", asked))
    assert tidy == formatted(written) == SPEC.replace("π_close|Γ Γ", "π_close|Γ Γ # first")
    editor.write(uri, tidy)
    editor.diagnostics(uri)
    assert not editor.ask("text_document_formatting", asked)
    editor.write(uri, f"{written}\n}}{{")
    editor.diagnostics(uri)
    assert editor.refusal("text_document_formatting", asked) == types.LSPErrorCodes.RequestFailed.value
    editor.close(uri)


def test_an_outline_has_what_the_spec_declares(editor: Editor, tmp_path: Path) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC + OWN)
    params = types.DocumentSymbolParams(types.TextDocumentIdentifier(uri))
    symbols = {symbol.name: symbol for symbol in editor.ask("text_document_document_symbol", params)}
    assert [inner.name for inner in symbols["resources"].children] == ["γ1", "γ2", "γ3", "Γ"]
    assert [inner.name for inner in symbols["program"].children] == ["π_close|Γ Γ", "π_s|Γ Γ (π_gx|Γ Γ)"]
    assert symbols["controllers"].children[0].detail == "π_s|Γ_a Γ_b (x_r)"
    editor.close(uri)


def test_hand_and_mount_files_are_judged_as_they_are_written(editor: Editor) -> None:
    hands = PRELUDE.parents[1] / "hands"
    for name, right, wrong, said in (
        ("barrett", "root: palm", "root: plam", "no link 'plam'"),
        ("gantry", "face: mount-face", "face: mount-fac", "mount-fac"),
        ("barrett", "palm_surface:", "palm_surfce:", "palm_surfce"),
    ):
        text = (hands / f"{name}.yaml").read_text("utf-8")
        uri = editor.open(hands / f"{name}.yaml", text.replace(right, wrong))
        [complaint, *_] = editor.diagnostics(uri)
        assert said in complaint.message
        editor.write(uri, text)
        assert editor.diagnostics(uri) == []
        editor.close(uri)


def test_texts_that_are_not_for_it_are_left_alone(editor: Editor, tmp_path: Path) -> None:
    for text in ("services:\n  web: {image: x}\n", "", "- a\n- b\n", "a: [\n"):
        uri = editor.open(tmp_path / "other.yaml", text)
        assert editor.diagnostics(uri) == []
        assert editor.hover(uri, text[:1]) == ""
        editor.close(uri)


def test_what_was_said_of_a_file_is_taken_back_when_it_is_closed(editor: Editor, tmp_path: Path) -> None:
    uri = editor.open(tmp_path / "spec.yaml", SPEC.replace("barrett", "baret"))
    assert editor.diagnostics(uri)
    editor.write(uri, SPEC.replace("barrett", "barret"))
    editor.close(uri)
    assert editor.diagnostics(uri) == []
    place = types.Position(3, 3)
    document = types.TextDocumentIdentifier(uri)
    assert editor.ask("text_document_hover", types.HoverParams(document, place)) is None
    assert editor.ask("text_document_completion", types.CompletionParams(document, place)) is None
    assert editor.actions(uri, types.Range(place, place)) == []


PIECES = [*"\n{}[\"'Γ<◁🖐\\|>", "  ", "- ", ": ", "# ", "π_s|", "&a ", "*a"]


def mutated(text: str, chance: random.Random) -> str:
    """A text as it may stand while it is written: cut, with pieces taken out, doubled or put in."""
    for _ in range(chance.randint(1, 4)):
        start = chance.randrange(len(text) + 1)
        end = min(len(text), start + chance.choice([0, 0, 1, 2, 5, 30, 200]))
        put = chance.choice(["", chance.choice(PIECES), text[start:end] * 2])
        text = text[:start] + put + text[end:]
    return text


@pytest.mark.parametrize("seed", range(2))
def test_half_written_texts_are_answered(editor: Editor, tmp_path: Path, seed: int) -> None:
    """Any place, also one outside of the text; a bug would be in the log, and end the module with a failure."""
    chance = random.Random(seed)
    text = SPEC + OWN
    uri = editor.open(tmp_path / "spec.yaml", text)
    for _ in range(20):
        text = mutated(text if chance.random() < 0.5 and text else SPEC + OWN, chance)
        editor.write(uri, text)
        rows = text.split("\n")
        line = chance.randrange(len(rows) + 2)
        place = types.Position(line, chance.randrange(len(rows[line] if line < len(rows) else "") + 3))
        at = {"text_document": types.TextDocumentIdentifier(uri), "position": place}
        editor.ask("text_document_hover", types.HoverParams(**at))
        editor.ask("text_document_completion", types.CompletionParams(**at))
        editor.ask("text_document_definition", types.DefinitionParams(**at))
        editor.ask("text_document_document_symbol", types.DocumentSymbolParams(at["text_document"]))
        editor.actions(uri, types.Range(place, place))
        refused = editor.refusal("text_document_rename", types.RenameParams(new_name="γ7", **at))
        assert refused in (None, types.LSPErrorCodes.RequestFailed.value)
    editor.write(uri, f"{text}\n")
    for said in editor.diagnostics(uri):
        assert offset(f"{text}\n", said.range.start) <= offset(f"{text}\n", said.range.end)
    editor.close(uri)


def test_the_server_ends_when_its_editor_is_gone() -> None:
    with subprocess.Popen([str(PROGRAM), "lsp"], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as alone:
        assert alone.stdin is not None
        alone.stdin.close()
        assert alone.wait(TIMEOUT) == 0


def test_without_its_library_it_says_what_to_install(tmp_path: Path) -> None:
    code = (
        "import sys; sys.modules['pygls'] = sys.modules['lsprotocol'] = None\n"
        "sys.argv = ['graspdsl', 'lsp']\nfrom graspdsl.cli import main\nmain()"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "pip install 'graspdsl[lsp]'" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_every_shipped_spec_names_the_schema() -> None:
    for path in SPECS.rglob("*.yaml"):
        text = path.read_text("utf-8")
        if "\ngraspdsl:" in text:
            first = text.partition("\n")[0]
            place = first.removeprefix("# yaml-language-server: $schema=")
            assert place != first, path
            assert (path.parent / place).resolve() == SPECS / "graspdsl.schema.json", path
