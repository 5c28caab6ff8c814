"""Grasp with a hand of one's own: the controllers of a spec at 50 Hz, with monitors, a watchdog and a safe stop.

    python docs/examples/real_hand.py

The hand is a stand-in (stand_in.py): a process with a clock of its own, whose readings are lost, late or garbled now
and then. For a hand of yours write another Driver; all else stays. docs/real_hand.md says what is asked of it.
"""

from __future__ import annotations

import argparse
import json
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import graspdsl as g
from graspdsl.hands.descriptions import joint_limits

Array = NDArray[np.float64]
SPEC = Path(__file__).resolve().parents[2] / "specs" / "towel_roll_two_contacts.yaml"
RATE = 50.0  # Hz
TARING = 25  # readings at rest
MOST = 0.01  # rad or m that a joint may move in a tick
MOST_AHEAD = 0.05  # rad or m that a target may be ahead of its joint, which what the finger presses on holds up
HELLO = 60.0  # s, in which the driver is there and tells its readings
HOLD_AFTER = 0.1  # s without a reading
OPENING = 150  # ticks


class Driver:
    """The link to the driver of a hand. What cannot be sent or received is lost, as anything may be on its way."""

    def __init__(self, port: int) -> None:
        self._link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._link.connect(("127.0.0.1", port))
        self._newest: int | None = None
        self.lost = self.late = 0

    def hello(self, patience: float) -> dict[str, Any]:
        """What the driver says of its hand: joints, contacts, and where it stands. Raises TimeoutError."""
        until = time.monotonic() + patience
        while time.monotonic() < until:
            self._send({"hello": True})
            message = self._receive(0.5)
            if message is not None and "contacts" in message:
                return message
        raise TimeoutError("the driver does not answer")

    def reading(self, within: float) -> g.Reading | None:
        """The newest reading, where one comes within a time [s]. One that is older than another is of no use."""
        newest: dict[str, Any] | None = None
        while (message := self._receive(within)) is not None:
            if "number" not in message:
                continue
            skipped = 0 if self._newest is None else message["number"] - self._newest - 1
            if skipped < 0:
                self.late, self.lost = self.late + 1, self.lost - 1
                continue
            self.lost, self._newest = self.lost + skipped, message["number"]
            newest, within = message, 0.0  # and those that wait behind it
        if newest is None:
            return None
        return g.Reading(newest["time"], np.array(newest["joints"]), np.array(newest["wrenches"]))

    def move_to(self, joints: Array) -> None:
        """Where the joints are to be a tick from now. It says where, not how far: it may be lost, or come twice."""
        self._send({"target": joints.tolist()})

    def _send(self, message: dict[str, Any]) -> None:
        try:
            self._link.send(json.dumps(message).encode())
        except OSError:
            return  # nobody is there, which the watchdog will notice

    def _receive(self, within: float) -> dict[str, Any] | None:
        self._link.settimeout(within)
        try:
            message: dict[str, Any] = json.loads(self._link.recv(65536))
        except (TimeoutError, BlockingIOError):
            return None
        except OSError:
            time.sleep(within)
            return None
        return message


class Targets:
    """Where the joints are to be, (n,): limits stand between the controllers and the hand."""

    def __init__(self, program: g.Program, joints: Array) -> None:
        self.joints = joints
        self._lower, self._upper = (np.array(limits) for limits in joint_limits(program.robot))

    def displace(self, displacement: Array, now: Array) -> None:
        """Go on by a displacement, the joints being where they are now; all joints are slowed down alike."""
        step = displacement * min(1.0, MOST / max(float(np.abs(displacement).max()), MOST))
        ahead = np.clip(self.joints + step, now - MOST_AHEAD, now + MOST_AHEAD)
        self.joints = np.clip(ahead, self._lower, self._upper)


def grasp(program: g.Program, driver: Driver, patience: float, *, opens: bool) -> str:
    """Run the program on the driver's hand, and say how it ended. The hand stands still then, whatever happened.

    patience [s]: how long there may be no reading; raises TimeoutError after that. opens: whether it lets go at last.
    """
    told = driver.hello(HELLO)
    if told["joints"] != list(program.robot.joints) or told["contacts"] != list(program.robot.contacts):
        raise ValueError("the driver has other joints or contacts than the program, or another order of them")
    hand = g.hand_of(program, np.array(told["position"]), np.array(told["rotation"]))
    rest = readings_at_rest(driver)
    hand.tare(rest)
    targets = Targets(program, rest[-1].joints)
    try:
        return follow(g.ControlLoop(program, RATE), hand, driver, targets, patience)
    finally:  # after an ending, silence, an error, Ctrl-C
        stand_still(driver, targets)
        if opens:
            let_go(program, driver, targets)


