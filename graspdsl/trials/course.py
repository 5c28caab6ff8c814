"""What a trial is, from its first observation to its outcome: phases, stages, end conditions, monitors, time limits.

It is written once, for N trials that begin together and are seen side by side, in a world or by a hand of one's own.
What becomes of a trial does not depend on those beside it, to the last bit.
"""

from __future__ import annotations

import dataclasses
import math
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.basis.algebra import length
from graspdsl.basis.resources import ContactSet
from graspdsl.compiler.graph import ControllerGraph
from graspdsl.compiler.phase import conditions_lowered
from graspdsl.compiler.pipeline import Pipeline, Ticks
from graspdsl.compiler.program import Program
from graspdsl.diagnostics import listed
from graspdsl.spec.program import Until
from graspdsl.spec.watching import Setting, Sight, When
from graspdsl.trials.logbook import NEVER, Logbook
from graspdsl.trials.outcomes import Ending, Outcome
from graspdsl.worlds.protocol import (
    Command,
    ManyWorld,
    Observation,
    Start,
    Truth,
    Witness,
    WitnessedWorld,
    WorldCrashError,
    WorldInfo,
)

ROUNDING = 1e-9  # s
LEAST_DIGITS, MOST_DIGITS = 3, 6


Batch = TypeVar("Batch", Observation, Truth, Ticks)


@dataclass(frozen=True, slots=True)
class Stage:
    """A controller of a phase that is run until its end conditions have held; ``number`` counts over all phases.

    ``kept``: the conditions of stages before it in its phase that must not be given up again, by the numbers of those
    stages; ``goes_back``: whether one of them is begun anew if they are. ``full_time``: whether it goes on to the limit
    though its conditions hold. ``name``: what messages call it; nothing where its phase has no other.
    """

    number: int
    phase: int
    grasp: ContactSet
    pipeline: Pipeline
    until: Until
    limit: float
    kept: Mapping[int, Until]
    goes_back: bool
    full_time: bool
    name: str

    @property
    def awaits_residual(self) -> bool:
        """Whether a residual is bounded."""
        return not (self.until.force_residual is None and self.until.moment_residual is None)


def stages_of(program: Program) -> list[Stage]:
    """The stages of a program's phases, one after the other."""
    stages: list[Stage] = []
    phases = zip(program.phases, program.spec.program, program.pipelines(), strict=True)
    for index, (phase, settings, pipelines) in enumerate(phases):
        first = len(stages)
        conditions = [*(until_of(graph, settings.until) for graph in phase.stages[:-1]), settings.until]
        for place, (pipeline, until) in enumerate(zip(pipelines, conditions, strict=True)):
            before = enumerate(conditions[:place])
            kept = {first + earlier: loosened(condition, settings.hysteresis or 1.0) for earlier, condition in before}
            stage = Stage(
                number=first + place,
                phase=index,
                grasp=phase.grasp,
                pipeline=pipeline,
                until=until,
                limit=settings.limit,
                kept=kept,
                goes_back=settings.hysteresis is not None,
                full_time=settings.full_time and place == len(pipelines) - 1,
                name=f"stage {place + 1} of {len(pipelines)}" if len(pipelines) > 1 else "",
            )
            stages.append(stage)
    return stages


def until_of(graph: ControllerGraph, until: Until) -> Until:
    """The part of a phase's end conditions that a stage can meet: those on what its potentials lower."""
    kept = {name: getattr(until, name) for name in conditions_lowered(graph)}
    conditions = kept if any(kept.values()) else {"contact": "all"}
    return Until.model_validate({**conditions, "hold": until.hold})


def loosened(until: Until, factor: float) -> Until:
    """End conditions with bounds larger by a factor."""
    scaled = {
        name: None if bound is None else bound * factor
        for name, bound in (("force_residual", until.force_residual), ("moment_residual", until.moment_residual))
    }
    return until.model_copy(update=scaled)


