"""The page on engines says what the code does: its bounds, and the keys that it shows."""

from __future__ import annotations

import re
import runpy

from graspdsl.compiler.program import program_of
from graspdsl.report.agreement import PEAKS_APART, QUANTITIES, SAME_OUTCOME
from graspdsl.worlds.kinds import WORLDS

from .pages import PAGES, ROOT

PAGE = PAGES["engines.md"]
MAIN = ROOT / "specs" / "towel_roll_two_contacts.yaml"


def test_its_bounds_are_those_of_the_code() -> None:
    rows = [line.strip("| ").split(" | ") for line in PAGE.splitlines() if line.startswith("|")]
    bounds = [row[1] for row in rows if len(row) == 3 and row[0] != "point" and "---" not in row[0]]
    assert bounds[0] == f"at least {100 * SAME_OUTCOME:.0f} % of pairs"
    assert f"{PEAKS_APART:g} rad" in bounds[1]
    assert bounds[2:] == [quantity.bound for quantity in QUANTITIES.values()]


def test_its_keys_are_known() -> None:
    [keys] = re.findall(r"```yaml\nscene:\n  world: (\w+)\n  physics:\n((?:    .*\n)+)```", PAGE)
    settings = (f"scene.physics.{key}={value}" for key, value in re.findall(r"    (\w+): ([\d.]+)", keys[1]))
    program = program_of(MAIN.read_text("utf-8"), MAIN.name, (f"scene.world={keys[0]}", *settings))
    effort = program.world.effort_in(program.spec.scene.physics)
    assert effort not in [kind.effort for kind in WORLDS.values()]


def test_its_script_fills_in_what_the_page_marks() -> None:
    script = runpy.run_path(str(ROOT / "docs" / "render_engines.py"))
    blocks = {name: f"{name}\n" for name in ("finer", "broken")}
    assert [line for line in script["filled"](PAGE, blocks).splitlines() if line in blocks] == list(blocks)
    assert script["filled"](PAGE, {}) == PAGE
