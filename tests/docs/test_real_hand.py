"""The page on hands of one's own: its formulas are so. The example: it grasps, and it stops."""

from __future__ import annotations

import contextlib
import io
import os
import re
import runpy
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import graspdsl as g
from graspdsl.arrays import Array
from graspdsl.compiler.program import program_of
from graspdsl.hands.descriptions import joint_limits
from graspdsl.worlds.real_hand import Reading

from .pages import DOCS, PAGES

pytestmark = pytest.mark.slow

PAGE = PAGES["real_hand.md"]
EXAMPLE = DOCS / "examples" / "real_hand.py"
NAMES = runpy.run_path(str(EXAMPLE))
SPEC, TARING, MOST, GRASP = (NAMES[name] for name in ("SPEC", "TARING", "MOST", "grasp"))
STOPPED = "the hand is told to stand still"


def test_the_pages_formula_of_the_gantry_is_where_the_hand_is() -> None:
    """What is seen with the wrist's joints anywhere is seen with these at zero, the mounting face being where the
    formula has it; and back."""
    [formulas] = [code for code in re.findall(r"```python\n(.*?)```", PAGE, flags=re.S) if "def face_of" in code]
    random = np.random.default_rng(2)
    p0, turned = random.normal(size=3), Rotation.random(random_state=3).as_matrix()
    names: dict[str, Any] = {"np": np, "p0": p0, "R0": turned}
    with contextlib.redirect_stdout(io.StringIO()):
        exec(formulas, names)
    program = g.load(SPEC)
    lower, upper = np.array(joint_limits(program.robot))
    nothing = np.zeros((3, 6))
    for _ in range(10):
        joints = random.uniform(lower, upper)
        wrist, still = joints[:6], np.where(np.arange(len(joints)) < 6, 0.0, joints)
        position, rotation = names["face_of"](wrist)
        np.testing.assert_allclose(names["wrist_of"](position, rotation), wrist, rtol=0.0, atol=1e-9)
        seen = []
        for hand, places in ((g.hand_of(program, p0, turned), joints), (g.hand_of(program, position, rotation), still)):
            hand.tare([g.Reading(0.0, places, nothing)])
            seen.append(hand.observe(g.Reading(1.0, places, nothing)))
        np.testing.assert_allclose(seen[0].points, seen[1].points, rtol=0.0, atol=1e-12)
        turns = [Rotation.from_rotvec(each.orientations).as_matrix() for each in seen]
        np.testing.assert_allclose(turns[0], turns[1], rtol=0.0, atol=1e-9)


def test_a_contact_moves_by_its_force_error_as_the_page_says() -> None:
    """By s · admittance · e, of one that presses too little, whatever its mount."""
    for mount in ("gantry", "wam"):
        resources = {"γ1": "finger-1", "γ2": "finger-2", "γ3": "finger-3", "Γ": "{γ1, γ2, γ3}"}
        controller = g.compile("π_close|Γ Γ", mount=mount, resources=resources)
        seen, admittance = controller.example(), controller.program.spec.control.admittance
        weights = np.array(controller.program.robot.weights)
        for contact, normal in enumerate(seen.normals):
            lacking = np.where(np.arange(3)[:, None] == contact, 0.4, 0.5) * seen.normals  # of the usual 0.5 N
            along = normal @ seen.jacobian[contact]
            moved = along @ controller(replace(seen, forces=lacking)).command.displacement
            assert 1.0 < np.sum((weights * along) ** 2) < 4.0
            assert moved == pytest.approx(np.sum((weights * along) ** 2) * admittance * 0.1, rel=0.01)


# The example, its hand in a process of its own; however slow the computer is


@pytest.fixture
def start() -> Iterator[Callable[..., subprocess.Popen[str]]]:
    """Sets the example on its way, with options; what still runs in the end is stopped."""
    running = list[subprocess.Popen[str]]()

    def started(*options: str) -> subprocess.Popen[str]:
        command = [sys.executable, str(EXAMPLE), *options]
        running.append(subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True))
        return running[-1]

    yield started
    for process in running:
        process.terminate()
        process.communicate()


def lines_until(process: subprocess.Popen[str], what: str) -> str:
    """What it prints, up to the first line with this."""
    assert process.stdout is not None
    said = ""
    for line in process.stdout:
        said += line
        if what in line:
            return said
    raise AssertionError(f"it never said {what!r}: {said}")


