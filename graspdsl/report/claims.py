"""The chapter's experiments as claims, each held against what a run of the experiment measured (Sec. 4.5).

A claim that something is low, large or later agrees where the 95 % interval of what was measured lies within its
bound; a claim that it is near a number, where what was measured lies that near. Both differ where the interval lies
outside. Else, or where too few trials ended for an interval, the claim cannot be told.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.evidence import Evidence
from graspdsl.report.experiment_setups import departure
from graspdsl.report.judgements import Judgement, Verdict, every, judged_near, judged_share, judged_value
from graspdsl.report.mean_courses import SETTLED, MeanCourses, mean_courses
from graspdsl.report.statistics import (
    FEWEST,
    RIGHT_ANGLE,
    Interval,
    Mode,
    median,
    median_interval,
    modes,
    peak_interval,
    share_interval,
)
from graspdsl.report.summary import Summary
from graspdsl.report.wording import NOTHING, counted, number, percent, percents
from graspdsl.trials.record import TrialRecord

# How exactly the chapter reads its figures: where it gives two decimals (0.45, 1.55) and else (0, 0.8, 1, π/2).
HUNDREDTHS, TENTHS = 0.05, 0.1
LOW_FORCE, LOW_MOMENT = 0.1, 0.005  # ‖ρ_f‖ (1) and ‖ρ_m‖ [m], what the specs of the experiments ask for
FROM_ABOVE_FORCE = 0.3  # ‖ρ_f‖ (1) that the chapter has good grasps from above stay below
SIGNIFICANT = 0.1  # a share of grasps that is surely larger is no rarity
NO_RARITY = 0.01  # a share that is surely larger is not of single grasps
SMALLER = 0.5  # of another share: a peak that is surely smaller is much smaller
ITERATIONS = (750.0, 1250.0)  # "approximately 1000 (20 seconds)", at 50 Hz: 20 s to ten seconds are 15 to 25
ONE_MODE = 0.8  # a share that is surely larger, as 27 of 28 show, is of one mode though one grasp strays
MONOTONE = 0.05  # of where a mean residual starts: what a figure of it resolves
ENDED = "that ended in contact"


@dataclass(frozen=True, slots=True)
class Claim:
    """One point of the chapter: what it says, the bound it is judged by, what was measured, and the verdict.

    needed: about how many trials would tell, where it cannot be told from those there are; None also where no number
    would. ``why`` it does not agree.
    """

    experiment: str
    says: str
    bound: str
    measured: str
    verdict: Verdict
    needed: int | None = None
    why: str = ""


def claims_of(evidence: Evidence, summary: Summary) -> list[Claim]:
    """The claims of the experiment that a run is of; none for a run of something else, whatever its name."""
    made = EXPERIMENTS.get(evidence.program.spec.name)
    return [] if made is None or departure(evidence.program) else list(made(_Run(evidence, summary)))


class _Run:
    """A run of an experiment with what the claims ask of it. ``ended``: its trials that ended in contact."""

    def __init__(self, evidence: Evidence, summary: Summary) -> None:
        self.evidence, self.name = evidence, evidence.program.spec.name
        touching = zip(evidence.records, summary.in_contact_end, strict=True)
        self.ended = [record for record, touched in touching if touched and math.isfinite(record.orientation_end)]
        self.ends = np.array([record.orientation_end for record in self.ended])
        self.modes = modes(self.ends)

    def claim(self, says: str, bound: str, measured: str, judgement: Judgement, why: str = "") -> Claim:
        reason = why if judgement.verdict is Verdict.DIFFERS else ""
        if judgement.verdict is Verdict.UNTOLD:
            reason = _why_untold(judgement, len(self.evidence.records))
        return Claim(self.name, says, bound, measured, judgement.verdict, judgement.needed, reason)

    def of_mode(self, mode: Mode | None, field: str) -> Array:
        """A number of a mode's trials, where it was measured; of no mode, none."""
        return _measured([self.ended[place] for place in mode.members] if mode else [], field)

    def largest_near(self, says: str, angles: Array, place: float, said: str, of: str = ENDED) -> Claim:
        """Whether the largest mode of angles (n,) has its peak near an angle [rad]: that the nearest one is there, and
        has no fewer trials than any other."""
        found = modes(angles)
        nearest = min(found, key=lambda mode: abs(mode.centre - place), default=None)
        held = len(nearest.members) if nearest else 0
        other = max((len(mode.members) for mode in found if mode is not nearest), default=0)
        largest = judged_share(held, held + other, 0.5)
        return self.peak_near(says, angles, nearest, place, said, largest, also=", no fewer than in any other", of=of)

    def peak_near(
        self,
        says: str,
        angles: Array,
        mode: Mode | None,
        place: float,
        said: str,
        *others: Judgement,
        also: str = "",
        of: str = ENDED,
    ) -> Claim:
        """Whether a mode of angles (n,) has its peak near an angle [rad], and what else is judged of it, said in
        ``also``."""
        bound = f"within {TENTHS:g} rad of {said}{also}"
        if mode is None:
            return self.claim(says, bound, NOTHING, judged_value(None, None, 0, 0.0, 0.0))
        interval = peak_interval(angles, mode.low, mode.high)
        near = judged_near(mode.centre, interval, len(mode.members), place - TENTHS, place + TENTHS)
        measured = f"{_with_interval(mode.centre, interval, 'rad', 2)}; {_share_of(len(mode.members), len(angles), of)}"
        return self.claim(says, bound, measured, every(near, *others))

    def low_residuals(self, says: str, mode: Mode | None) -> Claim:
        """Whether the medians of both residuals over a mode's trials are low."""
        force, moment = self.of_mode(mode, "force_residual_end"), 1e3 * self.of_mode(mode, "moment_residual_end")
        return self.claim(
            says,
            f"medians ‖ρ_f‖ ≤ {LOW_FORCE:g}, ‖ρ_m‖ ≤ {1e3 * LOW_MOMENT:g} mm",
            f"‖ρ_f‖ = {_median_of(force, '', 3)}, ‖ρ_m‖ = {_median_of(moment, 'mm', 1)}",
            every(_median_within(force, 0.0, LOW_FORCE), _median_within(moment, 0.0, 1e3 * LOW_MOMENT)),
        )


