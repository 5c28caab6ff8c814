"""What validate tells of starts and objects from their sizes, without a simulator."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from shipped import SHIPPED, SPECS

from graspdsl.compiler.program import examine

MAIN = SPECS / "towel_roll_two_contacts.yaml"


def told(*settings: str) -> dict[str, str]:
    """The warnings and errors of the main spec with settings: messages by their codes."""
    found = examine(MAIN.read_text("utf-8"), MAIN.name, settings).diagnostics
    return {diagnostic.code: diagnostic.message for diagnostic in found}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "code", "said"),
    [
        (["trials.start.height=1.2"], "start-out-of-place", "above the top of the object at 0.2 m"),
        (["trials.start.height={normal: [0.5, 0.05]}"], "start-out-of-place", "0.35 m or more above"),
        (["trials.start.height=-0.05"], "start-out-of-place", "the palm is below the table"),
        (["trials.start.tilt=-1.5", "trials.start.height=0.02"], "start-out-of-place", "the palm is below the table"),
        (["trials.start.standoff={choice: [0.3, 0.4]}"], "start-out-of-place", "0.3 m or more from the object"),
        (["trials.start={tilt: 1.4, standoff: 0.0, height: 0.08}"], "start-out-of-place", "inside"),
        (["trials.start.offset=0.5"], "start-out-of-place", "the hand passes the object"),
        (["trials.start.offset={uniform: [-0.5, -0.4]}"], "start-out-of-place", "0.4 m or more aside"),
        (["scene.object={cylinder: {diameter: 0.2, height: 0.3}, mass: 1}"], "object-too-wide", "200 mm wide"),
        (["scene.object={sphere: {diameter: 0.3}, mass: 1}"], "object-too-wide", "300 mm wide"),
        (["scene.object={box: {size: [0.3, 0.32, 0.3]}, mass: 1}"], "object-too-wide", "opens to 286 mm"),
        (["scene.object={ellipsoid: {size: [0.06, 0.06, 0.12]}, mass: 1}"], "object-falls", "tips over by 90°"),
        (["trials.start.height={relative: {uniform: [1.2, 1.5]}}"], "start-out-of-place", "the palm is 0.24 m or more"),
        (["scene.object={like: towel-roll, pose: {rpy: [0.03, 0, 0]}}"], "object-tips", "the object tips by 1.7°"),
        (["scene.object={box: {size: [0.1, 0.1, 1.8]}, mass: 1}"], "object-size", "1.8 m long"),
    ],
)  # fmt: skip
def test_what_no_trial_can_begin_with(settings: list[str], code: str, said: str) -> None:
    assert said in told(*settings)[code]


@pytest.mark.parametrize(
    "settings",
    [
        ["trials.start.height={uniform: [0.1, 0.5]}"],  # some are low enough
        ["trials.start.standoff={uniform: [0.05, 0.5]}"],
        ["scene.object={cylinder: {diameter: 0.17, height: 0.3}, mass: 1}"],
        ["scene.object={box: {size: [0.3, 0.1, 0.1]}, mass: 1}", "trials.start.yaw=0.7"],  # its narrow side
        ["scene.object={ellipsoid: {size: [0.06, 0.06, 0.12]}, fixed: true, mass: 1}"],
        ["trials.start.offset={uniform: [-0.5, 0.5]}"],
        ["scene.object=bottle"],  # it has a neck
        ["scene.object=squirt-bottle"],
        ["scene.object=detergent-bottle"],
        ["scene.object={like: towel-roll, pose: lay-down}", "trials.start.height={relative: 0.5}"],
        ["scene.object={ellipsoid: {size: [0.06, 0.06, 0.12]}, mass: 1}", "scene.gravity=0"],
    ],
)
def test_what_some_trial_can_begin_with(settings: list[str]) -> None:
    assert set(told(*settings)) & {"start-out-of-place", "object-too-wide", "object-falls", "object-size"} == set()


@pytest.mark.parametrize("spec", SHIPPED, ids=lambda path: path.stem)
def test_shipped_specs_can_begin(spec: Path) -> None:
    codes = {d.code for d in examine(spec.read_text("utf-8"), spec.name).diagnostics}
    assert codes & {"start-out-of-place", "object-too-wide", "object-falls", "object-size"} == set()


@pytest.mark.slow
def test_no_simulator_is_started() -> None:
    code = (
        "import sys; from pathlib import Path; from graspdsl.compiler.program import examine; "
        f"examine(Path({str(MAIN)!r}).read_text('utf-8'), 's', ('scene.object=squirt-bottle',)); "
        "sys.exit('pybullet' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
