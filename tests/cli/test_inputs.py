"""Wrong input: exit code 1, every fault with its place, one JSON document when asked for."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cli.program import ROOT, SPEC, codes, graspdsl
from graspdsl.cli.app import app

pytestmark = pytest.mark.slow

MOUNTS = ROOT / "tests" / "plugin" / "src" / "graspdsl_stranger" / "mounts"
FORMULA = "π_s|Γ Γ (π_gx|Γ Γ)"

# What replaces what in the shipped spec, and the complaints it gets.
FAULTS = {
    "unknown potential": (FORMULA, "φ_xr|τ_p(Γ) σ_p(Γ)", ["unknown-potential"]),
    "mixed spaces": (FORMULA, "φ_fr|τ_fr(Γ) σ_fr(Γ) ◁ φ_mr|τ_mrx(Γ) σ_mr(Γ)", ["mixed-spaces"]),
    "gravity moved": (FORMULA, "φ_p|τ_p({γ1, γ_g}) σ_p(Γ) (π_gx|Γ Γ)", ["gravity-effector"]),
    "no such finger": ("finger-2", "finger-9", ["unknown-contact"]),
    "empty virtual contact": ("{γ1, <γ2, γ3>}", "{γ1, <>}", ["empty-virtual-contact"]),
    "reference of another space": (FORMULA, "φ_p|τ_p(Γ) σ_p(Γ) (π_g|Γ Γ)", ["wrong-reference"]),
    "unbalanced bracket": (FORMULA, "π_s|Γ Γ (π_gx|Γ Γ", ["unbalanced-bracket"]),
    "bad YAML": ("scene:", "scene: [", ["open-bracket"]),
    "wrong type": ("friction: 0.4", "friction: much", ["wrong-type"]),
    "three at once": (
        "friction: 0.4",
        "friction: much\n  colour: red\n  hand: barrett",
        ["wrong-type", "unknown-key", "duplicate-key"],
    ),
}


def _written(folder: Path, old: str, new: str) -> Path:
    text = SPEC.read_text(encoding="utf-8")
    assert old in text
    path = folder / "spec.yaml"
    path.write_text(text.replace(old, new), encoding="utf-8")
    return path


@pytest.mark.parametrize("fault", FAULTS)
def test_run_refuses_what_validate_complains_of(fault: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    old, new, expected = FAULTS[fault]
    _written(tmp_path, old, new)
    answers = {name: CliRunner().invoke(app, [name, "spec.yaml", "--json"]) for name in ("validate", "run", "explain")}
    (file,) = json.loads(answers["validate"].stdout)["files"]
    found = [diagnostic["code"] for diagnostic in file["diagnostics"]]
    assert found == expected
    assert answers["validate"].stderr == ""
    for answer in answers.values():
        assert answer.exit_code == 1
        assert json.loads(answer.stdout) == json.loads(answers["validate"].stdout)
    text = CliRunner().invoke(app, ["validate", "spec.yaml"]).stdout
    for code in found:
        assert f"error[{code}]" in text
        assert f"error[{code}]" in answers["run"].stderr
    assert [path.name for path in tmp_path.iterdir()] == ["spec.yaml"]


def test_the_text_of_a_complaint(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    _written(tmp_path, FORMULA, "φ_p|τ_p(Γ) σ_p(Γ) (π_g|Γ Γ)")
    answer = CliRunner().invoke(app, ["validate", "spec.yaml"])
    assert answer.stdout == (
        "spec.yaml:27:29: error[wrong-reference]: φ_p needs a reference in contact positions (m); this one is a "
        "gradient in ψ, surface coordinates of the contacts (rad on the model sphere)\n"
        "  27 |   - run: φ_p|τ_p(Γ) σ_p(Γ) (π_g|Γ Γ)\n"
        "     |                             ^^^^^^^\n"
        "  hint: use a controller whose gradient is in Cartesian displacements of the contacts (m), as π_gx is\n"
    )


@pytest.mark.parametrize("command", ["validate", "run", "explain"])
@pytest.mark.parametrize(
    ("name", "code"),
    [
        ("missing.yaml", "file-not-found"),
        ("folder", "is-a-directory"),
        ("pipe", "not-a-file"),
        ("/dev/null", "not-a-file"),
        ("binary.yaml", "not-utf8"),
        ("utf16.yaml", "not-utf8"),
        ("brackets.yaml", "file-too-large"),
        ("empty.yaml", "empty-file"),
    ],
)
def test_files_that_are_no_specs(
    command: str, name: str, code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("folder").mkdir()
    os.mkfifo("pipe")
    Path("binary.yaml").write_bytes(bytes(range(256)))
    Path("utf16.yaml").write_text("graspdsl: 1", encoding="utf-16")
    Path("brackets.yaml").write_bytes(b"[" * 10_000_000)
    Path("empty.yaml").touch()
    answer = CliRunner().invoke(app, [command, name, "--json"])
    (file,) = json.loads(answer.stdout)["files"]
    assert answer.exit_code == 1
    assert (file["path"], file["ok"], [fault["code"] for fault in file["diagnostics"]]) == (name, False, [code])


def test_settings_are_checked_like_the_file(tmp_path: Path) -> None:
    settings = ["nonsense", "=3", "trials.count=[", "foo.bar=1", "scene.friction=abc", "trials=7"]
    words = [word for setting in settings for word in ("--set", setting)]
    answer = graspdsl("run", SPEC, *words, "--json", cwd=tmp_path)
    assert answer.returncode == 1
    assert sorted(codes(answer)) == [
        "bad-override", "bad-override", "open-bracket", "unknown-key", "wrong-type", "wrong-type",
    ]  # fmt: skip
    for setting in settings:
        assert f"in --set {setting}: " in answer.stderr
    assert list(tmp_path.iterdir()) == []


def test_several_files_some_sound(tmp_path: Path) -> None:
    answer = graspdsl("validate", SPEC, "missing.yaml", cwd=tmp_path)
    assert answer.returncode == 1
    assert answer.stdout.splitlines()[:2] == [
        f"{SPEC}: ok",
        "missing.yaml: error[file-not-found]: there is no such file",
    ]


def test_a_sound_spec(tmp_path: Path) -> None:
    answer = graspdsl("validate", SPEC, "--json", cwd=tmp_path)
    assert json.loads(answer.stdout) == {"files": [{"path": str(SPEC), "ok": True, "diagnostics": []}]}
    assert (answer.returncode, answer.stderr) == (0, "")


def test_a_mount_file_is_checked_as_such(tmp_path: Path) -> None:
    for file in ("portal.yaml", "portal.urdf"):
        shutil.copy(MOUNTS / file, tmp_path)
    assert graspdsl("validate", "portal.yaml", cwd=tmp_path).stdout == "portal.yaml: ok\n"
    text = (tmp_path / "portal.yaml").read_text("utf-8")
    (tmp_path / "portal.yaml").write_text(text.replace("face: flange", "face: flang"), "utf-8")
    answer = graspdsl("validate", "portal.yaml", cwd=tmp_path)
    assert answer.returncode == 1
    place = text.split("\n").index("face: flange") + 1
    assert answer.stdout.startswith(f"portal.yaml:{place}:7: error[unknown-link]: there is no link 'flang'\n")


def test_names_of_files_do_not_steer_the_terminal(tmp_path: Path) -> None:
    answer = graspdsl("validate", "\x1b[31mred.yaml", cwd=tmp_path)
    assert answer.returncode == 1
    assert answer.stdout.startswith("\ufffd[31mred.yaml: error[file-not-found]")


FORGED = "spec.yaml: ok"
NAME = "".join(f"x{mark}{FORGED}" for mark in ("\n", "\r\n", "\r", "\u2028", "\x85", "\x1b[2K\r", "\x0b"))


@pytest.mark.parametrize(
    "words",
    [
        ("validate", "{}"),
        ("validate", "{}.yaml"),
        ("run", "{}"),
        ("run", "--resume", "{}"),
        ("report", "{}"),
        ("compare", "{}", "{}"),
        ("runs", "{}"),
        ("export", "{}", "--to", "x.csv"),
        ("export", "x", "--to", "{}"),
        ("doctor", "{}"),
        ("diff", "{}", "{}"),
        ("rm", "{}", "--yes"),
        ("explain", "{}.yaml"),
        ("explain", "π_a|{}"),
        ("view", "{}", "--images", "seen"),
        ("view", "--object", "{}.stl", "--images", "seen"),
        ("view", "--hand", "{}.yaml", "--images", "seen"),
        ("run", str(SPEC), "--set", "scene.object={}"),
        ("run", str(SPEC), "--set", "scene.hand={}.yaml"),
        ("run", str(SPEC), "--set", "{}=1"),
        ("run", str(SPEC), "--set", 'scene.object={{mesh: {{file: "{}"}}}}'),
        ("map", "{}", "--over", "height"),
        ("list", "{}"),
        ("{}",),
    ],
)
def test_no_name_forges_a_line(words: tuple[str, ...], tmp_path: Path) -> None:
    answer = graspdsl(*(word.format(NAME) for word in words), cwd=tmp_path)
    assert answer.returncode in (1, 2)
    said = answer.stdout + answer.stderr
    assert not set("\r\x0b\x1b\x85\u2028") & set(said)
    assert not any(line.startswith(FORGED) for line in said.split("\n"))


def test_names_of_sound_specs_and_runs_forge_no_line(tmp_path: Path) -> None:
    folder = tmp_path / "x\nforged: ok"
    folder.mkdir()
    (folder / "spec.yaml").write_text(
        (ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml").read_text("utf-8"), encoding="utf-8"
    )
    spec = f"{folder.name}/spec.yaml"
    answers = [
        graspdsl("validate", spec, cwd=tmp_path),
        graspdsl("run", spec, "--trials", "1", "--out", "a\nforged: ok", cwd=tmp_path),
        graspdsl("report", "a\nforged: ok", cwd=tmp_path),
        graspdsl("compare", "a\nforged: ok", "a\nforged: ok", "--out", "b\nforged: ok", cwd=tmp_path),
    ]
    assert [answer.returncode for answer in answers] == [0] * 4
    for answer in answers:
        assert "x\ufffdforged" in answer.stdout + answer.stderr or "a\ufffdforged" in answer.stdout + answer.stderr
        assert not any(line.startswith("forged") for line in (answer.stdout + answer.stderr).split("\n"))
    as_json = graspdsl("validate", spec, "--json", cwd=tmp_path)
    assert json.loads(as_json.stdout)["files"][0]["path"] == spec


HEAVY = {"pybullet", "mujoco", "jax", "casadi", "trimesh", "matplotlib"}
# What a spec has no use for that names no grades and no files, of a hand that is not an arm.
UNNAMED = {"numpy.random", "graspdsl.quality.grades", "graspdsl.models.reading", "graspdsl.objects.mesh_files"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("command", "besides"),
    [
        (("validate", str(SPEC)), {*UNNAMED, "rich", "xml.sax.saxutils", "graspdsl.contracts.kinds"}),
        (("explain", str(SPEC)), {*UNNAMED, "rich", "xml.sax.saxutils", "graspdsl.contracts.kinds"}),
        (("list",), {"xml.sax.saxutils", "graspdsl.trials.runner"}),
        (("list", "effectors"), {*UNNAMED, "xml.sax.saxutils", "graspdsl.trials.runner", "graspdsl.contracts.kinds"}),
        (("--help",), {"rich", "numpy", "yaml", "lark", "graspdsl.compiler.program"}),
    ],
)
def test_what_reads_and_tells_loads_no_simulator_no_figures_and_no_store(
    command: tuple[str, ...], besides: set[str]
) -> None:
    assert _loaded(command, {*HEAVY, "scipy", "sqlite3", "multiprocessing", *besides}) == ["0", "[]"]


@pytest.mark.slow
def test_what_lists_runs_loads_no_simulator_and_no_figures(tmp_path: Path) -> None:
    assert _loaded(("runs", str(tmp_path)), HEAVY) == ["0", "[]"]


def _loaded(command: tuple[str, ...], heavy: set[str]) -> list[str]:
    """The exit code of a command, and which of these modules it imports."""
    code = f"""
import sys
from graspdsl.cli import main
sys.argv[1:] = {list(command)}
try:
    main()
except SystemExit as end:
    print("", end.code or 0, sorted(name for name in {heavy} if name in sys.modules), sep="\\n")
"""
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    return answer.stdout.splitlines()[-2:]