def _two_contacts(run: _Run) -> Iterable[Claim]:
    yield run.largest_near("The largest peak of orientations at the end is near π/2.", run.ends, RIGHT_ANGLE, "π/2")
    main, others = next(iter(run.modes), None), run.modes[1:]
    most = len(main.members) if main else 0
    aside = [run.ended[n] for mode in others if mode.centre < RIGHT_ANGLE - TENTHS for n in mode.members]
    yield run.claim(
        "There is a much smaller second peak, of grasps with a finger on the top.",
        f"at least {percent(NO_RARITY)} of grasps, at most {SMALLER:g} times those of the largest",
        _share_of(len(aside), len(run.ended)),
        every(
            judged_share(len(aside), len(run.ended), NO_RARITY),
            judged_share(len(aside), len(aside) + most, 0.0, SMALLER / (1 + SMALLER)),
        ),
        "grasps seldom end away from π/2, or too often",
    )
    places = _measured(aside, "orientation_end")
    yield run.claim(
        "The second peak lies near 0.45 rad.",
        f"median of the grasps outside the largest peak within {HUNDREDTHS:g} rad of 0.45 rad",
        _median_of(places, "rad", 2),
        _median_near(places, 0.45 - HUNDREDTHS, 0.45 + HUNDREDTHS),
        "where such a trial ends depends on which link touches first, and on when the monitors end it",
    )
    yield run.low_residuals("Grasps in the main peak end with low force and moment residuals.", main)
    yield from _courses(run, main)
    ticks = _measured(run.evidence.records, "ticks_to_converge")
    yield run.claim(
        "Residuals converge in about 1000 iterations at 50 Hz.",
        f"median {ITERATIONS[0]:g} to {ITERATIONS[1]:g}, as 20 s is to ten seconds",
        _median_of(ticks, "ticks", 0),
        _median_near(ticks, *ITERATIONS),
        "iterations go as one over the gain, which the chapter does not state; ours is half a millimetre a tick for a "
        "unit net force",
    )