@dataclass(frozen=True, slots=True)
class Turns:
    """One tick of M trials: ``command`` of the controllers of their stages; ``endings`` of those that end, by their
    places among the M; ``made``: what each controller made of what it saw, and of which of the M, in turn."""

    command: Command
    endings: Mapping[int, Ending]
    made: Sequence[tuple[Rows, Ticks]]


class Course:
    """N trials of a program on their way, whoever carries out what they are commanded.

    ``trials``: those that still run, in the order of the rows in which they are seen. ``log`` holds their numbers,
    ``wall_s`` (N,) the time [s] spent on each in a world: of a tick of several trials, equal shares.
    """

    def __init__(
        self,
        program: Program,
        stages: Sequence[Stage],
        info: WorldInfo,
        seen: Observation,
        truth: Truth,
        *,
        trajectories: bool = True,
    ) -> None:
        """seen, truth: of all trials as they begin. trajectories: whether to keep these, and what becomes of the
        priorities."""
        self._stages, self._info, self._seen = stages, info, seen
        count = len(seen.joints)
        grasps = [phase.grasp for phase in program.phases]
        self.trials = np.arange(count)
        pipelines = [stage.pipeline for stage in stages]
        self.log = Logbook(grasps, truth.object_position, pipelines, trajectories=trajectories)
        self._certifies = trajectories
        self.wall_s = np.zeros(count)
        self._number = 0
        self._at = np.zeros(count, dtype=np.intp)
        self._deadline = np.full(count, seen.time + stages[0].limit)
        self._touched = np.full(count, stages[0].until.contact is None)
        self._held_from = np.full(count, np.nan)
        self._handed_over: dict[tuple[int, str], Array] = {}
        self._monitors = program.monitors.watches(
            Setting(
                contacts=info.contacts,
                joints=info.joints,
                palm=program.robot.hand.palm,
                lower=info.lower,
                upper=info.upper,
                began=seen.joints,
                curvature_radius=program.spec.control.curvature_radius,
                probes=program.probes,
                rate=info.rate,
            )
        )
        self._monitors_at = {
            when: sorted((monitor for monitor in self._monitors if monitor.when is when), key=lambda found: found.turn)
            for when in When
        }

    def run(self, world: ManyWorld) -> Iterator[tuple[int, Ending, Witness | None]]:
        """Run all in the world in which they have taken up their starts. Each comes as it ends: its place among the N,
        its ending, and who knows what its grasp is like then; nobody does where the world failed."""
        seen = self._seen
        command: Command | None = None
        endings: Mapping[int, Ending]
        while len(self.trials):
            began, truth = time.perf_counter(), None
            try:
                if command is not None:
                    seen = world.step(command)
                truth = world.truth()
                turns = self.tick(seen, truth)
                command, endings = turns.command, turns.endings
            except WorldCrashError as error:
                endings = dict.fromkeys(range(len(self.trials)), Ending(Outcome.CRASHED, str(error)))
            self.wall_s[self.trials] += (time.perf_counter() - began) / len(self.trials)
            for row, ending in sorted(endings.items()):
                yield int(self.trials[row]), ending, None if truth is None else _witness(world, truth, row)
            if endings:
                going = np.setdiff1d(np.arange(len(self.trials)), list(endings))
                self.trials = self.trials[going]
                world.keep(going)
                command = command and Command(command.space, command.displacement[going])

    def tick(self, seen: Observation, truth: Truth) -> Turns:
        """The next tick of the trials that still run.

        A trial that begins another stage is looked at again, by the controller of that one, at the same tick.
        """
        trials, endings, made = self.trials, dict[int, Ending](), list[tuple[Rows, Ticks]]()
        command = Command("", np.zeros(0))
        due = np.arange(len(trials))
        while len(due):
            at, due_next = self._at[trials[due]], []
            for number in np.unique(at):
                rows, stage = due[at == number], self._stages[number]
                chosen, true = of_rows(seen, rows, len(trials)), of_rows(truth, rows, len(trials))
                ticks, ended, moved = self._look(stage, self._number, trials[rows], chosen, true)
                endings |= {int(rows[place]): ending for place, ending in ended.items()}
                if command.space != stage.pipeline.space:
                    command = Command(stage.pipeline.space, np.zeros((len(trials), *ticks.displacement.shape[1:])))
                command.displacement[rows] = ticks.displacement
                made.append((rows, ticks))
                due_next.append(rows[moved])
            due = np.sort(np.concatenate(due_next))
        self._number += 1
        return Turns(command, endings, made)

    def stage(self, trial: int) -> Stage:
        """The one that a trial is in."""
        return self._stages[int(self._at[trial])]

    def _look(
        self, stage: Stage, tick: int, trials: Rows, seen: Observation, truth: Truth
    ) -> tuple[Ticks, dict[int, Ending], Flags]:
        """What a stage makes of a tick of M trials: its ticks, how some of them end, by their places among the M, and
        which go to another stage."""
        ticks = stage.pipeline.ticks(seen, certified=self._certifies)
        now = self.log.write(tick, trials, stage.phase, stage.number, seen, truth, ticks)
        contacts = list(stage.grasp.contacts)
        touch = seen.touching[:, contacts].all(axis=-1)
        met = touch & is_low(stage.until, ticks)
        self._note_held(tick, trials, seen.time, met)
        self._touched[trials] |= touch
        held = seen.time - self._held_from[trials]

        def waited_for(place: int) -> str:
            """What keeps a trial from the end of the stage: conditions that do not hold, or how long all have."""
            if met[place]:
                return f"the end conditions held for {held[place]:.1f} s of {stage.until.hold:g} s"
            away = [self._info.contacts[contact] for contact in contacts if not seen.touching[place, contact]]
            return unmet(stage.until, of_rows(ticks, np.array([place]), len(trials)), away)

        sight = Sight(
            rows=trials,
            time=seen.time,
            grasp=stage.grasp.contacts,
            touching=seen.touching,
            touched=self._touched[trials],
            joints=seen.joints,
            stopped=_stopped(self._info.joints, truth) | ticks.locked,
            links=truth.touching_links,
            table_links=truth.table_links,
            lean=np.asarray(truth.object_lean),
            shift=self.log.shift[trials],
            force_residual=now.force_residual,
            moment_residual=now.moment_residual,
            met=met,
            awaits_residual=stage.awaits_residual,
            limit=stage.limit,
            waited_for=waited_for,
        )
        finite = np.isfinite(truth.object_position).all(axis=-1) & np.isfinite(seen.points).all(axis=(-2, -1))
        running = np.asarray(finite)
        endings = {int(place): LEFT_NUMBERS for place in np.flatnonzero(~running)}
        self._ask(When.TICK, sight, running, endings)
        late: Flags = seen.time >= self._deadline[trials] - ROUNDING
        due = late | (not stage.full_time)
        done: Flags = running & met & (held >= stage.until.hold - ROUNDING) & due
        running &= ~done
        after = np.full(len(trials), stage.number)
        for earlier, until in stage.kept.items():
            given_up = running & ~is_low(until, ticks) & stage.goes_back
            after[given_up] = earlier
            running &= ~given_up
        self._ask(When.STAYING, sight, running, endings, due)
        endings |= {int(place): self._out_of_time(sight, int(place)) for place in np.flatnonzero(running & late)}
        endings = {place: self._told(ending, stage, trials, ticks, place) for place, ending in endings.items()}
        if stage.number + 1 < len(self._stages):
            after[done] = stage.number + 1
        else:
            self._ask(When.END, sight, done, endings)
            endings |= {int(place): Ending(Outcome.CONVERGED) for place in np.flatnonzero(done)}
        moved = after != stage.number
        for name, (values, _) in _bounded(stage.until, ticks).items() if done.any() else ():
            noted = self._handed_over.setdefault((stage.number, name), np.full(len(self._at), np.nan))
            noted[trials[done]] = values[done]
        self._move(trials[moved], stage, after[moved], seen.time)
        return ticks, endings, moved

    def _note_held(self, tick: int, trials: Rows, now: float, met: Flags) -> None:
        """Since when the end conditions have held."""
        begins = met & np.isnan(self._held_from[trials])
        self._held_from[trials[begins]], self.log.held_since[trials[begins]] = now, tick
        self._held_from[trials[~met]], self.log.held_since[trials[~met]] = np.nan, NEVER

    def _ask(
        self, when: When, sight: Sight, running: Flags, endings: dict[int, Ending], due: Flags | bool = True
    ) -> None:
        """Ask the monitors of a moment about trials that are running: those that one ends, if that is ``due``, run no
        more."""
        for monitor in self._monitors_at[when]:
            ended = monitor.speaks(sight) & running & due
            if not ended.any():
                continue
            for place in np.flatnonzero(ended):
                endings[int(place)] = Ending(monitor.outcome, monitor.detail(sight, int(place)))
            running &= ~ended

    def _out_of_time(self, sight: Sight, place: int) -> Ending:
        """What kept a trial from the end of its phase: what a monitor knows of, or just time."""
        for monitor in self._monitors:
            if (said := monitor.out_of_time(sight, place)) is not None:
                return Ending(monitor.outcome, said)
        detail = f"not converged within {sight.limit:g} s: {sight.waited_for(place)}"
        return Ending(Outcome.TIMEOUT, detail)

    def _told(self, ending: Ending, stage: Stage, trials: Rows, ticks: Ticks, place: int) -> Ending:
        """An ending with the stage in which it came; undone, where a grasp settled in one that has given up what one
        before it had brought about."""
        for earlier, until in stage.kept.items() if ending.outcome.settled else ():
            for name, (values, bound) in _bounded(until, ticks).items():
                before, now = self._handed_over[earlier, name][trials[place]], values[place]
                if now >= bound:
                    was = f"was {_said(name, before, bound)}, below {_said(name, bound)}"
                    when = f"when {self._stages[earlier].name} ended, and is {_said(name, now, bound)}"
                    cure = f"{stage.name} raised it; with hysteresis the phase goes back"
                    return Ending(Outcome.UNDONE, f"{_TOLD[name][0]} {was}, {when}: {cure}")
        return Ending(ending.outcome, f"in {stage.name}: {ending.detail}") if stage.name else ending

    def _move(self, trials: Rows, before: Stage, after: Rows, now: float) -> None:
        """Trials begin other stages."""
        self._at[trials], self._held_from[trials] = after, np.nan
        for number in np.unique(after):
            stage, chosen = self._stages[number], trials[after == number]
            self._touched[chosen] = stage.until.contact is None
            if stage.phase != before.phase:
                self._deadline[chosen] = now + stage.limit
        for monitor in self._monitors:
            monitor.begin_anew(trials)


