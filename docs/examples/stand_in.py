"""A stand-in for the driver of a hand: a process of its own with a clock of its own, that talks over UDP.

It moves a simulated Barrett hand before a towel roll and tells what the driver of a real one would. Some of its
readings are lost, some come late, in some a number is none; its load cells have biases and noise. It carries out the
newest target of the joints that it has heard of, so the hand stands still when nobody asks for more. real_hand.py
starts it, and says this to it, and hears that from it, in JSON:

    {"hello": true}             {"joints": names, "contacts": names, "position": (3,), "rotation": (3, 3)}
    {"target": (n,)}            {"number": of the tick, "time": s, "joints": (n,), "wrenches": (k, 6)}, each tick
    {"bye": true}
"""

from __future__ import annotations

import argparse
import json
import math
import socket
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.basis.algebra import cross
from graspdsl.compiler.program import program_of
from graspdsl.trials.setup import world_of
from graspdsl.worlds.protocol import Command
from graspdsl.worlds.rigid.world import RigidWorld
from graspdsl.worlds.start_pose import pose

START = {"roll": 0.4, "height": 0.1, "standoff": 0.047, "yaw": 0.0, "offset": 0.0, "tilt": 0.0}
SWITCHED_ON = 1000.0  # s, of its clock
BIAS = np.repeat([0.3, 3e-3], 3)  # N and N·m, standard deviations
NOISE = np.repeat([5e-3, 5e-5], 3)
LOST, LATE, GARBLED = 0.03, 0.05, 0.01  # shares of the readings
DELAY = 3  # ticks by which a late one comes later
FORSAKEN = 60.0  # s without a word, after which it ends


class StandIn:
    """A hand, its clock and its link. pace: seconds of that clock to one of ours; silent_after [s] from its first
    target on it tells nothing more."""

    def __init__(self, spec: Path, pace: float, silent_after: float) -> None:
        program = program_of(spec.read_text("utf-8"), spec.name, folder=spec.parent)
        world = world_of(program)
        assert isinstance(world, RigidWorld)
        self._world = world
        self._start = pose("side", START, program.body, program.robot.hand.palm_surface)
        self._target = self._world.reset(self._start, seed=1).joints
        self._pace, self._silent_after = pace, silent_after
        self._random = np.random.default_rng(1)
        self._bias = BIAS * self._random.normal(size=(len(program.robot.contacts), 6))
        self._kept_back: list[tuple[int, bytes]] = []
        self._link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._link.bind(("127.0.0.1", 0))
        self._link.setblocking(False)
        self.port: int = self._link.getsockname()[1]
        self._listener: Any = None

    def run(self) -> None:
        """Tick by tick. Where the computer is too slow for it, so is its clock."""
        tick, silent_from, rate = 0, math.inf, self._world.info.rate
        due = heard = time.monotonic()
        while time.monotonic() - heard < FORSAKEN:
            target = self._target
            for message in self._told():
                heard = time.monotonic()
                if "bye" in message:
                    return
                if "hello" in message:
                    self._introduce()
                if "target" in message:
                    target = np.array(message["target"])
                    silent_from = min(silent_from, tick + self._silent_after * rate)
            self._world.step(Command("q", target - self._target))
            self._target = target
            tick += 1
            if tick < silent_from:
                self._tell(tick, SWITCHED_ON + tick / rate)
            now, due = time.monotonic(), due + 1.0 / (rate * self._pace)
            time.sleep(max(0.0, due - now))
            due = max(now, due)

    def _told(self) -> Iterator[dict[str, Any]]:
        """What has been said to it since."""
        while True:
            try:
                text, self._listener = self._link.recvfrom(65536)
            except BlockingIOError:
                return
            yield json.loads(text)

    def _introduce(self) -> None:
        """Its names, and where the mounting face is when all joints of the gantry are zero."""
        names = {"joints": self._world.info.joints, "contacts": self._world.info.contacts}
        place = {"position": self._start.position.tolist(), "rotation": self._start.rotation.tolist()}
        self._link.sendto(json.dumps({**names, **place}).encode(), self._listener)

    def _tell(self, tick: int, now: float) -> None:
        """A reading; or not, or some ticks later, or with a number that is none."""
        wrenches = loads(self._world) + self._bias
        wrenches += NOISE * self._random.normal(size=wrenches.shape)
        lost, late, garbled = self._random.random(3) < (LOST, LATE, GARBLED)
        if garbled:
            wrenches[0, 0] = math.nan
        joints = self._world.hand.joints()
        reading = {"number": tick, "time": now, "joints": joints.tolist(), "wrenches": wrenches.tolist()}
        if not lost:
            self._kept_back.append((tick + DELAY * late, json.dumps(reading).encode()))
        for when, message in self._kept_back:
            if when <= tick and self._listener is not None:
                self._link.sendto(message, self._listener)
        self._kept_back = [kept for kept in self._kept_back if kept[0] > tick]


def loads(world: RigidWorld) -> Array:
    """What object and weight put on the fingertips (k, 6), about the origins of their links.

    The engine tells what holds up against that, about the tips' centres of mass.
    """
    levers = np.array([tip.centre + tip.weight_lever for tip in world.hand.tips])
    forces, moments = np.hsplit(-world.stage.fingertips.wrenches(), 2)
    return np.hstack([forces, moments + cross(levers, forces)])


def main() -> None:
    """Say the port on the first line, then be a hand."""
    options = argparse.ArgumentParser(description="a stand-in for the driver of a hand")
    options.add_argument("spec", type=Path)
    options.add_argument("--pace", type=float, default=1.0)
    options.add_argument("--silent-after", type=float, default=math.inf)
    given = options.parse_args()
    stand_in = StandIn(given.spec, given.pace, given.silent_after)
    print(stand_in.port, flush=True)
    stand_in.run()


if __name__ == "__main__":
    main()