def _courses(run: _Run, mode: Mode | None) -> Iterable[Claim]:
    numbers = [run.ended[place].number for place in mode.members] if mode else []
    courses = run.evidence.courses
    found = mean_courses([courses[n] for n in numbers if n in courses])
    found = found or MeanCourses(0, (None, None), math.nan, None, math.nan, None)
    yield run.claim(
        "The force residual falls first, the moment residual after it.",
        f"the mean moment is {percent(SETTLED)} down one tick or more after the mean force",
        _settling(found),
        judged_value(found.lag, found.lag_interval, found.trials, 1.0, math.inf),
        "in the null space of the force residual alone the moment falls at the same time",
    )
    yield run.claim(
        "On average the force residual falls monotonically.",
        f"its mean rises by at most {percent(MONOTONE)} of where it starts",
        _rising(found),
        judged_value(found.rise, found.rise_interval, found.trials, -math.inf, MONOTONE),
        "single trials rise while a contact is made anew",
    )


def _three_contacts(run: _Run) -> Iterable[Claim]:
    starts = _measured(run.evidence.records, "orientation_start")
    yield run.largest_near(
        "Orientations at the start have a strong peak near 1 rad.", starts, 1.0, "1 rad", "that began"
    )
    good = next((mode for mode in run.modes if mode.centre <= TENTHS), None)
    peak = good or next(iter(run.modes), None)
    share = judged_share(len(peak.members) if peak else 0, len(run.ended), SIGNIFICANT)
    says = "Orientations at the end have a peak near 0."
    yield run.peak_near(says, run.ends, peak, 0.0, "0", share, also=f", at least {percent(SIGNIFICANT)} of grasps")
    force = run.of_mode(good, "force_residual_end")
    yield run.claim(
        "Grasps near 0 end with ‖ρ_f‖ < 0.3.",
        f"median ‖ρ_f‖ ≤ {FROM_ABOVE_FORCE:g}",
        f"‖ρ_f‖ = {_median_of(force, '', 3)}",
        _median_within(force, 0.0, FROM_ABOVE_FORCE),
    )
    stuck = [record for record in run.ended if 0.8 <= record.orientation_end <= RIGHT_ANGLE]
    yield run.claim(
        "A significant number end between 0.8 and π/2.",
        f"at least {percent(SIGNIFICANT)} of grasps",
        _share_of(len(stuck), len(run.ended)),
        judged_share(len(stuck), len(run.ended), SIGNIFICANT),
        "the monitors end trials in which a contact is lost or another link touches before they settle there",
    )
    force = _measured(stuck, "force_residual_end")
    yield run.claim(
        "Those end with ‖ρ_f‖ near 1.55.",
        f"median ‖ρ_f‖ within {HUNDREDTHS:g} of 1.55",
        f"‖ρ_f‖ = {_median_of(force, '', 2)}",
        _median_near(force, 1.55 - HUNDREDTHS, 1.55 + HUNDREDTHS),
        "a finger on the top against two on opposite sides leaves 1; what is left depends on where the two have slid",
    )
    moments = 1e3 * run.of_mode(good, "moment_residual_end"), 1e3 * _measured(stuck, "moment_residual_end")
    yield run.claim(
        "The moment residual is similarly low in both.",
        f"both medians ‖ρ_m‖ ≤ {1e3 * LOW_MOMENT:g} mm",
        f"{_median_of(moments[0], 'mm', 1)} near 0, {_median_of(moments[1], 'mm', 1)} above 0.8 rad",
        every(*(_median_within(moment, 0.0, 1e3 * LOW_MOMENT) for moment in moments)),
        "trials that the monitors end early have not settled",
    )