LEFT_NUMBERS = Ending(Outcome.CRASHED, "the simulation left the realm of numbers")


# End conditions, as the hand senses them


def is_low(until: Until, ticks: Ticks) -> Flags:
    """Whether residuals and force error are below their bounds, those that are given and can be measured, (...)."""
    low = np.ones(ticks.force_residual.shape[:-1], dtype=bool)
    for value, bound in _bounded(until, ticks).values():
        low &= ~(value >= bound)
    return low


def unmet(until: Until, ticks: Ticks, away: Sequence[str]) -> str:
    """Every condition that does not hold at a tick of one trial, with its value and bound; nothing where all hold.

    away: the names of the contacts that do not touch.
    """
    said = [f"{listed(away)} {'does' if len(away) == 1 else 'do'} not touch"] if away else []
    for name, (measured, bound) in _bounded(until, ticks).items():
        value = float(measured.item())
        if value >= bound:
            said.append(f"{_TOLD[name][0]} = {_said(name, value, bound)}, not below {_said(name, bound)}")
    return ", and ".join(said)


def _bounded(until: Until, ticks: Ticks) -> dict[str, tuple[Array, float]]:
    """Values (...) and bound of each condition that is given, by the names of the spec; NaN where none is measured."""
    measured = {
        "force_residual": length(ticks.force_residual),
        "moment_residual": length(ticks.moment_residual),
        "force_error": ticks.force_error,
    }
    bounds = {name: getattr(until, name) for name in measured}
    return {name: (value, bounds[name]) for name, value in measured.items() if bounds[name] is not None}


