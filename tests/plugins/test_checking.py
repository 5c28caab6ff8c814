"""check-plugin and list: what they say of sound and of broken packages and files."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from graspdsl.cli.checking import check_plugin
from graspdsl.cli.listing import show_list
from graspdsl.diagnostics import DiagnosticError

from .packages import HUBER, PHI, installed

STEEP = HUBER + "\n    def gradient(self, error):\n        print('hm')\n        return 3.0 * error\n"


def entries(what: str, capsys: pytest.CaptureFixture[str]) -> dict[str, list[str]]:
    """The codes of what is wrong with each thing of a package or a file, with the exit code that this means."""
    code = check_plugin(what, as_json=True)
    found = json.loads(capsys.readouterr().out)
    assert code == (0 if found["ok"] else 1)
    return {
        f"{entry['kind']} {entry['name']}": [diagnostic["code"] for diagnostic in entry["diagnostics"]]
        for entry in found["entries"]
    }


@pytest.mark.slow
def test_a_breach_is_told(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    installed(site, STEEP)
    found = entries("kit", capsys)
    assert "contract-gradient" in found["potentials φ_h"]
    assert check_plugin("Kit", as_json=False) == 1
    said = capsys.readouterr()
    assert said.out.startswith("potential φ_h (kit:Huber): ")
    assert "hm" not in said.out


@pytest.mark.slow
def test_a_fault_of_wording_is_a_warning(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    installed(site, HUBER.replace("φ_h: another force residual.", "Another."))
    assert check_plugin("kit", as_json=False) == 0
    first, *told = capsys.readouterr().out.splitlines()
    assert re.fullmatch(r"potential φ_h \(kit:Huber\): ok, \d+ rules, 3 warnings", first)
    assert sum(line.startswith("kit: warning[contract-docstring]: ") for line in told) == 3


def test_what_cannot_be_used_is_told_of_each(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    offers = {
        "potentials": {**PHI["potentials"], "phi_q": "kit:Gone", "phi_fr": "kit:Huber"},
        "grades": {"g": "kit:Huber"},
    }
    installed(site, HUBER, offers)
    installed(site, None, {"grades": {"g": "kit2:G"}}, name="kit2")
    found = entries("kit", capsys)
    assert found["potentials φ_q"] == ["plugin-broken"]
    assert found["potentials φ_fr"] == ["plugin-passed-over"]
    assert found["grades g"] == ["plugin-clash"]


@pytest.mark.parametrize(
    ("what", "code", "said"),
    [
        ("kitt", "unknown-plugin", "no package 'kitt' is installed"),
        ("kit", "nothing-offered", "kit offers nothing to graspdsl"),
        ("kit.py", "file-not-found", "there is no file kit.py"),
        ("kit.yaml", "file-not-found", "there is no such file"),
    ],
)
def test_what_is_nothing_to_check_is_told(site: Path, what: str, code: str, said: str) -> None:
    installed(site, None, {})
    with pytest.raises(DiagnosticError) as error:
        check_plugin(what, as_json=True)
    [found] = error.value.diagnostics
    assert (found.code, said in found.message, error.value.name) == (code, True, what)


@pytest.mark.slow
def test_a_file_is_checked_as_a_package_is(site: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    del site
    (tmp_path / "mine.py").write_text(STEEP, "utf-8")
    assert "contract-gradient" in entries(str(tmp_path / "mine.py"), capsys)["potentials φ_h"]
    (tmp_path / "laws.yaml").write_text(
        "controllers:\n  π_one|Γ Γ: {is: π_two|Γ Γ, equation: '1', about: one}\n"
        "  π_two|Γ Γ: {is: π_gx|Γ Γ, equation: '2', about: two}\n  π_three|Γ Γ: φ_none|τ_frx(Γ) σ_fr(Γ)\n",
        "utf-8",
    )
    found = entries(str(tmp_path / "laws.yaml"), capsys)
    assert found == {"controllers π_one": [], "controllers π_two": [], "controllers π_three": ["plugin-unfit"]}


def test_lists_tell_of_what_cannot_be_listed(site: Path, capsys: pytest.CaptureFixture[str]) -> None:
    installed(site, "raise OSError('no disk')")
    show_list("potentials", as_json=True)
    said = capsys.readouterr()
    assert {entry["from"] for entry in json.loads(said.out)["potentials"]} == {"graspdsl"}
    assert "warning[plugin-broken]: the potential φ_h of kit 1.0 cannot be imported: OSError: no disk" in said.err
    show_list("sensors", as_json=True)
    assert capsys.readouterr().err == ""
