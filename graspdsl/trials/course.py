"""What a trial is, from its first observation to its outcome: phases, stages, end conditions, monitors, time limits.

It is written once, for N trials that begin together and are seen side by side, in a world or by a hand of one's own.
What becomes of a trial does not depend on those beside it, to the last bit.
"""

from __future__ import annotations

import dataclasses
import functools
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

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
    Found,
    ManyWorld,
    Observation,
    Shown,
    Start,
    Test,
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
    though its conditions hold. ``name``: what messages call it; nothing where its phase has no other. ``contacts``: of
    the grasp, by number.
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
    contacts: Sequence[int]

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
                contacts=list(phase.grasp.contacts),
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


After = Callable[[int, Ending, Witness | None], Test[Found]]
"""What comes after the end of a trial, by its place and its ending: with who knows what its grasp is like then, nobody
where the world failed."""


def over(_place: int, ending: Ending, witness: Witness | None) -> Test[tuple[Ending, Witness | None]]:
    """Nothing comes after."""
    yield from ()
    return ending, witness


class _Tests(Generic[Found]):
    """What is done with trials after their end, by their places: the tests that are ``running``, the ``commands`` that
    they gave last, and what was ``found`` by those that are over."""

    def __init__(self) -> None:
        self.running: dict[int, Test[Found]] = {}
        self.commands: dict[int, Command] = {}
        self.found: dict[int, Found] = {}

    def begin(self, place: int, test: Test[Found]) -> None:
        """The first command of a test."""
        self._go_on(place, test, functools.partial(next, test))

    def show(self, place: int, shown: Shown) -> None:
        """What has come of the last command, for the next."""
        test = self.running[place]
        self._go_on(place, test, functools.partial(test.send, shown))

    def end(self, place: int, error: WorldCrashError) -> None:
        """The last command could not be carried out, nor can any other."""
        test = self.running[place]
        while place in self.running:
            self._go_on(place, test, functools.partial(test.throw, error))

    def _go_on(self, place: int, test: Test[Found], ask: Callable[[], Command]) -> None:
        try:
            self.commands[place], self.running[place] = ask(), test
        except StopIteration as end:
            self.found[place] = end.value
            self.running.pop(place, None)
            self.commands.pop(place, None)


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
            ),
            program.world.lacks,
        )
        self._monitors_at = {
            when: sorted((monitor for monitor in self._monitors if monitor.when is when), key=lambda found: found.turn)
            for when in When
        }

    def run(self, world: ManyWorld, after: After[Found]) -> Iterator[tuple[int, Found]]:
        """Run all in the world in which they have taken up their starts, and what comes after the end of each beside
        those that still run. Each comes as that is over: its place among the N, and what was found."""
        rows, seen, tests = self.trials, self._seen, _Tests[Found]()
        command: Command | None = None
        while len(rows):
            began = time.perf_counter()
            try:
                if command is not None:
                    seen = world.step(command)
                command = self._turn(world, rows, seen, after, tests)
            except WorldCrashError as error:
                command = None
                crashed = error.crashed or dict.fromkeys(range(len(rows)), str(error))
                for place, said in ((int(rows[row]), said) for row, said in sorted(crashed.items())):
                    if place in tests.running:
                        tests.end(place, WorldCrashError(said))
                    else:
                        tests.begin(place, after(place, Ending(Outcome.CRASHED, said), None))
                self.trials = np.setdiff1d(self.trials, rows[list(crashed)])
            self.wall_s[rows] += (time.perf_counter() - began) / len(rows)
            yield from sorted(tests.found.items())
            if tests.found:
                going = np.flatnonzero(~np.isin(rows, list(tests.found)))
                rows = rows[going]
                world.keep(going)
                command = command and Command(command.space, command.displacement[going])
                tests.found.clear()
                if command is None and len(rows):
                    seen = world.observe()

    def _turn(
        self, world: ManyWorld, rows: Rows, seen: Observation, after: After[Found], tests: _Tests[Found]
    ) -> Command | None:
        """A tick of trials, by their places in the rows of a world: the command that follows from it, in these rows;
        None where all are over."""
        truth, running = world.truth(), np.isin(rows, self.trials)
        for row in np.flatnonzero(~running).tolist():
            tests.show(int(rows[row]), (seen.row(row), truth.row(row)))
        given = list[Command]()
        if running.any():
            chosen = np.flatnonzero(running)
            turns = self.tick(of_rows(seen, chosen, len(rows)), of_rows(truth, chosen, len(rows)))
            for place, ending in sorted(turns.endings.items()):
                row = int(chosen[place])
                tests.begin(int(rows[row]), after(int(rows[row]), ending, world.witness(row)))
            self.trials = np.delete(self.trials, list(turns.endings))
            given += [turns.command] if len(self.trials) else []
            if running.all() and not tests.commands:
                return turns.command
        given += tests.commands.values()
        if not given:
            return None
        displacement = np.zeros((len(rows), given[0].displacement.shape[-1]))
        if len(self.trials):
            displacement[running] = given[0].displacement
        for place, command in tests.commands.items():
            displacement[rows == place] = command.displacement
        return Command(given[0].space, displacement)

    def tick(self, seen: Observation, truth: Truth) -> Turns:
        """The next tick of the trials that still run.

        A trial that begins another stage is looked at again, by the controller of that one, at the same tick.
        """
        trials, endings, made = self.trials, dict[int, Ending](), list[tuple[Rows, Ticks]]()
        command = Command("", np.zeros(0))
        due = np.arange(len(trials))
        while len(due):
            at, due_next = self._at[trials[due]], []
            alike = bool((at == at[0]).all())
            for number in at[:1] if alike else np.unique(at):
                rows, stage = due if alike else due[at == number], self._stages[number]
                chosen, true = of_rows(seen, rows, len(trials)), of_rows(truth, rows, len(trials))
                ticks, ended, moved = self._look(stage, self._number, trials[rows], chosen, true)
                endings |= {int(rows[place]): ending for place, ending in ended.items()}
                if len(rows) == len(trials) and not moved.any():
                    command = Command(stage.pipeline.space, ticks.displacement)
                else:
                    if command.space != stage.pipeline.space:
                        command = Command(stage.pipeline.space, np.zeros((len(trials), *ticks.displacement.shape[1:])))
                    command.displacement[rows] = ticks.displacement
                made.append((rows, ticks))
                due_next.append(rows[moved])
            due = due_next[0] if alike else np.sort(np.concatenate(due_next))
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
        contacts = stage.contacts
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
            grasp=tuple(contacts),
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
        running = _are_numbers(truth.object_position, seen.points)
        endings = {int(place): LEFT_NUMBERS for place in np.flatnonzero(~running)}
        self._ask(When.TICK, sight, running, endings)
        late: Flags = seen.time >= self._deadline[trials] - ROUNDING
        due = late | (not stage.full_time)
        done: Flags = running & met & (held >= stage.until.hold - ROUNDING) & due
        running &= ~done
        after = np.full(len(trials), stage.number)
        any_done = bool(done.any())
        for earlier, until in stage.kept.items():
            given_up = running & ~is_low(until, ticks) & stage.goes_back
            after[given_up] = earlier
            running &= ~given_up
        self._ask(When.STAYING, sight, running, endings, due)
        endings |= {int(place): self._out_of_time(sight, int(place)) for place in np.flatnonzero(running & late)}
        endings = {place: self._told(ending, stage, trials, ticks, place) for place, ending in endings.items()}
        if stage.number + 1 < len(self._stages):
            after[done] = stage.number + 1
        elif any_done:
            self._ask(When.END, sight, done, endings)
            endings |= {int(place): Ending(Outcome.CONVERGED) for place in np.flatnonzero(done)}
        for name, (values, _) in _bounded(stage.until, ticks).items() if any_done else ():
            noted = self._handed_over.setdefault((stage.number, name), np.full(len(self._at), np.nan))
            noted[trials[done]] = values[done]
        moved = after != stage.number
        if moved.any():
            self._move(trials[moved], stage, after[moved], seen.time)
        return ticks, endings, moved

    def _note_held(self, tick: int, trials: Rows, now: float, met: Flags) -> None:
        """Since when the end conditions have held."""
        since, ticks = self._held_from[trials], self.log.held_since[trials]
        begins = np.isnan(since)
        self._held_from[trials] = np.where(met, np.where(begins, now, since), np.nan)
        self.log.held_since[trials] = np.where(met, np.where(begins, tick, ticks), NEVER)

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
        "force_residual": (ticks.force_residual, until.force_residual),
        "moment_residual": (ticks.moment_residual, until.moment_residual),
        "force_error": (ticks.force_error, until.force_error),
    }
    return {
        name: (value if name == "force_error" else length(value), bound)
        for name, (value, bound) in measured.items()
        if bound is not None
    }


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


def _are_numbers(*arrays: Array) -> Flags:
    """Whether all that arrays (M, ...) hold of a trial is finite, (M,)."""
    whole: Flags = np.logical_and.reduce([np.isfinite(array).reshape(len(array), -1).all(axis=-1) for array in arrays])
    return whole


def _stopped(joints: Sequence[str], truth: Truth) -> Flags:
    """Which joints the last step would have sent beyond their limits, (M, n)."""
    if not any(truth.stopped_joints):
        return np.zeros((len(truth.stopped_joints), len(joints)), dtype=bool)
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

    def witness(self, row: int) -> Witness:
        """The world itself."""
        del row
        return self.world

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
