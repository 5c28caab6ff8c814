"""Python files that a spec names: run only where that is allowed, and then as good as things of a package."""

from __future__ import annotations

from pathlib import Path

import pytest
from compiler.specs import floating

from graspdsl.compiler.program import Examination, Program, examine, program_of
from graspdsl.trials.identity import identities
from graspdsl.trials.runner import new_run, program_of_run
from graspdsl.trials.setup import trial_loop
from graspdsl.trials.store import RunFolder

from .packages import HUBER, installed

THREE = "{γ1, γ2, γ3}"
SPEC = floating(f"φ_h|τ_frx({THREE}) σ_fr({THREE})", until="force_residual: 0.05") + "code: [mine.py]\n"


@pytest.fixture
def folder(site: Path, tmp_path: Path) -> Path:
    """Where a spec and its code are; nothing of the test's stays in the tables."""
    del site
    (tmp_path / "mine.py").write_text(HUBER, "utf-8")
    return tmp_path


def read(folder: Path, text: str = SPEC, *, allow_code: bool = True) -> Examination:
    """What becomes of a spec in a folder."""
    return examine(text, "spec.yaml", (), folder, allow_code)


def sound(folder: Path, text: str = SPEC) -> Program:
    """The program of a spec of which there is nothing to say."""
    examination = read(folder, text)
    assert examination.diagnostics == ()
    assert examination.program is not None
    return examination.program


def test_it_is_not_run_unless_that_is_allowed(folder: Path) -> None:
    """Then nothing is said of what it may have defined."""
    (folder / "mine.py").write_text(f"open({str(folder / 'done')!r}, 'w').close()\n{HUBER}", "utf-8")
    [found] = read(folder, allow_code=False).diagnostics
    assert (found.code, found.message) == ("code-not-allowed", "this spec brings code of its own: mine.py")
    assert found.hint is not None
    assert "--allow-code" in found.hint
    assert found.span is not None
    assert SPEC.split("\n")[found.span.line - 1][found.span.column - 1 :] == "[mine.py]"
    assert not (folder / "done").exists()
    sound(folder)
    assert (folder / "done").exists()


def test_it_defines_what_a_package_would_bring(folder: Path) -> None:
    program = sound(folder)
    [plugin] = program.plugins
    assert (plugin.kind, plugin.name, plugin.by) == ("potentials", "φ_h", "mine.py")
    assert [str(file.kept_as) for file in program.files] == ["mine.py"]
    assert trial_loop(program).run(0, 3).record.outcome == "converged"


def test_other_code_makes_other_trials(folder: Path) -> None:
    first = sound(folder)
    before = identities(first, 1)(0)
    assert identities(sound(folder), 1)(0) == before
    (folder / "mine.py").write_text(f"{HUBER}\n\n# changed\n", "utf-8")
    assert identities(sound(folder), 1)(0) != before


def test_a_run_keeps_it_and_its_folder_is_not_trusted(folder: Path) -> None:
    made = new_run(folder / "run", sound(folder))
    assert (made.files / "mine.py").read_text("utf-8") == HUBER
    assert program_of_run(made).plugins
    assert identities(program_of_run(made), 1)(0) == identities(sound(folder), 1)(0)
    (folder / "mine.py").unlink()
    assert program_of_run(RunFolder.open(made.path, allow_code=True)).plugins == program_of_run(made).plugins
    [found] = examine(SPEC, "spec.yaml", (), made.files).diagnostics
    assert found.code == "code-not-allowed"
    assert not RunFolder.open(made.path).allow_code


def test_what_another_spec_brought_is_not_there_for_all(folder: Path) -> None:
    sound(folder)
    [found] = read(folder, SPEC.replace("code: [mine.py]\n", "")).diagnostics
    assert (found.code, found.message) == (
        "plugin-missing",
        "mine.py, which this spec does not name, had the potential φ_h",
    )


def test_it_comes_before_a_package_and_leaves_that_as_it_was(site: Path, folder: Path) -> None:
    installed(site)
    without = SPEC.replace("code: [mine.py]\n", "")
    for text, by in ((without, "kit 1.0"), (SPEC, "mine.py"), (without, "kit 1.0")):
        examination = read(folder, text)
        assert examination.program is not None
        assert [plugin.by for plugin in examination.program.plugins] == [by]
        said = [complaint.message for complaint in examination.diagnostics]
        passed_over = "the potential φ_h of kit 1.0 is passed over: mine.py has one of that name"
        assert said == ([passed_over] if by == "mine.py" else [])


FAULTY = {
    "no such file": (None, "file-not-found", "there is no file mine.py"),
    "a folder": ("", "is-a-directory", "mine.py is a directory"),
    "no Python": ("class Huber(", "plugin-broken", "mine.py cannot be run: SyntaxError: "),
    "an end": ("raise SystemExit", "plugin-broken", "mine.py cannot be run: SystemExit (mine.py:1)"),
    "a fault": (
        "import math\n\ndef half(of):\n    return math.sqrt(of) / 2\n\nhalf(-1.0)\n",
        "plugin-broken",
        "mine.py cannot be run: ValueError: math domain error (mine.py:4)",
    ),
    "nothing": ("EDGE = 0.5", "nothing-defined", "mine.py defines none of potential, sensor transform"),
    "half a class": (
        "from graspdsl.basis.potentials import Potential\nclass Huber(Potential):\n    symbol = 'φ_h'",
        "plugin-unfit",
        "Huber in mine.py does not define gradient and value",
    ),
    "a built-in name": (HUBER.replace("φ_h", "φ_fr"), "plugin-passed-over", "the potential φ_fr of mine.py"),
}


@pytest.mark.parametrize(("text", "code", "said"), FAULTY.values(), ids=FAULTY)
def test_its_faults_are_told_where_it_is_named(folder: Path, text: str | None, code: str, said: str) -> None:
    """Those alone: that what it should have defined is not there follows from them."""
    place = folder / "mine.py"
    place.unlink()
    if text == "":
        place.mkdir()
    elif text is not None:
        place.write_text(text, "utf-8")
    found = read(folder).diagnostics
    assert [(each.code, said in each.message) for each in found] == [(code, True)]
    assert found[0].span is not None
    assert found[0].span.line == SPEC.count("\n")


@pytest.mark.parametrize("name", ["../mine.py", "/mine.py"])
def test_it_is_beside_the_spec(folder: Path, name: str) -> None:
    (folder / "specs").mkdir()
    found = read(folder / "specs", SPEC.replace("mine.py", name)).diagnostics
    assert "outside-of-folder" in [each.code for each in found]


def test_a_helper_needs_no_name(folder: Path) -> None:
    """A class that others are written from, and one that is not public."""
    helpers = HUBER.replace("Huber(", "_Base(") + "\n\nclass Half(_Base):\n    symbol = 'φ_half'\n"
    (folder / "mine.py").write_text(helpers, "utf-8")
    text = SPEC.replace("φ_h|", "φ_half|")
    assert [plugin.name for plugin in sound(folder, text).plugins] == ["φ_half"]


def test_the_front_door_says_no_too(folder: Path) -> None:
    with pytest.raises(Exception, match="code of its own"):
        program_of(SPEC, "spec.yaml", (), folder)
