"""A stranger's package, built and installed: everything in it is listed, checked, run and told, until it is gone."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
from cli.program import ROOT, TIMEOUT

from cli import warm

pytestmark = pytest.mark.slow

PACKAGE = ROOT / "tests" / "plugin"
OFFERED = {
    group.removeprefix("graspdsl."): list(entries)
    for group, entries in tomllib.loads((PACKAGE / "pyproject.toml").read_text("utf-8"))["project"][
        "entry-points"
    ].items()
}
# Between them they name one of each kind.
GLIDING = """\
graspdsl: 1
name: gliding
scene: {world: gliding, hand: points, object: {cup: {bottom: 0.06, top: 0.09, height: 0.11}}}
resources: {γ1: point-1, γ2: point-2, γ3: point-3, Γ: "{γ1, γ2, γ3}"}
program:
  - {run: π_gc|Γ Γ, until: {force_residual: 0.1, hold: 0.2}, limit: 5.0}
monitors: {rebound: 0.02}
evaluate: [isotropy]
trials: {count: 2, seed: 3}
"""
GRIPPING = """\
graspdsl: 1
name: gripping
scene: {world: bullet, hand: parallel-jaw, mount: portal, object: juice-carton, sensing: force-cell}
resources: {γ1: left, γ2: right, Γ: "{γ1, γ2}"}
parameters: {κ_f: 0.5}
program:
  - {run: π_close|Γ Γ, until: {contact: all, hold: 0.2}, limit: 8.0}
