"""What is found behind ``import graspdsl``, and what that costs."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pytest
from structure.test_imports import MODULES, ROOT

import graspdsl as g

HOUSE = MODULES["graspdsl"]
SPEC = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"


def loaded_by(code: str) -> set[str]:
    """The modules that are loaded after a piece of code in a process of its own."""
    script = (
        f"import json, sys; before = set(sys.modules)\n{code}\nprint(json.dumps(sorted(set(sys.modules) - before)))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return set(json.loads(done.stdout.splitlines()[-1]))


def _packages(modules: set[str]) -> set[str]:
    return {name.partition(".")[0] for name in modules}


@pytest.mark.slow
def test_nothing_is_imported_before_it_is_asked_for() -> None:
    assert {name for name in loaded_by("import graspdsl") if name.startswith("graspdsl")} == {"graspdsl"}
    assert _packages(loaded_by("import graspdsl")) <= {"graspdsl", *sys.stdlib_module_names}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import graspdsl as g; g.parse('π_s|Γ Γ (π_gx|Γ Γ)')", {"numpy", "pydantic", "scipy"}),
        ("import graspdsl as g; g.residuals([[0, 0, 0]], [[0, 0, 1]])", {"pybullet", "matplotlib", "pandas", "scipy"}),
        ("import graspdsl as g; g.run; g.open_run", {"pybullet", "matplotlib", "pandas", "rich"}),
        ("import graspdsl as g; g.compile('π_gx|Γ Γ')", {"pybullet", "matplotlib", "pandas", "rich", "scipy"}),
        (f"import graspdsl as g; g.load({str(SPEC)!r})", {"pybullet", "matplotlib", "pandas", "rich", "scipy"}),
    ],
)
def test_what_is_heavy_waits_until_it_is_needed(code: str, heavy: set[str]) -> None:
    assert _packages(loaded_by(code)) & heavy == set()


@pytest.mark.parametrize("name", g.__all__)
def test_every_name_is_there_and_documented(name: str) -> None:
    assert getattr(g, name).__doc__


def test_names_are_those_that_editors_see() -> None:
    """The imports for types are of the same names from the same modules as those that are carried out."""
    tree = ast.parse(HOUSE.read_text("utf-8"))
    [typed] = [node for node in tree.body if isinstance(node, ast.If)]
    seen = {alias.name: node.module for node in typed.body if isinstance(node, ast.ImportFrom) for alias in node.names}
    homes = next(node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "_HOMES")
    assert seen == {name: f"graspdsl.{home}" for name, home in ast.literal_eval(homes).items()}
    assert sorted(seen) == sorted(g.__all__)
    assert {*g.__all__, "__version__", "__doc__"} <= set(dir(g))


def test_the_version_is_that_of_the_package() -> None:
    assert g.__version__ == version("graspdsl")


def test_an_unknown_name_is_no_attribute() -> None:
    with pytest.raises(AttributeError, match="module 'graspdsl' has no attribute 'lode'"):
        _ = g.lode


@pytest.mark.slow
def test_editors_know_types(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text("import graspdsl as g\nreveal_type(g.run)\nreveal_type(g.parse('π_a').ascii)\ng.lode\n", "utf-8")
    checked = ROOT / "build" / "types"  # where `make types` has looked at all of graspdsl already, if it has been run
    place, config = (checked, ["--config-file", "../../pyproject.toml"]) if checked.exists() else (tmp_path, [])
    words = [sys.executable, "-m", "mypy", *config, str(script)]
    done = subprocess.run(words, cwd=place, capture_output=True, text=True, check=False)
    assert "-> graspdsl.api.runs.Run" in done.stdout
    assert 'Revealed type is "str"' in done.stdout
    assert 'Module has no attribute "lode"' in done.stdout
