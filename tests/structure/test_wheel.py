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
    environment = {**os.environ, "PYTHONPATH": str(site)}
    script = (
        "import sys, graspdsl, graspdsl.cli; "
        f"assert graspdsl.__path__[0].startswith({str(site)!r}), graspdsl.__path__; "
        "from graspdsl.objects.shapes import catalogue; assert catalogue(); "
        "sys.argv = ['graspdsl', 'run', sys.argv[1], '--trials', '1', '--workers', '1']; graspdsl.cli.main()"
    )
    spec = ROOT / "specs" / "towel_roll_two_contacts.yaml"
    done = subprocess.run(
        [sys.executable, "-c", script, str(spec)],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert "1 of 1 trials" in done.stdout or "0 of 1 trials" in done.stdout
