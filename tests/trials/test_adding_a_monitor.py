"""To add a monitor: a file with its class, and its line in the table. Done here in a copy of the package, and used."""

from __future__ import annotations

import compileall
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
SPEC = ROOT / "specs" / "compare" / "force_alone.yaml"
CLASS = '''"""A monitor of moments."""

from graspdsl.spec.outcomes import Outcome
from graspdsl.spec.watching import Beyond, Distance


class TwistMonitor(Beyond):
    """Contacts that twist the object."""

    key = "twist"
    description = "the moment residual is larger than this (m): twisted"
    bound_type, default = Distance, 10.0
    outcome = Outcome("twisted", "the contacts twisted the object", "#dddddd", "xx")
    quantity, said, scale = "moment_residual", "a moment of {:.0f} mm", 1000.0
'''


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where a copy of the package is that has one monitor more."""
    place = tmp_path_factory.mktemp("package")
    unneeded = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "graspdsl", place / "graspdsl", ignore=unneeded)
    shutil.copytree(ROOT / "cli", place / "graspdsl" / "cli", ignore=unneeded)
    (place / "graspdsl" / "spec" / "twist.py").write_text(CLASS, "utf-8")
    table = place / "graspdsl" / "spec" / "monitors.py"
    text, line = table.read_text("utf-8"), "        ProgressMonitor,\n    )\n"
    assert text.count(line) == 1
    text = text.replace(line, f"        TwistMonitor,\n{line}")
    text = text.replace(
        "from graspdsl.spec.watching", "from graspdsl.spec.twist import TwistMonitor\nfrom graspdsl.spec.watching", 1
    )
    table.write_text(text, "utf-8")
    assert compileall.compile_dir(place, quiet=1)
    return place


def answer(package: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """What the program answers that has one monitor more."""
    code = "import sys; from graspdsl.cli.main import main; sys.exit(main())"
    surroundings = {**os.environ, "PYTHONPATH": str(package)}
    command = [sys.executable, "-c", code, *map(str, words)]
    return subprocess.run(
        command, cwd=package, env=surroundings, capture_output=True, encoding="utf-8", timeout=120, check=False
    )


def test_it_stands_in_the_schema(package: Path) -> None:
    found = json.loads(answer(package, "schema").stdout)["$defs"]["MonitorBounds"]["properties"]["twist"]
    assert found["description"] == "the moment residual is larger than this (m): twisted"
    assert found["default"] == 10.0


@pytest.mark.parametrize(
    ("line", "code", "said"),
    [
        ("monitors.twist=0.02", 0, ""),
        ("monitors.twist=off", 0, ""),
        ("monitors.twist=wide", 1, "expected a number, on (the default) or off"),
        ("monitors.twisted=0.02", 1, "the monitor of twisted is twist"),
    ],
)
def test_it_is_checked_as_all_are(package: Path, line: str, code: int, said: str) -> None:
    words = ("run", SPEC, "--set", line, "--trials", "1", "--out", package / line, "--no-report")
    found = answer(package, *words)
    assert found.returncode == code, found.stderr
    assert said in found.stderr


def test_it_ends_trials_and_its_outcome_is_told(package: Path) -> None:
    words = ("run", SPEC, "--set", "monitors.twist=0.02", "--trials", "12", "--out", package / "run")
    found = answer(package, *words, "--json", "--no-report")
    assert found.returncode == 0, found.stderr
    assert json.loads(found.stdout)["outcomes"]["twisted"] > 0
    told = answer(package, "report", package / "run").stdout
    assert "twisted" in told
    assert "a moment of " in told
    assert "the contacts twisted the object" in (package / "run" / "report.html").read_text("utf-8")
