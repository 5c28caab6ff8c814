"""Things of other packages: found unimported, used where a spec names them, and where they are broken one complaint."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from compiler.specs import floating
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.compiler.program import Program, examine, program_of_expression
from graspdsl.diagnostics import Diagnostic, DiagnosticError, Severity
from graspdsl.plugins.adoption import adopted_all
from graspdsl.plugins.kinds import brought_by, offered
from graspdsl.trials.identity import identities

from .packages import HUBER, PHI, installed

THREE = "{γ1, γ2, γ3}"
FORMULA = f"φ_h|τ_frx({THREE}) σ_fr({THREE})"
NAMING = floating(FORMULA, until="force_residual: 0.05")
ORDINARY = floating(FORMULA.replace("φ_h", "φ_fr"), until="force_residual: 0.05")


def complaints(text: str, *overrides: str, folder: Path = Path()) -> tuple[Diagnostic, ...]:
    """All that is said of a spec."""
    return examine(text, "test.yaml", overrides, folder).diagnostics


def sound(text: str) -> Program:
    """The program of a spec of which there is nothing to say."""
    examination = examine(text, "test.yaml")
    assert examination.diagnostics == ()
    assert examination.program is not None
    return examination.program


def test_nothing_is_imported_before_it_is_named(site: Path) -> None:
    installed(site)
    sound(ORDINARY)
    assert [(offer.kind, offer.name, offer.by) for offer in offered()] == [("potentials", "φ_h", "kit 1.0")]
    assert "kit" not in sys.modules
    sound(NAMING)
    assert "kit" in sys.modules
    assert (brought_by("potentials", "φ_h"), brought_by("potentials", "φ_fr")) == ("kit 1.0", "graspdsl")


def test_a_formula_outside_a_spec_may_name_it(site: Path) -> None:
    installed(site)
    [phase] = program_of_expression("phi_h|tau_frx(G) sigma_fr(G)").phases
    assert phase.label == "φ_h|τ_frx(Γ) σ_fr(Γ)"


def test_misspelt_names_find_it_unimported(site: Path) -> None:
    installed(site)
    said = [fault for fault in complaints(NAMING.replace("φ_h|", "φ_hh|")) if fault.code == "unknown-potential"]
    assert [fault.hint for fault in said] == ["did you mean φ_h?"]
    assert "kit" not in sys.modules


def test_a_program_holds_what_it_uses(site: Path) -> None:
    before = identities(sound(ORDINARY), 1)(0)
    installed(site)
    used = sound(NAMING)
    [plugin] = used.plugins
    assert (plugin.kind, plugin.name, plugin.distribution, plugin.version) == ("potentials", "φ_h", "kit", "1.0")
    assert sound(ORDINARY).plugins == ()
    assert identities(sound(ORDINARY), 1)(0) == before
    assert identities(used, 1)(0) != identities(used, 1, plugins=())(0)


BROKEN = {
    "cannot be imported": ("import kit_of_nobody", "plugin-broken", "ModuleNotFoundError: No module named"),
    "is no Python": ("class Huber(", "plugin-broken", "SyntaxError: "),
    "leaves": ("import sys\nsys.exit(3)", "plugin-broken", "SystemExit: 3"),
    "raises what is no Exception": ("raise BaseException('so\\nthere')", "plugin-broken", "BaseException: so"),
    "never ends": ("def f():\n    f()\nf()", "plugin-broken", "RecursionError: "),
    "has no such class": ("", "plugin-broken", "has no attribute 'Huber'"),
    "is a function": ("def Huber(): ...", "plugin-unfit", "is no Potential: <function Huber"),
    "is another class": ("class Huber: ...", "plugin-unfit", "is no Potential: <class 'kit.Huber'>"),
    "is not whole": (
        "from graspdsl.basis.potentials import Potential\nclass Huber(Potential):\n    symbol = 'φ_h'",
        "plugin-unfit",
        "does not define gradient and value",
    ),
    "does not say all": (
        "from graspdsl.basis.potentials import HalfSquared\nclass Huber(HalfSquared):\n    symbol = 'φ_h'",
        "plugin-unfit",
        "about is not said; equation is not said",
    ),
    "says it wrongly": (
        HUBER + "    sensors = 'σ_fr'",
        "plugin-unfit",
        "sensors is tuple[str, ...], found 'σ_fr'",
    ),
    "has another name": (HUBER.replace("φ_h", "φ_q"), "plugin-unfit", "calls itself φ_q"),
    "is not made": (
        HUBER + "\n    def __init__(self, edge):\n        pass",
        "plugin-broken",
        "cannot be made: TypeError: Huber.__init__() missing 1 required positional argument: 'edge'",
    ),
    "needs what is not": (HUBER + "    sensors = ('σ_h',)", "plugin-unfit", "needs the sensor transform σ_h"),
}


@pytest.mark.parametrize(("module", "code", "said"), BROKEN.values(), ids=BROKEN)
def test_what_is_broken_is_one_complaint_where_it_is_named(site: Path, module: str, code: str, said: str) -> None:
    installed(site, module)
    [found] = complaints(NAMING)
    assert (found.code, found.severity) == (code, Severity.ERROR)
    assert said in found.message
    assert "kit 1.0" in found.message
    assert "\n" not in found.message
    assert found.span is not None
    line = NAMING.split("\n")[found.span.line - 1]
    assert line[found.span.column - 1 : found.span.end_column - 1] == "φ_h"
    sound(ORDINARY)


def test_of_what_is_broken_and_given_on_the_command_line_the_command_line_is_told(site: Path) -> None:
    installed(site, "raise OSError('no disk')")
    [found] = complaints(ORDINARY, f"program.0.run={FORMULA}")
    assert found.span is None
    assert found.message.startswith("in --set program.0.run=")
    assert "the potential φ_h of kit 1.0 cannot be imported: OSError: no disk" in found.message


def test_what_is_printed_at_import_is_a_warning(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    installed(site, f"print('hello')\n{HUBER}")
    [found] = complaints(NAMING)
    assert (found.code, found.severity) == ("plugin-prints", Severity.WARNING)
    assert found.message == "the potential φ_h of kit 1.0 prints as it is imported: hello"
    assert capsys.readouterr().out == ""


def test_of_two_packages_with_one_name_neither_is_used(site: Path) -> None:
    installed(site)
    installed(site, offers={"potentials": {"φ_h": "kit2:Huber"}}, name="kit2", version="7")
    [found] = complaints(NAMING)
    assert (found.code, found.message) == ("plugin-clash", "kit 1.0 and kit2 7 each have a potential φ_h")
    sound(ORDINARY)
    [listed] = adopted_all(["potentials"])
    assert (listed.code, listed.severity) == ("plugin-clash", Severity.WARNING)


def test_the_built_in_one_of_a_name_is_used(site: Path) -> None:
    installed(site, HUBER, {"potentials": {**PHI["potentials"], "phi_fr": "kit:Huber"}})
    sound(ORDINARY)
    both = floating(f"{FORMULA} ◁ {FORMULA.replace('φ_h', 'φ_fr')}")
    [found] = [said for said in complaints(both) if said.code.startswith("plugin")]
    assert found.message == "the potential φ_fr of kit 1.0 is passed over: graspdsl has one of that name"
    assert (found.code, found.severity) == ("plugin-passed-over", Severity.WARNING)


def test_what_a_run_had_is_told_where_its_spec_is(site: Path, tmp_path: Path) -> None:
    """Elsewhere it is an unknown name as any other."""
    [usual] = complaints(NAMING)
    assert usual.code == "unknown-potential"
    held = {"kind": "potentials", "name": "φ_h", "distribution": "kit", "version": "1.0", "digest": "0"}
    (tmp_path / "run.json").write_text(json.dumps({"plugins": [held]}), "utf-8")
    for folder in (tmp_path, tmp_path / "files"):
        [found] = complaints(NAMING, folder=folder)
        assert (found.code, found.span) == ("plugin-missing", usual.span)
        assert found.message == ("this run was made with kit 1.0, which is not installed now: the potential φ_h")
        assert found.hint == "pip install kit==1.0"
    installed(site, offers={}, version="2.0")
    [other] = complaints(NAMING, folder=tmp_path)
    assert "kit 2.0, which is installed now, has not" in other.message
    (tmp_path / "run.json").write_text('{"plugins": [{"kind": 3}]}', "utf-8")
    assert complaints(NAMING, folder=tmp_path) == (usual,)


CONTROLLERS = """\
controllers:
  π_one|Γ_τ Γ_σ: {is: π_two|Γ_τ Γ_σ, equation: "1", about: one}
  π_two|Γ_τ Γ_σ: {is: φ_h|τ_frx(Γ_τ) σ_fr(Γ_σ), equation: "2", about: two}