# What is bounded, by the names of the spec: in words, its unit, and how many of these make one of the spec's.
_TOLD = {
    "force_residual": ("‖ρ_f‖", "", 1.0),
    "moment_residual": ("‖ρ_m‖", " mm", 1000.0),
    "force_error": ("the largest error of a contact force", " N", 1.0),
}


def _said(name: str, value: float, bound: float = math.nan) -> str:
    """A value of what is bounded, with as many digits as tell it from the bound, three at least."""
    _, unit, scale = _TOLD[name]
    if math.isnan(bound):
        return f"{scale * value:g}{unit}"
    texts = [f"{scale * value:.{digits}g}" for digits in range(LEAST_DIGITS, MOST_DIGITS + 1)]
    return next((text for text in texts if float(text) != scale * bound), texts[-1]) + unit


# Many trials and one


def of_rows(whole: Batch, rows: Rows, count: int) -> Batch:
    """What of an observation, a truth or ticks of so many trials is of these rows, in order."""
    if len(rows) == count:
        return whole
    parts: dict[str, Any] = {field.name: getattr(whole, field.name) for field in dataclasses.fields(whole)}
    for name, value in parts.items():
        if isinstance(value, tuple):
            parts[name] = tuple(value[row] for row in rows)
        elif isinstance(value, np.ndarray):
            parts[name] = value[rows]
    return dataclasses.replace(whole, **parts)


