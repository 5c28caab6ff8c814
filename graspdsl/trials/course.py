"""What a trial is, from its first observation to its outcome: phases, stages, end conditions, monitors, time limits.

It is written once, for trials that are seen side by side, in a world or by a hand of one's own, whenever each began.
What becomes of a trial does not depend on those beside it, to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array, Flags, Rows
from graspdsl.compiler.pipeline import Ticks
from graspdsl.compiler.program import Program
from graspdsl.spec.watching import Setting, Sight, When
from graspdsl.trials.batches import of_rows
from graspdsl.trials.end_conditions import BOUNDED, bounded, is_low, unmet
from graspdsl.trials.logbook import NEVER, Logbook
from graspdsl.trials.outcomes import Ending, Outcome
from graspdsl.trials.stages import Stage
from graspdsl.worlds.protocol import Command, Observation, Truth, WorldInfo

ROUNDING = 1e-9  # s
LEFT_NUMBERS = Ending(Outcome.CRASHED, "the simulation left the realm of numbers")


@dataclass(frozen=True, slots=True)
class Turns:
    """One tick of M trials: ``command`` of the controllers of their stages; ``endings`` of those that end, by their
    places among the M; ``made``: what each controller made of what it saw, and of which of the M, in turn."""

    command: Command
    endings: Mapping[int, Ending]
    made: Sequence[tuple[Rows, Ticks]]


class Course:
    """Trials of a program on their way, whoever carries out what they are commanded, each at a place of its own.

    There are N places, ``room``. ``trials``: the places of those that run, in the order of the rows in which they are
    seen. ``log`` holds the numbers of each until another begins at its place, ``wall_s`` (N,) the time [s] spent on it
    in a world: of a tick of several trials, equal shares.
    """

    def __init__(
        self, program: Program, stages: Sequence[Stage], info: WorldInfo, room: int, *, trajectories: bool = True
    ) -> None:
        """trajectories: whether to keep these, and what becomes of the priorities."""
        self._stages, self._info, self.room, self._certifies = stages, info, room, trajectories
        self.trials = np.zeros(0, dtype=np.intp)
        grasps, pipelines = [phase.grasp for phase in program.phases], [stage.pipeline for stage in stages]
        ticks = math.ceil(sum(phase.limit for phase in program.spec.program) * info.rate) + 1
        self.log = Logbook(grasps, pipelines, room, ticks, trajectories=trajectories)
        self._tick, self._at = np.zeros((2, room), dtype=np.intp)
        self.wall_s, self._deadline, self._held_from = np.zeros((3, room))
        self._touched = np.zeros(room, dtype=bool)
        self._handed_over: dict[tuple[int, str], Array] = {}
        self._began = np.zeros((room, len(info.joints)))
        self._monitors = program.monitors.watches(
            Setting(
                contacts=info.contacts,
                joints=info.joints,
                palm=program.robot.hand.palm,
                lower=info.lower,
                upper=info.upper,
                began=self._began,
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

    def begin(self, trials: Rows) -> None:
        """Trials begin at these places, where none runs; they are seen from the next tick on, behind the others."""
        self.trials = np.concatenate([self.trials, trials])
        self._tick[trials], self.wall_s[trials] = 0, 0.0
        self.log.begin(trials)

    def leave(self, trials: Rows) -> None:
        """These run no more, whatever has become of them."""
        self.trials = self.trials[~np.isin(self.trials, trials)]

    def _note_begun(self, seen: Observation, truth: Truth) -> None:
        """How things are with those of the trials that are seen for the first time."""
        new = self._tick[self.trials] == 0
        if new.any():
            trials, stage = self.trials[new], self._stages[0]
            self._began[trials], self.log.origins[trials] = seen.joints[new], truth.object_position[new]
            for monitor in self._monitors:
                monitor.begin_anew(trials)
            self._enter(trials, stage)
            self._deadline[trials] = seen.time[new] + stage.limit

    def tick(self, seen: Observation, truth: Truth) -> Turns:
        """The next tick of the trials that still run, and the first of those that have begun; those that end are left.

        A trial that begins another stage is looked at again, by the controller of that one, at the same tick.
        """
        self._note_begun(seen, truth)
        trials, endings, made = self.trials, dict[int, Ending](), list[tuple[Rows, Ticks]]()
        command = Command("", np.zeros(0))
        due = np.arange(len(trials))
        while len(due):
            at, due_next = self._at[trials[due]], []
            alike = bool((at == at[0]).all())
            for number in at[:1] if alike else np.unique(at):
                rows, stage = due if alike else due[at == number], self._stages[number]
                chosen, true = of_rows(seen, rows, len(trials)), of_rows(truth, rows, len(trials))
                ticks, ended, moved = self._look(stage, trials[rows], chosen, true)
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
        self._tick[trials] += 1
        self.trials = np.delete(trials, list(endings))
        return Turns(command, endings, made)

    def stage(self, trial: int) -> Stage:
        """The one that a trial is in."""
        return self._stages[int(self._at[trial])]

    def _look(
        self, stage: Stage, trials: Rows, seen: Observation, truth: Truth
    ) -> tuple[Ticks, dict[int, Ending], Flags]:
        """What a stage makes of a tick of M trials: its ticks, how some of them end, by their places among the M, and
        which go to another stage."""
        ticks = stage.pipeline.ticks(seen, certified=self._certifies)
        tick = self._tick[trials]
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
        for name, values, _ in bounded(stage.until, ticks) if any_done else ():
            noted = self._handed_over.setdefault((stage.number, name), np.full(self.room, np.nan))
            noted[trials[done]] = values[done]
        moved = after != stage.number
        if moved.any():
            self._move(trials[moved], stage.phase, after[moved], seen.time[moved])
        return ticks, endings, moved

    def _note_held(self, tick: Rows, trials: Rows, now: Array, met: Flags) -> None:
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
            for name, values, bound in bounded(until, ticks):
                before, now, told = self._handed_over[earlier, name][trials[place]], values[place], BOUNDED[name]
                if now >= bound:
                    was = f"was {told.said(before, bound)}, below {told.said(bound)}"
                    when = f"when {self._stages[earlier].name} ended, and is {told.said(now, bound)}"
                    cure = f"{stage.name} raised it; with hysteresis the phase goes back"
                    return Ending(Outcome.UNDONE, f"{told.name} {was}, {when}: {cure}")
        return Ending(ending.outcome, f"in {stage.name}: {ending.detail}") if stage.name else ending

    def _move(self, trials: Rows, phase: int, after: Rows, now: Array) -> None:
        """Trials begin other stages."""
        for number in np.unique(after):
            stage, chosen = self._stages[number], after == number
            self._enter(trials[chosen], stage)
            if stage.phase != phase:
                self._deadline[trials[chosen]] = now[chosen] + stage.limit
        for monitor in self._monitors:
            monitor.begin_anew(trials)

    def _enter(self, trials: Rows, stage: Stage) -> None:
        """Trials begin a stage, of whatever phase."""
        self._at[trials], self._held_from[trials] = stage.number, np.nan
        self._touched[trials] = stage.until.contact is None


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
