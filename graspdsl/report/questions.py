"""How a run is asked about the points that the chapter makes of its experiments (Sec. 4.5).

Bounds are numbers of the chapter, or follow from them or from geometry.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.experiment_runs import (
    HUNDREDTHS,
    TENTHS,
    ExperimentRun,
    Records,
    largest_tilt,
    measured,
    moment_of_tilt,
)
from graspdsl.report.judgements import Judgement, Verdict, every, judged_share, judged_value
from graspdsl.report.mean_courses import MeanCourses, mean_courses
from graspdsl.report.modes import Mode
from graspdsl.report.statistics import (
    FEWEST,
    RIGHT_ANGLE,
    Interval,
    mean_interval,
    median_interval,
    peak_interval,
    share_interval,
)
from graspdsl.report.wording import NOTHING, counted, percent, percents

TRIALS = {"experiment-1": 58, "experiment-2": 61, "experiment-3": 28, "experiment-4": 31}  # of the chapter
SEVERAL = 2  # at least, where the chapter averages over trials
HALF = 0.5
LOW_FORCE = 0.3  # ‖ρ_f‖ (1) that the chapter has good grasps stay below (Sec. 4.5.2)
STUCK_FORCE = 1.55  # and that it has those near which are stuck
STUCK = 0.8  # rad, beyond which it has them
SECOND_PEAK = 0.45  # rad
ITERATIONS = (750.0, 1250.0)
LEAST = math.ulp(0.0)  # that is more than nothing

STAYED = "no monitor stopping them"
READING = f"{TENTHS:g} is a step of the chapter's reading, which gives 0, 0.3, 0.8, 1 and π/2"
FINER = f"{HUNDREDTHS:g} is a step of the chapter's reading, which gives 0.45 and 1.55"
FEW_FAIL = "few trials fail in the chapter: fewer than half"


@dataclass(frozen=True, slots=True)
class Found:
    """What a run says of a point: the bound, where it comes from, what was measured, and how that is judged.

    ``why``: of a verdict that has a reason of its own.
    """

    bound: str
    derived: str
    measured: str
    judgement: Judgement
    why: str = ""


def largest_peak(run: ExperimentRun) -> Found:
    """Whether most trials end in a peak near π/2."""
    nearest = min(run.modes, key=lambda mode: RIGHT_ANGLE - mode.centre, default=None)
    held = len(nearest.members) if nearest else 0
    most = max((len(mode.members) for mode in run.modes if mode is not nearest), default=0)
    found = _peak(run, nearest, RIGHT_ANGLE, "π/2, more in it than in any other")
    return replace(found, judgement=every(found.judgement, judged_share(held, held + most, HALF)))


def peak_at_0(run: ExperimentRun) -> Found:
    """Whether the lowest peak is near 0."""
    return _peak(run, min(run.modes, key=lambda mode: mode.centre, default=None), 0.0, "0")


def _peak(run: ExperimentRun, mode: Mode | None, place: float, said: str) -> Found:
    centre, held = (mode.centre, len(mode.members)) if mode else (None, 0)
    interval = peak_interval(run.ends, mode.low, mode.high) if mode else None
    return Found(
        f"peak within {TENTHS:g} rad of {said}",
        READING,
        f"{_with_interval(centre, interval, 'rad', 2)}; {_share_of(held, len(run.begun))}",
        judged_value(centre, interval, held, place - TENTHS, place + TENTHS),
    )


def funnelled(run: ExperimentRun, always: bool) -> Found:
    """Whether those that begin elsewhere come near π/2, in contact: most, or if ``always`` as good as all."""
    least, derived = _always(run) if always else (HALF, FEW_FAIL)
    began = [record for record in run.begun if not record.orientation_start >= RIGHT_ANGLE - TENTHS]
    near = {record.number for record in run.near(RIGHT_ANGLE)}
    came = sum(record.number in near for record in began)
    return Found(
        f"at least {percent(least)} of them end in contact within {TENTHS:g} rad of π/2",
        derived,
        _share_of(came, len(began)),
        judged_share(came, len(began), least),
    )


def funnelled_to_0(run: ExperimentRun) -> Found:
    """Whether more come to 0 than leave from there, and several end there."""
    good = run.near(0.0)
    ended = {record.number for record in good}
    began = {record.number for record in run.begun if record.orientation_start <= TENTHS}
    come, gone = len(ended - began), len(began - ended)
    several = _several(run)
    return Found(
        f"at least {percent(HALF)} of them came, and at least {percent(several)} of all ended there",
        f"a controller that drives grasps nowhere has as many come as leave (McNemar's test); Fig. 4.10 averages over "
        f"several of {TRIALS[run.name]} trials, {SEVERAL} at the least",
        f"{_share_of(come, come + gone)} came; {_share_of(len(good), len(run.begun))} of all ended there",
        every(judged_share(come, come + gone, HALF), judged_share(len(good), len(run.begun), several)),
    )


def few_outside(run: ExperimentRun) -> Found:
    """Whether few end outside of the peak at π/2, but several."""
    far, several = run.far(RIGHT_ANGLE), _several(run)
    return Found(
        f"at least {percent(several)}, at most {percent(HALF)} of them",
        f"Fig. 4.7 averages over several of {TRIALS[run.name]} trials, {SEVERAL} at the least; few is fewer than half",
        _share_of(len(far), len(run.begun)),
        judged_share(len(far), len(run.begun), several, HALF),
    )


def second_peak(run: ExperimentRun) -> Found:
    """Whether these make a mode of their own near SECOND_PEAK."""
    places = measured(run.far(RIGHT_ANGLE), "orientation_end")
    judgement, why = _median_within(places, SECOND_PEAK - HUNDREDTHS, SECOND_PEAK + HUNDREDTHS), ""
    if judgement.verdict is Verdict.AGREES and all(mode.centre > RIGHT_ANGLE - TENTHS for mode in run.modes):
        judgement, why = Judgement(Verdict.UNTOLD, len(places)), "the test of modes finds no second one"
    return Found(
        f"median within {HUNDREDTHS:g} rad of {SECOND_PEAK:g} rad, in a second mode by the test of modes",
        FINER,
        f"{_median_of(places, 'rad', 2)}; {counted(len(run.modes), 'mode', 'modes')} of all",
        judgement,
        why,
    )


def on_top(run: ExperimentRun) -> Found:
    """Whether most of these end with a finger on the top."""
    on_top = [course.on_top for course in run.courses(run.far(RIGHT_ANGLE))]
    return Found(
        f"at least {percent(HALF)} of them, by a normal nearer to the axis than across",
        "said of the peak, so of most trials in it",
        _share_of(sum(on_top), len(on_top)),
        judged_share(sum(on_top), len(on_top), HALF),
    )


def force_outside(run: ExperimentRun) -> Found:
    """Whether the force residual of these does not fall."""
    change, _ = run.changes(run.far(RIGHT_ANGLE))
    return Found(
        f"its mean falls by at most {TENTHS:g}",
        READING,
        f"changes by {_mean_of(change, '', 2)}",
        _mean_within(change, -TENTHS, math.inf),
    )


def moment_outside(run: ExperimentRun) -> Found:
    """Whether the moment residual of these rises."""
    _, change = run.changes(run.far(RIGHT_ANGLE))
    return Found(
        "its mean rises",
        "where it neither rises nor falls it changes by 0",
        f"changes by {_mean_of(1e3 * change, 'mm', 1)}",
        _mean_within(1e3 * change, LEAST, math.inf),
    )


def all_low(run: ExperimentRun, always: bool) -> Found:
    """Whether both residuals are low at the end: of most, or if ``always`` of as good as all."""
    least, derived = _always(run) if always else (HALF, FEW_FAIL)
    most, why = _low_moment(run)
    force, moment = run.residuals(run.settled(run.begun))
    low = int(np.count_nonzero((force <= LOW_FORCE) & (1e3 * moment <= most)))
    return Found(
        f"at least {percent(least)} of them with ‖ρ_f‖ ≤ {LOW_FORCE:g} and ‖ρ_m‖ ≤ {most:.1f} mm",
        f"{derived}. {why}",
        _share_of(low, len(run.begun)),
        judged_share(low, len(run.begun), least),
    )


def low_force(run: ExperimentRun, place: float) -> Found:
    """Whether grasps near an orientation [rad] end with a low force residual on average."""
    force, _ = run.residuals(run.settled(run.near(place)))
    return Found(
        f"mean ‖ρ_f‖ ≤ {LOW_FORCE:g}",
        f"{LOW_FORCE:g} is the chapter's (Sec. 4.5.2)",
        f"‖ρ_f‖ = {_mean_of(force, '', 3)}",
        _mean_within(force, -math.inf, LOW_FORCE),
    )


def low_means(run: ExperimentRun) -> Found:
    """Whether both residuals are low on average."""
    force, moment = run.residuals(run.begun)
    most, why = _low_moment(run)
    return Found(
        f"means ‖ρ_f‖ ≤ {LOW_FORCE:g} and ‖ρ_m‖ ≤ {most:.1f} mm",
        why,
        f"‖ρ_f‖ = {_mean_of(force, '', 3)}, ‖ρ_m‖ = {_mean_of(1e3 * moment, 'mm', 1)}",
        every(_mean_within(force, -math.inf, LOW_FORCE), _mean_within(1e3 * moment, -math.inf, most)),
    )


def perpendicular(run: ExperimentRun) -> Found:
    """That good grasps are perpendicular to the axis, which follows from the bounds by which they are good."""
    until = run.evidence.program.spec.program[-1].until
    force, moment = until.force_residual, until.moment_residual
    if force is None or moment is None or force >= HALF:
        return _not_judged(NOTHING, "the spec does not bound both residuals so that it could follow")
    good = [r for r in run.begun if r.force_residual_end < force and r.moment_residual_end < moment]
    return _not_judged(
        f"{_median_of(measured(good, 'orientation_end'), 'rad', 3)}, of {counted(len(good), 'trial', 'trials')}",
        "it follows from the bounds. A contact on a flat end leaves ‖ρ_f‖ ≥ ½, so all are on the side; there normals "
        "are level, and with ‖ρ_f‖ = 0 a moment takes as large a difference in height between opposed contacts: "
        f"atan({1e3 * moment:g} mm / {1e3 * run.width:g} mm) = {math.atan(moment / run.width):.3f} rad. With ‖ρ_f‖ up "
        f"to {force:g} and a virtual contact of two it is {largest_tilt(force, moment, run.width):.3f} rad at most",
    )


def later(run: ExperimentRun) -> Found:
    """Whether the mean moment falls later than the mean force."""
    found = _means_near(run)
    return Found(
        "the mean moment falls a tick or more later than the mean force, on average over all that they fall by",
        "a tick is the least that there is between them",
        _falls(found),
        judged_value(found.lag, found.lag_interval, found.trials, 1.0, math.inf),
    )


def monotone(run: ExperimentRun) -> Found:
    """Whether the mean force residual never rises."""
    found = _means_near(run)
    return Found(
        f"its mean rises by at most {HUNDREDTHS:g}",
        FINER,
        f"largest rise {_with_interval(found.rise if found.trials else None, found.rise_interval, '', 3)}",
        judged_value(found.rise, found.rise_interval, found.trials, -math.inf, HUNDREDTHS),
    )


def _means_near(run: ExperimentRun) -> MeanCourses:
    found = mean_courses(run.courses(run.near(RIGHT_ANGLE)))
    return found or MeanCourses(0, (None, None), math.nan, None, math.nan, None)


def iterations(run: ExperimentRun) -> Found:
    """Whether residuals converge in about as many ticks as the chapter says."""
    ticks = (record.ticks_to_converge for record in run.begun)
    until = np.array([math.inf if count is None else float(count) for count in ticks])
    return Found(
        f"median {ITERATIONS[0]:g} to {ITERATIONS[1]:g}",
        "the chapter says 20 s, which is read to ten: 15 to 25 s",
        _median_of(until, "ticks", 0),
        _median_within(until, *ITERATIONS),
    )


def starts(run: ExperimentRun) -> Found:
    """Where trials begin, which the spec says."""
    return _not_judged(
        _median_of(measured(run.begun, "orientation_start"), "rad", 2),
        "the spec draws the tilt of the hand about 1 rad, as the chapter tells: it is put in",
    )


def _stuck(run: ExperimentRun) -> Records:
    stuck = [record for record in run.settled(run.begun) if STUCK <= record.orientation_end <= RIGHT_ANGLE]
    return [record for record in stuck if run.touching(record)]


def some_stuck(run: ExperimentRun) -> Found:
    """Whether several settle between STUCK and π/2."""
    stuck, several = _stuck(run), _several(run)
    return Found(
        f"at least {percent(several)} of them in contact there, {STAYED}",
        f"Fig. 4.11 averages over several of {TRIALS[run.name]} trials, {SEVERAL} at the least",
        _share_of(len(stuck), len(run.begun)),
        judged_share(len(stuck), len(run.begun), several),
    )


def stuck_force(run: ExperimentRun) -> Found:
    """Whether these end with a force residual near STUCK_FORCE."""
    force, _ = run.residuals(_stuck(run))
    return Found(
        f"mean ‖ρ_f‖ within {HUNDREDTHS:g} of {STUCK_FORCE:g}",
        FINER,
        f"‖ρ_f‖ = {_mean_of(force, '', 2)}",
        _mean_within(force, STUCK_FORCE - HUNDREDTHS, STUCK_FORCE + HUNDREDTHS),
    )


def stuck_moment(run: ExperimentRun) -> Found:
    """Whether the moment residual is low near 0 and in these alike."""
    (_, good), (_, stuck) = run.residuals(run.settled(run.near(0.0))), run.residuals(_stuck(run))
    most = 0.75e3 * moment_of_tilt(run.width)
    return Found(
        f"both means ‖ρ_m‖ ≤ {most:.1f} mm",
        f"three contacts evenly around the roll leave 3/2 R tan {TENTHS:g} = {most:.1f} mm where their plane is "
        f"{TENTHS:g} rad off, a step of the chapter's reading",
        f"{_mean_of(1e3 * good, 'mm', 1)} near 0, {_mean_of(1e3 * stuck, 'mm', 1)} above {STUCK:g} rad",
        every(*(_mean_within(1e3 * moment, -math.inf, most) for moment in (good, stuck))),
    )


def one_mode(run: ExperimentRun) -> Found:
    """Whether there is one mode, with as good as all trials in it."""
    least, derived = _always(run)
    held = len(run.modes[0].members) if run.modes else 0
    share = judged_share(held, len(run.begun), least)
    return Found(
        f"one by the test of modes, with at least {percent(least)} of them",
        derived,
        f"{counted(len(run.modes), 'mode', 'modes')}; {_share_of(held, len(run.begun))}",
        Judgement(Verdict.DIFFERS, len(run.begun)) if len(run.modes) > 1 else share,
    )


def _several(run: ExperimentRun) -> float:
    """The share of trials that is several of the chapter's."""
    return SEVERAL / TRIALS[run.name]


