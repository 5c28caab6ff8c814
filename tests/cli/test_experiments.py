"""The chapter's experiments by one command."""

from __future__ import annotations

import json
import shlex
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from report.reader import untold
from typer.testing import CliRunner

from graspdsl.cli.app import app
from graspdsl.trials.identity import identities
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.store import RunFolder

from .program import ROOT, codes, graspdsl, interrupt, stopped

SPECS = ROOT / "specs" / "experiments"
SPEC = SPECS / "4_detergent_bottle.yaml"
SETTINGS = ("evaluate=[]", "scene.world=mujoco", "scene.mount=gantry", "program.1.full_time=false")
QUICK = (*(w for s in SETTINGS for w in ("--set", s)), "--trials", "2", "--seed", "9", "--workers", "1")


@pytest.fixture(scope="module")
def ended(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which experiment 4 was run with QUICK settings as ``all``; not to be changed."""
    place = tmp_path_factory.mktemp("experiments")
    done = graspdsl("experiments", SPEC, *QUICK, "--out", "all", "--json", cwd=place)
    assert done.returncode == 0, done.stderr
    (place / "answer.json").write_text(done.stdout, "utf-8")
    return place


@pytest.fixture
def copied(ended: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it in the working directory."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ended / "all", tmp_path / "all")
    return tmp_path / "all"


def asked(*words: str | Path) -> tuple[int, str]:
    """What the command answers: its exit code, and what it says on stderr."""
    answer = CliRunner().invoke(app, ["experiments", *map(str, words)])
    return answer.exit_code, answer.stderr


def named(folder: Path, file: str, *changes: tuple[str, str]) -> Path:
    """The spec of experiment 4 with changes."""
    text = SPEC.read_text("utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / file).write_text(text, "utf-8")
    return Path(file)


@pytest.mark.slow
def test_claims_and_pages(ended: Path) -> None:
    claims = json.loads((ended / "answer.json").read_text("utf-8"))["claims"]
    assert {claim["experiment"] for claim in claims} == {"experiment-4"}
    assert json.loads((ended / "all" / "conformance.json").read_text("utf-8")) == claims
    page = (ended / "all" / "report.html").read_text("utf-8")
    assert all(claim["says"] in page for claim in claims)
    assert all(claim["could_fail"] in page for claim in claims)
    assert untold(page, claims) == set()
    assert "no evidence" in {claim["verdict"] for claim in claims}
    assert "experiment-4/report.html" in page
    assert claims[0]["says"] in (ended / "all" / "experiment-4" / "report.html").read_text("utf-8")


def test_a_run_knows_the_name_of_its_spec_not_where_it_was(ended: Path) -> None:
    manifest = json.loads((ended / "all" / "experiment-4" / "run.json").read_text("utf-8"))
    assert manifest["spec_file"] == SPEC.name


@pytest.mark.slow
def test_what_was_run_before_is_not_run_again(copied: Path) -> None:
    answer = CliRunner().invoke(app, ["experiments", str(SPEC), *QUICK, "--out", "all"])
    assert answer.exit_code == 0, answer.stderr
    assert "2 finished before" in answer.stderr
    assert "points agree" in answer.stdout
    del copied


@pytest.mark.slow
def test_a_spec_without_claims_is_refused(tmp_path: Path) -> None:
    done = graspdsl(
        "experiments", str(ROOT / "specs" / "towel_roll_two_contacts.yaml"), "--out", str(tmp_path / "x"), cwd=tmp_path
    )
    assert done.returncode == 1
    assert "no claims about" in done.stderr
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("object: detergent-bottle", "object: squirt-bottle", "its object is squirt-bottle, not detergent-bottle"),
        ("{γ1, <γ2, γ3>}", "{γ1, γ2, γ3}", "{finger-1, finger-2, finger-3}, not on {<finger-1, finger-2>, finger-3}"),
        ("approach: side", "approach: top", "the hand comes from the top"),
    ],
)
def test_the_name_alone_makes_no_experiment(
    old: str, new: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    code, messages = asked(named(tmp_path, "mine.yaml", (old, new)), *QUICK, "--out", "x")
    assert code == 1
    assert "mine.yaml:3:7: error[other-experiment]: this is not the chapter's experiment-4" in messages
    assert said in messages
    assert messages.count("error[") == 1
    assert not Path("x").exists()


@pytest.mark.slow
def test_a_run_that_is_no_experiment_has_a_page_without_claims(tmp_path: Path) -> None:
    named(tmp_path, "mine.yaml", ("object: detergent-bottle", "object: squirt-bottle"))
    quick = ("--set", "evaluate=[]", "--set", "scene.mount=gantry", "--set", "program.1.limit=0.1", "--trials", "1")
    done = graspdsl("run", "mine.yaml", *quick, "--out", "run", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "claims about experiment-4 are not asked of this run: its object is squirt-bottle" in done.stderr
    assert "perpendicular to the major axis" not in (tmp_path / "run" / "report.html").read_text("utf-8")


def test_specs_of_one_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    first = named(tmp_path, "a.yaml")
    second = named(tmp_path, "b.yaml", ("graspdsl: 1\n", "graspdsl: 1\n# with more friction\n"), ("0.4", "0.6"))
    code, messages = asked(first, second, "--out", "x")
    assert code == 1
    assert messages.startswith(
        "b.yaml:4:7: error[same-name]: this spec and a.yaml, line 3, share the name experiment-4\n"
    )
    code, messages = asked(first, Path("a.yaml").absolute(), "--out", "x")
    assert code == 1
    assert "error[experiment-twice]: this spec is given twice" in messages
    assert not Path("x").exists()


@pytest.mark.parametrize(
    ("changes", "words", "code", "said"),
    [
        ((), ("--seed", "8"), "run-differs", "begun with other settings: --set 'evaluate=[]'"),
        ((("friction: 0.4", "friction: 0.5"),), (), "run-differs", "begun from another spec than 4.yaml"),
    ],
)
def test_runs_of_something_else_are_found_before_the_first_trial(
    changes: tuple[tuple[str, str], ...], words: tuple[str, ...], code: str, said: str, copied: Path
) -> None:
    last = named(copied.parent, "4.yaml", *changes)
    exit_code, messages = asked(SPECS / "3_squirt_bottle.yaml", last, *QUICK, *words, "--out", "all")
    assert exit_code == 1
    assert f"all/experiment-4: error[{code}]: " in messages
    assert said in messages
    assert "hint: name another folder with --out" in messages
    assert "--resume" not in messages
    assert not (copied / "experiment-3").exists()


@pytest.mark.slow
def test_runs_of_other_versions_and_other_things_are_found_too(copied: Path) -> None:
    shutil.copytree(copied, "other")
    (Path("other") / "experiment-4" / "run.json").unlink()
    folder = RunFolder.open(copied / "experiment-4")
    made_by = {**folder.manifest.versions, "numpy": f"0.{folder.manifest.versions['numpy']}"}
    identity = identities(program_of_run(folder), folder.manifest.seed, made_by)
    with closing(sqlite3.connect(folder.path / "trials.sqlite")) as table, table:
        table.executemany("UPDATE trials SET identity = ? WHERE number = ?", [(identity(n), n) for n in range(2)])
    manifest = folder.path / "run.json"
    manifest.write_text(manifest.read_text("utf-8").replace('"numpy": "', '"numpy": "0.'), "utf-8")
    for out, code, said in (("all", "run-differs", "made with numpy 0."), ("other", "folder-not-empty", "no run")):
        exit_code, messages = asked(SPECS / "3_squirt_bottle.yaml", SPEC, *QUICK, "--out", out)
        assert exit_code == 1
        assert f"{out}/experiment-4: error[{code}]: " in messages
        assert said in messages
        assert "hint: name another folder with --out" in messages
        assert not (Path(out) / "experiment-3").exists()


def test_no_folder_for_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").touch()
    for out, code in (("x" * 300, "folder-not-readable"), ("file", "folder-not-writable")):
        exit_code, messages = asked(SPEC, *QUICK, "--out", out)
        assert (exit_code, messages.count(f"error[{code}]")) == (1, 1)


@pytest.mark.slow
def test_the_command_that_goes_on_is_the_one_that_was_given(ended: Path, tmp_path: Path) -> None:
    words = ["experiments", str(SPEC), *QUICK, "--out", "the folder", "--json"]
    begun = stopped(*words, cwd=tmp_path, after=" 1/2 ", stop=interrupt)
    assert (begun.returncode, begun.stdout) == (130, "")
    command = shlex.split(begun.stderr.splitlines()[-1])
    assert command[0] == "graspdsl"
    assert sorted(command[1:]) == sorted(words)
    done = graspdsl(*command[1:], cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "1 finished before" in done.stderr
    assert json.loads(done.stdout)["claims"] == json.loads((ended / "answer.json").read_text("utf-8"))["claims"]


@pytest.mark.slow
def test_a_refusal_is_one_json_document(tmp_path: Path) -> None:
    named(tmp_path, "mine.yaml", ("object: detergent-bottle", "object: squirt-bottle"))
    assert codes(graspdsl("experiments", "mine.yaml", "--json", cwd=tmp_path)) == ["other-experiment"]