def test_it_grasps_though_readings_are_lost_late_and_garbled(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("--patience", "60", "--pace", "0.5")
    said, complaints = process.communicate(timeout=600)
    assert process.returncode == 0, complaints
    assert said.endswith(f"{STOPPED}\nconverged\n")
    counts = re.findall(r"readings lost (\d+), late (\d+), garbled (\d+)", said)[-1]
    assert all(int(count) > 0 for count in counts)


def test_it_stops_when_the_driver_falls_silent(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("--silent-after", "1.5")
    said, complaints = process.communicate(timeout=600)
    assert process.returncode == 1, complaints
    assert said.endswith(f"{STOPPED}\nstopped: the driver has told no good reading for 1 s\n")


def test_it_stops_when_the_driver_dies(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("--patience", "3")
    said = lines_until(process, "phase 0")
    [driver] = re.findall(r"the driver is process (\d+)", said)
    os.kill(int(driver), signal.SIGKILL)
    said, complaints = process.communicate(timeout=600)
    assert process.returncode == 1, complaints
    assert said.endswith(f"{STOPPED}\nstopped: the driver has told no good reading for 3 s\n")


def test_it_stops_and_opens_at_an_interruption(start: Callable[..., subprocess.Popen[str]]) -> None:
    process = start("--patience", "60", "--open")
    lines_until(process, "phase 0")
    process.send_signal(signal.SIGINT)
    said, complaints = process.communicate(timeout=600)
    assert process.returncode == 130, complaints
    assert said.endswith(f"{STOPPED}\nand to open\nstopped: interrupted\n")


# The same, its hand a list of readings


class Told:
    """A driver that has so many readings to tell, all of a hand that rests, and then what ``afterwards`` does."""

    def __init__(self, count: int, afterwards: Callable[[], None]) -> None:
        self._program = program_of(SPEC.read_text("utf-8"), SPEC.name)
        self._readings = iter(range(TARING + count))
        self._afterwards = afterwards
        self.targets = list[Array]()
        self.lost = self.late = 0

    def hello(self, patience: float) -> dict[str, object]:
        """The program's own names, and a place."""
        del patience
        robot = self._program.robot
        place = {"position": [-0.2, 0.0, 0.1], "rotation": np.eye(3).tolist()}
        return {"joints": list(robot.joints), "contacts": list(robot.contacts), **place}

    def reading(self, within: float) -> Reading | None:
        """The next one, of joints that are where they were last sent."""
        number = next(self._readings, None)
        if number is None:
            time.sleep(within)
            self._afterwards()
            return None
        joints = self.targets[-1] if self.targets else np.zeros(len(self._program.robot.joints))
        return Reading(number / 50.0, joints, np.zeros((3, 6)))

    def move_to(self, joints: Array) -> None:
        """Written down."""
        self.targets.append(joints)


def interrupt() -> None:
    raise KeyboardInterrupt


def fail() -> None:
    raise RuntimeError("a cable is loose")


def say_nothing() -> None:
    """Silence."""


@pytest.mark.parametrize(
    ("afterwards", "error"),
    [(interrupt, KeyboardInterrupt), (fail, RuntimeError), (say_nothing, TimeoutError)],
)
def test_on_every_way_out_the_hand_stands_still(afterwards: Callable[[], None], error: type[BaseException]) -> None:
    """It closed before; and no tick moved a joint by more than it may."""
    driver = Told(20, afterwards)
    with pytest.raises(error):
        GRASP(driver._program, driver, 0.1, opens=False)
    steps = np.abs(np.diff(driver.targets, axis=0)).max(axis=-1)
    assert (steps[:19] > 0.0).all()
    assert steps.max() <= MOST
    assert len(steps[19:]) >= 3
    assert not steps[19:].any()


def test_it_opens_on_request() -> None:
    driver = Told(20, interrupt)
    with pytest.raises(KeyboardInterrupt):
        GRASP(driver._program, driver, 0.1, opens=True)
    robot = driver._program.robot
    opened = [robot.hand.postures["open"][name] for name in robot.hand.joints]
    np.testing.assert_allclose(driver.targets[-1][-len(opened) :], opened, atol=1e-12)
    assert np.abs(np.diff(driver.targets, axis=0)).max() <= MOST


def test_it_refuses_another_order_of_joints() -> None:
    driver = Told(1, say_nothing)
    names = driver.hello(0.0)
    driver.hello = lambda _: {**names, "joints": names["joints"][::-1]}
    with pytest.raises(ValueError, match="another order"):
        GRASP(driver._program, driver, 0.1, opens=False)
    assert not driver.targets