def _stopped(joints: Sequence[str], truth: Truth) -> Flags:
    """Which joints the last step would have sent beyond their limits, (M, n)."""
    stopped = [[joint in names for joint in joints] for names in truth.stopped_joints]
    return np.array(stopped, dtype=bool).reshape(len(stopped), len(joints))


class Alone:
    """A world of one trial as one of many: with a leading axis of one."""

    def __init__(self, world: WitnessedWorld) -> None:
        self.world, self.info = world, world.info
        self._seen: Observation | None = None

    def join(self, start: Start, seed: int) -> None:
        """The one trial takes up its start."""
        self._seen = self.world.reset(start, seed)

    def observe(self) -> Observation:
        """What it sensed then."""
        assert self._seen is not None
        return led(self._seen)

    def step(self, command: Command) -> Observation:
        """Carry out its command."""
        return led(self.world.step(Command(command.space, command.displacement[0])))

    def truth(self) -> Truth:
        """The world's."""
        return led(self.world.truth())

    def keep(self, rows: Rows) -> None:
        """There is no other."""

    def close(self) -> None:
        """As of the world."""
        self.world.close()


def led(alone: Batch) -> Batch:
    """What is of one trial, with a leading axis; the time has none."""
    parts: dict[str, Any] = {field.name: getattr(alone, field.name) for field in dataclasses.fields(alone)}
    led: dict[str, Any] = {
        name: (value,) if isinstance(value, tuple) else np.asarray(value)[None]
        for name, value in parts.items()
        if name != "time"
    }
    return dataclasses.replace(alone, **led)


@dataclass(frozen=True, slots=True)
class _Shown:
    """Knows the truth of one of many trials."""

    shown: Truth

    def truth(self) -> Truth:
        return self.shown


def _witness(world: ManyWorld, truth: Truth, row: int) -> Witness:
    """Who knows the truth of a trial: the world itself where it is the only one, and can be put to tests then."""
    if isinstance(world, Alone):
        return world.world
    parts: dict[str, Any] = {field.name: getattr(truth, field.name)[row] for field in dataclasses.fields(truth)}
    return _Shown(Truth(**parts))