def _always(run: ExperimentRun) -> tuple[float, str]:
    """The least share that "always" may mean, and where it comes from."""
    count = TRIALS[run.name]
    least = share_interval(count, count)[0]
    return least, f"all of the chapter's {count} did, a share whose 95 % interval begins at {percent(least)}"


def _low_moment(run: ExperimentRun) -> tuple[float, str]:
    """What a low ‖ρ_m‖ may be at most [mm], and where the bounds of low residuals come from."""
    most = 1e3 * moment_of_tilt(run.width)
    return most, (
        f"{LOW_FORCE:g} is the chapter's (Sec. 4.5.2); opposed normals {1e3 * run.width:.0f} mm apart leave "
        f"{most:.1f} mm where the line between them is {TENTHS:g} rad off, a step of the chapter's reading"
    )


def _not_judged(measured: str, why: str) -> Found:
    return Found(NOTHING, NOTHING, measured, Judgement(Verdict.NO_EVIDENCE, 0), why)


# Judgements of means and medians, and how numbers are told with their intervals


def _mean_within(values: Array, low: float, high: float) -> Judgement:
    return judged_value(_mean(values), _interval_of_mean(values), len(values), low, high)


def _median_within(values: Array, low: float, high: float) -> Judgement:
    return judged_value(_median(values), median_interval(values), len(values), low, high)