trials: {count: 2, seed: 3, start: {height: {uniform: [0.06, 0.08]}}}
"""
SPECS = {"gliding": GLIDING, "gripping": GRIPPING}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where it is installed, beside nothing else."""
    place = tmp_path_factory.mktemp("stranger")
    shutil.copytree(PACKAGE, place / "source", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--target", str(place / "site")]
    subprocess.run([*pip, str(place / "source")], check=True)
    return place / "site"


def graspdsl(*words: str | Path, cwd: Path, site: Path | None) -> subprocess.CompletedProcess[str]:
    """What the program answers where packages are at a place."""
    return warm.run([*map(str, words)], cwd, TIMEOUT, *([] if site is None else [site]))


def document(*words: str | Path, cwd: Path, site: Path | None) -> dict[str, Any]:
    """The JSON document that it answers."""
    done = graspdsl(*words, "--json", cwd=cwd, site=site)
    assert done.returncode == 0, done.stderr
    found: dict[str, Any] = json.loads(done.stdout)
    return found


@pytest.fixture(scope="module")
def runs(site: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the specs are, and a run of each by two workers with what was said at its end."""
    place = tmp_path_factory.mktemp("runs")
    for name, text in SPECS.items():
        (place / f"{name}.yaml").write_text(text, "utf-8")
        said = document("run", f"{name}.yaml", "--workers", "2", "--out", name, cwd=place, site=site)
        (place / f"{name}.json").write_text(json.dumps(said), "utf-8")
    return place


def test_there_is_one_of_each_kind(site: Path) -> None:
    from graspdsl.plugins.kinds import KINDS

    assert OFFERED.keys() == KINDS.keys()
    noted = next(site.glob("*.dist-info/entry_points.txt")).read_text("utf-8")
    assert set(re.findall(r"^\[graspdsl\.(\w+)\]", noted, flags=re.M)) == OFFERED.keys()


def test_it_keeps_its_contracts(site: Path, tmp_path: Path) -> None:
    found = document("check-plugin", "graspdsl_stranger", cwd=tmp_path, site=site)
    assert found["ok"]
    assert len(found["entries"]) == sum(map(len, OFFERED.values()))
    assert [entry for entry in found["entries"] if entry["diagnostics"]] == []


def test_it_is_listed_with_where_it_is_from(site: Path, tmp_path: Path) -> None:
    for kind in ("controllers", "sensing"):
        [listed] = document("list", kind, cwd=tmp_path, site=site).values()
        theirs = [entry for entry in listed if entry["from"] == "graspdsl-stranger 0.1"]
        assert len(theirs) == len(OFFERED["touch" if kind == "sensing" else kind])
        assert {entry["from"] for entry in listed if entry not in theirs} == {"graspdsl"}


def test_it_is_in_the_schema(site: Path, tmp_path: Path) -> None:
    schema = json.loads(graspdsl("schema", cwd=tmp_path, site=site).stdout)
    parts = schema["$defs"]
    assert {"gliding"} <= set(parts["Scene"]["properties"]["world"]["enum"])
    assert {"portal"} <= set(parts["Scene"]["properties"]["mount"]["anyOf"][0]["enum"])
    assert "isotropy" in schema["properties"]["evaluate"]["items"]["enum"]
    assert "cup" in parts["InlineObject"]["properties"]
    assert "force-cell" in parts["Sensing"]["properties"]
    assert "rebound" in parts["MonitorBounds"]["properties"]


def test_specs_that_name_it_are_sound_and_explained(site: Path, runs: Path) -> None:
    found = document("validate", *(f"{name}.yaml" for name in SPECS), cwd=runs, site=site)
    assert [file["diagnostics"] for file in found["files"]] == [[], []]
    text = graspdsl("explain", "gliding.yaml", cwd=runs, site=site).stdout
    assert "centring: the contacts' centroid" in text
    assert "Roa and Suárez 2015" in text


def test_runs_keep_what_they_use(runs: Path) -> None:
    used: dict[str, set[str]] = {}
    for name in SPECS:
        for plugin in json.loads((runs / name / "run.json").read_text("utf-8"))["plugins"]:
            assert (plugin["distribution"], plugin["version"]) == ("graspdsl-stranger", "0.1")
            used.setdefault(plugin["kind"], set()).add(plugin["name"])
    assert used.keys() == OFFERED.keys()


def test_runs_are_reported(site: Path, runs: Path) -> None:
    gliding, gripping = (json.loads((runs / f"{name}.json").read_text("utf-8")) for name in SPECS)
    assert document("report", "gliding", cwd=runs, site=site) == gliding
    assert gliding["versions"]["graspdsl-stranger"] == "0.1"
    assert gliding["outcomes"].keys() & {"rebounded", "converged"}
    assert "isotropy" in gliding["quality"]
    assert gripping["outcomes"] == {"converged": 2}
    page = (runs / "gliding" / "report.html").read_text("utf-8")
    assert "Grasp isotropy index" in page


def test_other_files_of_one_version_are_other_plugins(site: Path, runs: Path, tmp_path: Path) -> None:
    """A run does not go on with them."""
    shutil.copytree(site, tmp_path / "site")
    changed = tmp_path / "site" / "graspdsl_stranger" / "potential.py"
    changed.write_text(f"{changed.read_text('utf-8')}\n# changed\n", "utf-8")
    done = graspdsl("run", "--resume", "gliding", cwd=runs, site=tmp_path / "site")
    assert done.returncode == 1
    assert "error[run-differs]: this run was made with graspdsl-stranger 0.1; now there is " in done.stderr
    assert "graspdsl-stranger 0.1 with another φ_c" in done.stderr
    told = graspdsl("report", "gliding", cwd=runs, site=tmp_path / "site")
    assert told.returncode == 0
    assert "warning[run-unchecked]: this run was made with graspdsl-stranger 0.1; now there is " in told.stderr


def test_once_it_is_gone_runs_say_what_had_it(runs: Path) -> None:
    for words in (("report", "gliding"), ("run", "--resume", "gliding"), ("validate", "gliding/spec.yaml")):
        done = graspdsl(*words, cwd=runs, site=None)
        said = done.stdout + done.stderr
        assert done.returncode == 1
        assert re.findall(r"error\[([\w-]+)\]", said) == ["plugin-missing"]
        assert "this run was made with graspdsl-stranger 0.1, which is not installed now: the world gliding" in said
        assert "hint: pip install graspdsl-stranger==0.1" in said
    elsewhere = graspdsl("validate", "gliding.yaml", cwd=runs, site=None).stdout
    assert "plugin-missing" not in elsewhere
    assert "there is no controller π_gc" in elsewhere


def test_code_of_a_spec_needs_leave(site: Path, tmp_path: Path) -> None:
    """To be run, and again for whoever opens the run."""
    shutil.copy(site / "graspdsl_stranger" / "shape.py", tmp_path / "cup.py")
    text = GLIDING.replace("world: gliding", "world: floating").replace("π_gc|", "π_gx|").replace("[isotropy]", "[]")
    text = re.sub(r"monitors: .*\n", "", text) + "code: [cup.py]\n"
    (tmp_path / "spec.yaml").write_text(text, "utf-8")
    run = ("run", "spec.yaml", "--workers", "2", "--out", "run")
    done = graspdsl(*run, "--allow-code", cwd=tmp_path, site=None)
    assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip().endswith("--allow-code")
    assert (tmp_path / "run" / "files" / "cup.py").exists()
    document("validate", "run/spec.yaml", "--allow-code", cwd=tmp_path, site=None)
    for words in (run, ("report", "run"), ("run", "--resume", "run"), ("validate", "run/spec.yaml")):
        refused = graspdsl(*words, cwd=tmp_path, site=None)
        assert refused.returncode == 1
        assert re.findall(r"error\[([\w-]+)\]", refused.stdout + refused.stderr) == ["code-not-allowed"]