def _bottle(run: _Run) -> Iterable[Claim]:
    main = next(iter(run.modes), None)
    held = len(main.members) if main else 0
    yield run.claim(
        "There is one mode.",
        f"at least {percent(ONE_MODE)} of grasps in it",
        f"{_share_of(held, len(run.ended))}; {counted(len(run.modes), 'mode', 'modes')}" if main else NOTHING,
        judged_share(held, len(run.ended), ONE_MODE),
        "some grasps were stuck before",
    )
    yield run.largest_near("The grasp is perpendicular to the major axis.", run.ends, RIGHT_ANGLE, "π/2")
    yield run.low_residuals("Grasps end with low force and moment residuals.", main)


EXPERIMENTS: Mapping[str, Callable[[_Run], Iterable[Claim]]] = {
    "experiment-1": _two_contacts,
    "experiment-2": _three_contacts,
    "experiment-3": _bottle,
    "experiment-4": _bottle,
}


def _measured(records: Iterable[TrialRecord], field: str) -> Array:
    """A number of records, where it was measured."""
    values = [getattr(record, field) for record in records]
    return np.array([value for value in values if value is not None and math.isfinite(value)], dtype=float)


def _median_within(values: Array, low: float, high: float) -> Judgement:
    return judged_value(median(values), median_interval(values), len(values), low, high)


def _median_near(values: Array, low: float, high: float) -> Judgement:
    return judged_near(median(values), median_interval(values), len(values), low, high)


def _with_interval(value: float | None, interval: Interval | None, unit: str, digits: int) -> str:
    """A number and where its interval ends, if it has one."""
    if value is None or interval is None:
        return number(value, unit, digits)
    low, high = (_rounded(end, digits) for end in interval)
    return f"{_rounded(value, digits)} {unit}".rstrip() + f" ({low} to {high})"


def _rounded(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("inf", "∞").replace("-", "−")  # zero has no sign


def _median_of(values: Array, unit: str, digits: int) -> str:
    """The median of values (n,) and its interval."""
    return _with_interval(float(np.median(values)) if len(values) else None, median_interval(values), unit, digits)


def _share_of(part: int, whole: int, of: str = ENDED) -> str:
    """A share in percent, its interval, and of how many grasps."""
    if not whole:
        return NOTHING
    return f"{percent(part / whole)} ({percents(share_interval(part, whole))}) of {whole} {of}"


def _settling(found: MeanCourses) -> str:
    """When the mean residuals have fallen, and how much later the moment's."""
    if not found.trials:
        return NOTHING
    force, moment = ("never" if tick is None else f"after {counted(tick, 'tick', 'ticks')}" for tick in found.settled)
    said = f"{percent(SETTLED)} down: the mean force {force}, the mean moment {moment}"
    if not math.isfinite(found.lag):
        return said
    return f"{said}, {_with_interval(found.lag, found.lag_interval, '', 0)} later"


def _rising(found: MeanCourses) -> str:
    """How far the mean force residual rises."""
    if not found.trials:
        return NOTHING
    ends = None if found.rise_interval is None else (100 * found.rise_interval[0], 100 * found.rise_interval[1])
    return f"largest rise {_with_interval(100 * found.rise, ends, '%', 0)}"


def _why_untold(judgement: Judgement, whole: int) -> str:
    """How many trials a verdict would be of and how many it takes, and in a run of how many; of ``whole`` so far."""
    there = f"{counted(judgement.trials, 'such trial', 'such trials')} cannot tell"
    if judgement.needed is None:
        return f"{there}, nor would more like them"
    about = "at least" if judgement.trials < FEWEST else "about"
    if judgement.trials in (0, whole):
        return f"{there}: {about} {judgement.needed} can"
    run = math.ceil(judgement.needed * whole / judgement.trials)
    return f"{there}: {about} {judgement.needed} can, in a run of {run}"
