"""The wheel that users install holds every package and data file."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]


def test_the_wheel_works_on_its_own(tmp_path: Path) -> None:
    """Build it, unpack it elsewhere, and check a spec with nothing but its files."""
    source = tmp_path / "source"
    tracked = subprocess.run(
        ["git", "ls-files", "-co", "--exclude-standard", "-z"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    for name in filter(None, tracked.stdout.split("\0")):
        if (ROOT / name).is_file():
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            (source / name).write_bytes((ROOT / name).read_bytes())
    wheels = tmp_path / "wheels"
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--wheel-dir", str(wheels), str(source)]
    subprocess.run(pip, check=True)
    [wheel] = wheels.glob("*.whl")
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    assert not (site / "cli").exists()
    script = (
        "import sys, graspdsl, graspdsl.cli; "
        f"assert graspdsl.__path__[0].startswith({str(site)!r}), graspdsl.__path__; "
        "from graspdsl.objects.shapes import catalogue; assert catalogue(); "
        "graspdsl.cli.main()"
    )
    empty = tmp_path / "empty"
    empty.mkdir()

    def answer(*words: str) -> str:
        done = subprocess.run(
            [sys.executable, "-c", script, *words],
            env={**os.environ, "PYTHONPATH": str(site)},
            cwd=empty,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "slide-with-posture" in answer("list", "specs")
    assert answer("init", "--from", "4.13") == "grasp.yaml\n"
    assert "Eq. 4.13" in (empty / "grasp.yaml").read_text("utf-8")
    assert "φ_fr" in answer("explain", "grasp.yaml")
    assert "of 2 trials" in answer("run", "grasp.yaml", "--trials", "2", "--workers", "1")
    assert answer("init", "mine.yaml") == "mine.yaml\n"
    assert "of 1 trials" in answer("run", "mine.yaml", "--trials", "1", "--workers", "1")
    assert answer("fmt", "--check", "grasp.yaml", "mine.yaml") == ""