"""
PIS = {"controllers": {"pi_one": "kit.data:laws.yaml", "pi_two": "kit.data:laws.yaml"}}
ONE = floating(f"π_one|{THREE} {THREE}", until="force_residual: 0.05")


def test_a_controller_brings_what_its_formula_names(site: Path) -> None:
    installed(site, HUBER, {**PHI, **PIS}, data={"data/laws.yaml": CONTROLLERS})
    used = sound(ONE)
    assert [plugin.name for plugin in used.plugins] == ["π_one", "π_two", "φ_h"]
    assert sound(ONE).plugins == used.plugins
    assert used.definitions["π_two"].by == "kit 1.0"
    assert "π_one" not in sound(ORDINARY).definitions


def test_a_controller_of_the_spec_is_not_looked_for(site: Path) -> None:
    """But is redefined where a package's controller is used that stands on one of its name."""
    installed(site, HUBER, {**PHI, **PIS}, data={"data/laws.yaml": CONTROLLERS})
    own = {"π_two|Γ_τ Γ_σ": "φ_fr|τ_frx(Γ_τ) σ_fr(Γ_σ)"}
    assert sound(floating(f"π_two|{THREE} {THREE}", controllers=own)).plugins == ()
    [found] = complaints(floating(f"π_one|{THREE} {THREE}", controllers=own))
    assert (found.code, found.message) == ("controller-redefined", "π_two is defined already, by kit 1.0")


