"""The page that walks through one tick names the functions that one tick calls, in the order of their calls."""

from __future__ import annotations

import re
import sys
from types import FrameType

import pytest

from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import trial_loop

from .pages import PAGES, ROOT

SPEC = ROOT / "specs" / "chapter" / "4_30_grasp_cartesian.yaml"
NUMBERED = re.findall(
    r"^\d+\. (?:.(?!^\d+\. |^$))*", PAGES["hot_path.md"].partition("## The world moves")[2], flags=re.M | re.S
)
NAMED = [re.findall(r"\[`([\w.]+)`\]\(\.\./(graspdsl/[\w/]+\.py)\)", step) for step in NUMBERED]
# Named in passing: what calls the loop, what was done before it or is done for many ticks, values, and another world.
BESIDES = {"TrialLoop.run_all", "Descent.displacement", "Logbook._write_down", "RigidWorld.step"}
BESIDES |= {"Observation", "Truth"}


@pytest.mark.slow
def test_functions_stand_in_the_order_in_which_they_are_called() -> None:
    program = program_of(SPEC.read_text("utf-8"), SPEC.name)
    loop, called = trial_loop(program), list[tuple[str, str]]()

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            called.append((frame.f_code.co_qualname, frame.f_code.co_filename))

    sys.setprofile(note)
    try:
        loop.run(0, program.spec.trials.seed)
    finally:
        sys.setprofile(None)
    steps = [place for place, (name, _) in enumerate(called) if name == "SideBySide.tick"]
    tick = iter(called[steps[2] : steps[3]])
    wanted = [(name, str(ROOT / path)) for step in NAMED for name, path in step if name not in BESIDES]
    assert len(wanted) > 20
    for function in wanted:
        assert function in tick, f"{function} is not called after what stands before it"