def _mean(values: Array) -> float | None:
    return float(np.mean(values)) if len(values) else None


def _median(values: Array) -> float | None:
    """That of :mod:`graspdsl.report.statistics` leaves out trials that never converge, which count here as infinite."""
    return float(np.median(values)) if len(values) else None


def _interval_of_mean(values: Array) -> Interval | None:
    return mean_interval(values) if len(values) >= FEWEST else None


def _with_interval(value: float | None, interval: Interval | None, unit: str, digits: int) -> str:
    """A number and where its interval ends, if it has one."""
    if value is None or math.isnan(value):
        return NOTHING
    said = f"{_rounded(value, digits)} {unit}".rstrip()
    return said if interval is None else f"{said} ({_rounded(interval[0], digits)} to {_rounded(interval[1], digits)})"


def _rounded(value: float, digits: int) -> str:
    return f"{round(value, digits) + 0.0:.{digits}f}".replace("inf", "∞").replace("-", "−")  # zero has no sign


def _mean_of(values: Array, unit: str, digits: int) -> str:
    """The mean of values (n,) and its interval."""
    return _with_interval(_mean(values), _interval_of_mean(values), unit, digits)


def _median_of(values: Array, unit: str, digits: int) -> str:
    """The median of values (n,) and its interval."""
    return _with_interval(_median(values), median_interval(values), unit, digits)


def _share_of(part: int, whole: int) -> str:
    """A share in percent, its interval, and of how many trials."""
    return f"{percent(part / whole)} ({percents(share_interval(part, whole))}) of {whole}" if whole else NOTHING


def _falls(found: MeanCourses) -> str:
    """After how many ticks mean residuals fall, and how much later the moment's does."""
    if not found.trials:
        return NOTHING
    force, moment = (
        "does not fall" if ticks is None else f"falls after {counted(round(ticks), 'tick', 'ticks')}"
        for ticks in found.falls
    )
    said = f"the mean force {force}, the mean moment {moment}"
    return f"{said}, {_with_interval(found.lag, found.lag_interval, '', 0)} later" if math.isfinite(found.lag) else said