FAULTY = {
    "no such file": ({}, "plugin-broken", "there is no kit.data:laws.yaml"),
    "no YAML": ({"data/laws.yaml": "controllers: {"}, "plugin-broken", "laws.yaml:1:"),
    "a wrong key": ({"data/laws.yaml": "laws: {}"}, "plugin-broken", "laws.yaml:1:1: the file has no key 'laws'"),
    "no formula": (
        {"data/laws.yaml": "controllers:\n  π_one|Γ_τ Γ_σ: φ_h|"},
        "plugin-broken",
        "laws.yaml:2:",
    ),
    "other names": (
        {"data/laws.yaml": "controllers:\n  π_three|Γ Γ: π_gx|Γ Γ"},
        "plugin-unfit",
        "is not in laws.yaml, which has π_three",
    ),
}


@pytest.mark.parametrize(("data", "code", "said"), FAULTY.values(), ids=FAULTY)
def test_faults_of_a_file_are_told_with_their_places(site: Path, data: dict[str, str], code: str, said: str) -> None:
    installed(site, None, PIS, data=data)
    found = complaints(ONE)
    assert {each.code for each in found} == {code}
    assert {each.span for each in found} != {None}
    assert any(said in each.message and "controller π_one of kit 1.0" in each.message for each in found)
    sound(ORDINARY)


def test_a_world_that_does_not_say_what_it_senses_is_one_complaint(site: Path) -> None:
    world = "from graspdsl.worlds.floating import Floating\nclass Sea(Floating):\n    name = 'sea'\n    {}"
    installed(site, world.format("senses = property(lambda self: self.depth)"), {"worlds": {"sea": "kit:Sea"}})
    text = ORDINARY.replace("world: floating", "world: sea")
    [found] = complaints(text)
    assert (found.code, found.message) == (
        "plugin-broken",
        "the world sea of kit 1.0 does not say what it needs: AttributeError: 'Sea' object has no attribute 'depth'",
    )


def test_what_is_left_of_a_package_offers_nothing(site: Path) -> None:
    installed(site)
    (site / "kit-1.0.dist-info" / "METADATA").unlink()
    assert offered() == ()
    assert [found.code for found in complaints(NAMING)] == ["unknown-potential"]


def test_a_formula_that_cannot_be_used_says_so(site: Path) -> None:
    installed(site, "raise OSError('no disk')")
    with pytest.raises(DiagnosticError, match="no disk"):
        program_of_expression("φ_h|τ_frx(Γ) σ_fr(Γ)")


UNREADABLE = {
    "a name": ("METADATA", b"Metadata-Version: 2.1\nName: k\xff\nVersion: 1\n"),
    "entries": ("entry_points.txt", b"[graspdsl.potentials]\nphi_h = kit:\xff\n"),
    "lines": ("entry_points.txt", b"[graspdsl.potentials\n[graspdsl.potentials]\nphi_h\n"),
}


@pytest.mark.parametrize(("file", "content"), UNREADABLE.values(), ids=UNREADABLE)
def test_a_package_that_cannot_be_read_offers_nothing_and_harms_no_other(site: Path, file: str, content: bytes) -> None:
    installed(site)
    (site / "kit-1.0.dist-info" / file).write_bytes(content)
    installed(site, offers={"potentials": {"phi_h": "kit2:Huber"}}, name="kit2")
    assert [offer.by for offer in offered()] == ["kit2 1.0"]
    [plugin] = sound(NAMING).plugins
    assert plugin.by == "kit2 1.0"
    assert CliRunner().invoke(app, ["check-plugin", "kit3"]).exit_code == 1