def readings_at_rest(driver: Driver) -> Sequence[g.Reading]:
    """Readings for taring: of a hand that does not move, and nothing touches it. Raises TimeoutError."""
    readings, until = list[g.Reading](), time.monotonic() + HELLO
    while len(readings) < TARING:
        reading = driver.reading(within=HOLD_AFTER)
        if reading is not None and np.isfinite(reading.wrenches).all():
            readings.append(reading)
        elif time.monotonic() > until:
            raise TimeoutError("the driver tells too few readings")
    return readings


def follow(loop: g.ControlLoop, hand: g.RealHand, driver: Driver, targets: Targets, patience: float) -> str:
    """One tick for each reading, until the program ends or there are none. What is not read moves nothing."""
    print(f"monitors: {', '.join(loop.monitors)}; silent: {', '.join(loop.silent_monitors)}", flush=True)
    heard, told, garbled, holding = time.monotonic(), -np.inf, 0, False
    while True:
        reading = driver.reading(within=1.0 / RATE)
        try:
            observation = None if reading is None else hand.observe(reading)
        except ValueError:
            observation, garbled = None, garbled + 1
        if observation is None:
            silence = time.monotonic() - heard
            if silence > patience:
                raise TimeoutError(f"the driver has told no good reading for {patience:g} s")
            if silence > HOLD_AFTER and not holding:
                print("no readings: the hand waits", flush=True)
            holding = silence > HOLD_AFTER
            driver.move_to(targets.joints)
            continue
        heard, holding = time.monotonic(), False
        turn = loop.tick(observation)
        targets.displace(turn.command.displacement, observation.joints)
        driver.move_to(targets.joints)
        if turn.ending is not None:
            return ": ".join(filter(None, (turn.ending.outcome, turn.ending.detail)))
        if observation.time >= told + 1.0:
            told = observation.time
            tell(turn, told, np.linalg.norm(observation.forces, axis=-1))
            print(f"    readings lost {driver.lost}, late {driver.late}, garbled {garbled}", flush=True)


def tell(turn: g.Turn, now: float, forces: Array) -> None:
    """A line of a tick."""
    force, moment = (float(np.linalg.norm(part)) for part in (turn.tick.force_residual, turn.tick.moment_residual))
    pressed = " ".join(f"{force:.2f}" for force in forces.tolist())
    print(
        f"{now:8.2f} s  phase {turn.phase}  |ρ_f| {force:.3f}  |ρ_m| {1000 * moment:5.1f} mm  {pressed} N", flush=True
    )


def stand_still(driver: Driver, targets: Targets) -> None:
    """Keep the targets as they are: what is grasped stays grasped. Said thrice, as one word may be lost."""
    for _ in range(3):
        driver.move_to(targets.joints)
    print("the hand is told to stand still", flush=True)


def let_go(program: g.Program, driver: Driver, targets: Targets) -> None:
    """Open the fingers slowly; the arm stays."""
    names, opened = list(program.robot.joints), program.robot.hand.postures["open"]
    closed = targets.joints
    wanted = np.array([opened.get(name, closed[place]) for place, name in enumerate(names)])
    for share in np.linspace(0.0, 1.0, OPENING):
        targets.joints = closed + share * (wanted - closed)
        driver.move_to(targets.joints)
        time.sleep(1.0 / RATE)
    print("and to open", flush=True)


@contextmanager
def stand_in(*options: str) -> Iterator[int]:
    """The port of a stand-in that runs meanwhile. It does not hear the Ctrl-C that is meant for us."""
    command = [sys.executable, str(Path(__file__).with_name("stand_in.py")), str(SPEC), *options]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True) as process:
        assert process.stdout is not None
        print(f"the driver is process {process.pid}", flush=True)
        try:
            yield int(process.stdout.readline())
        finally:
            process.terminate()


def main() -> int:
    """0: the program came to its end, whatever that is; 1: it was stopped; 130: by Ctrl-C."""
    options = argparse.ArgumentParser(description="grasp with a hand of one's own")
    options.add_argument("--patience", type=float, default=1.0, help="how long there may be no reading [s]")
    options.add_argument("--open", action="store_true", help="let go at the end")
    options.add_argument("--pace", default="1", help="of the stand-in's clock")
    options.add_argument("--silent-after", default="inf", help="when the stand-in falls silent [s]")
    given = options.parse_args()
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    program = g.load(SPEC)
    with stand_in("--pace", given.pace, "--silent-after", given.silent_after) as port:
        try:
            ending = grasp(program, Driver(port), given.patience, opens=given.open)
        except TimeoutError as error:
            print(f"stopped: {error}")
            return 1
        except KeyboardInterrupt:
            print("stopped: interrupted")
            return 130
    print(ending)
    return 0


if __name__ == "__main__":
    sys.exit(main())
