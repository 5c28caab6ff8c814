"""Pictures of a stored trial, from its trajectory alone: nothing is simulated again."""

from __future__ import annotations

import math
from collections.abc import Sequence
from types import TracebackType
from typing import Self

import numpy as np
from PIL.Image import Image

from graspdsl.arrays import Array, Float32Array
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import Diagnostic, DiagnosticError
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.runner import program_of_run
from graspdsl.trials.setup import settings_of
from graspdsl.trials.store import RunFolder
from graspdsl.trials.trajectories import Layout, Rows
from graspdsl.worlds.annotations import FORCE, NORMAL, Arrow, annotated, png
from graspdsl.worlds.camera import HEIGHT, OVERSAMPLING, WIDTH
from graspdsl.worlds.kind import View
from graspdsl.worlds.protocol import Start
from graspdsl.worlds.start_pose import pose

NORMAL_LENGTH = 0.03  # m
LONGEST_FORCE = 0.05  # m that an arrow of an ordinary contact force has at most
ORDINARY = 95.0  # percentile of the contact forces of a trial


class Replay:
    """A stored trial to look at, tick by tick. To be closed, or used in a ``with``.

    Raises DiagnosticError when the run holds no such trajectory, or it does not fit the spec.
    """

    def __init__(
        self, folder: RunFolder, number: int, *, width: int = WIDTH, height: int = HEIGHT, window: bool = False
    ) -> None:
        self._program = program_of_run(folder)
        self.record = _record(folder, number)
        self.rows = folder.trajectory(number, Layout.of(self._program))
        self._contacts = list(self._program.phases[-1].grasp.contacts)
        self._drawn = drawn_contacts(self._program)
        _can_be_drawn(self.rows, self._program, number)
        self.scale = force_scale(self.rows["forces"][:, self._contacts])
        world, settings = self._program.world, settings_of(self._program)
        start = self._start() if world.has("hand") else None
        self.studio = world.studio(View(settings, start, self._drawn, self._contacts, window=window))
        self.show(self.ticks - 1)
        self.camera = self.studio.camera(width, height)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        self.studio.close()

    @property
    def ticks(self) -> int:
        """How many ticks were stored."""
        return len(self.rows["time"])

    def show(self, tick: int) -> None:
        """Put hand, object and contacts where they were at a tick."""
        self.studio.show({name: values[tick].astype(float) for name, values in self.rows.items()})

    def picture(self, tick: int, oversampling: int = OVERSAMPLING) -> Image:
        """What a tick looked like, with contact normals and forces on the object and a caption."""
        self.show(tick)
        return annotated(self.studio.picture(self.camera, oversampling), self.arrows(tick), self.caption(tick))

    def arrows(self, tick: int) -> list[Arrow]:
        """The normals into the object and the forces on it where contacts touch; of floating ones, the grasp's."""
        points, normals, forces = (self.rows[name][tick].astype(float) for name in ("points", "normals", "forces"))
        drawn = []
        for contact in (contact for contact in self._drawn if self.rows["touching"][tick, contact]):
            ends = ((NORMAL_LENGTH * normals[contact], NORMAL, 2.0), (self.scale * forces[contact], FORCE, 4.0))
            for along, colour, width in ends:
                start, end = self.camera.pixels(np.stack([points[contact], points[contact] + along]))
                if np.isfinite([start, end]).all():
                    drawn.append(Arrow(start, end, colour, width))
        return drawn

    def caption(self, tick: int) -> list[str]:
        """The trial, the time, the outcome and the force residual, and what the arrows mean."""
        residual = float(self.rows["force_residual"][tick])
        rho = f"‖ρ_f‖ {residual:.3f}" if math.isfinite(residual) else "‖ρ_f‖ none: no contact"
        outcome = self.record.outcome.value
        first = f"trial {self.record.number}   t = {self.rows['time'][tick]:.2f} s   {outcome}   {rho}"
        arrows = f"blue: contact normals, {100 * NORMAL_LENGTH:g} cm"
        if self.scale > 0:
            arrows += f"   orange: forces, 1 N = {100 * self.scale:g} cm"
        return [first, arrows]

    def _start(self) -> Start:
        """Where the hand began: a mount without a base has its root there."""
        if self._program.robot.mount.base is not None:
            return Start(np.zeros(3), np.eye(3), {})
        approach = self._program.spec.trials.start_of(self.record.number).approach or "side"
        surface = self._program.robot.hand.palm_surface
        try:
            return pose(approach, self.record.start, self._program.body, surface)
        except KeyError as error:
            message = f"trial {self.record.number} has no picture: its start has no {error.args[0]}"
            raise DiagnosticError([Diagnostic("run-damaged", message)]) from error


def drawn_contacts(program: Program) -> list[int]:
    """The numbers of the contacts that pictures show: all that a hand has, of floating ones those that a phase uses.

    A finger that no phase uses may still touch and push; a floating contact that none uses only lies about.
    """
    if program.world.has("hand"):
        return list(range(len(program.robot.contacts)))
    return sorted({contact for phase in program.phases for contact in phase.grasp.contacts})


def frame(folder: RunFolder, number: int) -> bytes | None:
    """A picture of the last tick of a trial, a PNG; None where nothing whole is stored to draw it from."""
    try:
        with Replay(folder, number) as replay:
            return png(replay.picture(replay.ticks - 1))
    except (DiagnosticError, OSError, ValueError):
        return None


def force_scale(forces: Array | Float32Array) -> float:
    """The length [m] of an arrow for 1 N, a round number, for forces (..., 3) [N]; 0 where there are none."""
    sizes = np.linalg.norm(forces, axis=-1)
    sizes = sizes[np.isfinite(sizes) & (sizes > 0)]
    if len(sizes) == 0:
        return 0.0
    most = LONGEST_FORCE / float(np.percentile(sizes, ORDINARY))
    power = 10.0 ** math.floor(math.log10(most))
    return next(round_number * power for round_number in (5.0, 2.0, 1.0) if round_number * power <= most)


def evenly(ticks: int, count: int) -> list[int]:
    """Tick numbers spread evenly over so many, the first and the last among them; never one twice."""
    return sorted({round(tick) for tick in np.linspace(0, ticks - 1, max(count, 1))} if count > 1 else {ticks - 1})


def _record(folder: RunFolder, number: int) -> TrialRecord:
    for record in folder.records(number):
        return record
    message = f"this run has no trial {number}"
    raise DiagnosticError([Diagnostic("unknown-trial", message, hint=f"it has {_said(sorted(folder.identities()))}")])


def _said(numbers: Sequence[int]) -> str:
    """Numbers with those that follow on one another as ranges."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{part[0]}…{part[-1]}" if len(part) > 1 else f"{part[0]}" for part in parts) or "none"


def _can_be_drawn(rows: Rows, program: Program, number: int) -> None:
    """Raises DiagnosticError where a trial ended before its first tick, or its object was lost."""
    placed = ("object_position", "object_rotation") if program.world.has("motion") else ()
    if not rows or not all(np.isfinite(rows[name]).all() for name in placed):
        what = f"there is nothing whole to draw of trial {number}"
        raise DiagnosticError([Diagnostic("run-damaged", what, hint="look at another trial")])
