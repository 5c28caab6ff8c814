"""The house rules: which way imports go, who may use which library, and what every module has."""

from __future__ import annotations

import ast
import graphlib
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# A package may import those of the rows above its own, and itself.
ORDER = (
    {"diagnostics", "arrays", "units", "declared", "specs"},
    {"backends"},
    {"places", "angles"},
    {"notation"},
    {"models"},
    {"objects"},  # below the spec, whose keys of an object are those of the table of shapes
    {"spec"},
    {"basis"},
    {"hands"},
    {"worlds"},
    {"quality"},
    {"plugins"},
    {"compiler"},
    {"trials"},
    {"contracts"},
    {"reference"},
    {"report"},
    {"api"},
    {"editor"},
    {"cli"},
)
ROW = {package: row for row, packages in enumerate(ORDER) for package in packages}

FOLDERS = {"graspdsl": ROOT / "graspdsl", "graspdsl.cli": ROOT / "cli", "graspdsl.specs": ROOT / "specs"}
MODULES = {
    ".".join((package, *path.relative_to(folder).with_suffix("").parts)).removesuffix(".__init__"): path
    for package, folder in FOLDERS.items()
    for path in sorted(folder.rglob("*.py"))
}
# Outside of the command line: how far a run is, and a run that a console is asked to show.
PROGRESS = "graspdsl.api.progress"
SHOWN = {PROGRESS, "graspdsl.api.console"}
EACH_MODULE = pytest.mark.parametrize("module", MODULES)


@cache
def _tree(module: str) -> ast.Module:
    return ast.parse(MODULES[module].read_text(encoding="utf-8"))


def _package(module: str) -> str:
    """The part of graspdsl that a module belongs to; empty for graspdsl itself."""
    return f"{module}..".split(".")[1]


@cache
def _imports(module: str) -> tuple[str, ...]:
    """The modules that a module imports, at its top or later, also by name through importlib."""
    return tuple(_imported(module))


def _imported(module: str) -> Iterator[str]:
    for node in ast.walk(_tree(module)):
        match node:
            case ast.Import(names):
                yield from (alias.name for alias in names)
            case ast.ImportFrom(source, names, level):
                assert level == 0, "relative imports hide which way they go"
                yield from (f"{source}.{alias.name}" for alias in names)
            case ast.Call(func=ast.Attribute(attr="import_module"), args=[ast.Constant(str(name)), *_]):
                yield name


def _module_of(name: str) -> str:
    """The module that an imported name is, or is in."""
    while name not in MODULES and "." in name:
        name = name.rpartition(".")[0]
    return name


def _importers(library: str) -> set[str]:
    return {module for module in MODULES if any(name.split(".")[0] == library for name in _imports(module))}


def _within(package: str, modules: set[str]) -> bool:
    return all(f"{module}.".startswith(f"graspdsl.{package}.") for module in modules)


def test_every_part_has_its_row() -> None:
    assert {_package(module) for module in MODULES} - {""} <= set(ROW)


@pytest.mark.slow
@EACH_MODULE
def test_imports_go_one_way(module: str) -> None:
    own = _package(module)
    row = ROW[own] if own else len(ORDER)
    imported = {_package(name) for name in _imports(module) if name.startswith("graspdsl.")}
    assert {other for other in imported if other not in ("", own) and ROW[other] >= row} == set()


@pytest.mark.slow
def test_no_imports_go_in_a_circle() -> None:
    """Nor do late ones."""
    graph = {module: {name for name in map(_module_of, _imports(module)) if name != module} for module in MODULES}
    graphlib.TopologicalSorter(graph).prepare()


def test_a_circle_would_be_found() -> None:
    with pytest.raises(graphlib.CycleError):
        graphlib.TopologicalSorter({"a": {"b"}, "b": {"a"}}).prepare()
    assert _module_of("graspdsl.units.in_unit") == _module_of("graspdsl.units") == "graspdsl.units"


@pytest.mark.parametrize("library", ["pybullet", "pybullet_data"])
def test_only_the_bullet_world_imports_pybullet(library: str) -> None:
    assert _within("worlds.bullet", _importers(library))


def test_only_models_and_the_mujoco_world_import_mujoco() -> None:
    allowed = ("graspdsl.models", "graspdsl.worlds.mujoco")
    assert not [name for name in _importers("mujoco") if not name.startswith(allowed)]


@pytest.mark.parametrize("library", ["pygls", "lsprotocol"])
def test_only_the_language_server_knows_its_protocol(library: str) -> None:
    assert _importers(library) == {"graspdsl.cli.lsp"}


def test_tactile_sensors_know_no_engine() -> None:
    touch = [module for module in MODULES if module.startswith("graspdsl.worlds.touch")]
    assert len(touch) > 1
    known = {name for module in touch for name in _imports(module) if name.startswith("graspdsl.worlds")}
    assert {name for name in known if not name.startswith("graspdsl.worlds.touch")} == set()


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_engines_are_loaded_by_their_entry_of_the_table_alone(engine: str) -> None:
    stage = f"graspdsl.worlds.{engine}.stage"
    importers = {module for module in MODULES if any(f"{name}.".startswith(f"{stage}.") for name in _imports(module))}
    assert _within(f"worlds.{engine}", importers - {"graspdsl.contracts.objects"})


@pytest.mark.slow
def test_pybullet_is_not_loaded_before_a_bullet_world_is_built() -> None:
    code = "import graspdsl.cli, graspdsl.compiler.program, sys; sys.exit('pybullet' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.parametrize("option", ["--version", "--help"])
def test_what_a_command_does_not_need_is_not_loaded(option: str) -> None:
    code = (
        f"import sys; from graspdsl.cli import main; sys.argv = ['graspdsl', '{option}']\n"
        "try:\n    main()\nexcept SystemExit as end:\n    assert not end.code\n"
        "assert 'graspdsl.plugins.kinds' not in sys.modules and 'numpy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True, capture_output=True)


@pytest.mark.slow
def test_colours_are_known_where_something_is_shown() -> None:
    assert {module for module in _importers("rich") if not _within("cli", {module})} == SHOWN
    assert all(_within("cli", _importers(library)) for library in ("typer", "click"))


@pytest.mark.slow
@pytest.mark.parametrize("library", ["matplotlib", "jinja2"])
def test_only_the_report_draws(library: str) -> None:
    """Runs and sweeps name the type of the figures that they give away."""
    typed = {f"graspdsl.api.{name}" for name in ("told", "runs", "sweeps")}
    assert _within("report", _importers(library) - typed)


@pytest.mark.slow
@EACH_MODULE
def test_only_the_command_line_and_the_progress_of_a_run_print(module: str) -> None:
    if _package(module) != "cli" and module != PROGRESS:
        called = {getattr(node.func, "id", "") for node in ast.walk(_tree(module)) if isinstance(node, ast.Call)}
        assert "print" not in called


def test_packages_of_the_project_are_the_folders_there_are() -> None:
    """A package that is not listed works in place and is missing from the wheel."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    folders = {module for module, path in MODULES.items() if path.name == "__init__.py"}
    pages = {"graspdsl.docs"}  # with their scripts, which are no modules
    assert set(settings["packages"]) == folders | pages
    assert len(settings["packages"]) == len(folders | pages)


@EACH_MODULE
def test_every_folder_of_modules_is_a_package(module: str) -> None:
    assert MODULES[module].with_name("__init__.py").exists()


@EACH_MODULE
def test_what_is_public_has_a_docstring(module: str) -> None:
    tree = _tree(module)
    assert not tree.body or ast.get_docstring(tree)
    assert [name for name, node in _public(tree) if not ast.get_docstring(node)] == []


Definition = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def _public(scope: ast.Module | ast.ClassDef) -> Iterator[tuple[str, Definition]]:
    """The public functions and classes of a module, and the public methods of those classes."""
    for node in scope.body:
        if isinstance(node, Definition) and not node.name.startswith("_"):
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                yield from ((f"{node.name}.{name}", inner) for name, inner in _public(node))
