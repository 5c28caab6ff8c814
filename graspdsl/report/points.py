"""What the chapter says of its experiments (Sec. 4.5), point by point, and how a run could fail each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

from graspdsl.report import questions
from graspdsl.report.experiment_runs import FIXED_TIME, TENTHS, ExperimentRun
from graspdsl.report.questions import LOW_FORCE, SECOND_PEAK, STAYED, STUCK, STUCK_FORCE, Found
from graspdsl.report.statistics import RIGHT_ANGLE

ALL = "all feasible starts"
ENDS = f"{ALL}, whatever ended them"
NEAR = "feasible starts that ended in contact near π/2"
OUTSIDE = "feasible starts that ended outside of the peak at π/2"
FIXED = f"after {FIXED_TIME:g} s of control"


@dataclass(frozen=True, slots=True)
class Point:
    """What the chapter ``says``, in ``source``; over which trials a run is asked and what it finds (``held``).

    ``could_fail``: what a run would show otherwise; nothing where none could. ``why`` it may differ. ``fixed``: whether
    it is about residuals after a fixed time, so that trials that end as soon as they are low are no evidence.
    """

    says: str
    source: str
    over: str
    could_fail: str
    why: str
    held: Callable[[ExperimentRun], Found]
    fixed: bool = False


def _largest_peak(source: str) -> Point:
    return Point(
        "The largest peak of orientations at the end is near π/2.",
        source,
        ENDS,
        "starts are spread over most of the right angle: contacts that do not slide leave the peak where starts are "
        "densest",
        "grasps end elsewhere",
        questions.largest_peak,
    )


def _funnel(source: str, *, always: bool) -> Point:
    return Point(
        "The controller funnels a range of starts to π/2.",
        source,
        f"feasible starts more than {TENTHS:g} rad from π/2",
        "a controller that does not turn the grasp brings none there; one that is stopped or lets go, few",
        "some are stopped or caught on the way",
        partial(questions.funnelled, always=always),
    )


def _two_contacts() -> tuple[Point, ...]:
    return (
        _largest_peak("Sec. 4.5.1, Fig. 4.4(b)"),
        _funnel("Sec. 4.5.1", always=False),
        Point(
            "Few trials end outside of that peak, but some do.",
            "Sec. 4.5.1, Fig. 4.4(b), 4.7",
            ALL,
            "a hand that reaches around the roll from everywhere leaves none outside, one whose palm is always in the "
            "way leaves most",
            "the hand reaches around the roll from everywhere, or seldom",
            questions.few_outside,
        ),
        Point(
            f"They make a second peak near {SECOND_PEAK:g} rad.",
            "Sec. 4.5.1, Fig. 4.4(b)",
            OUTSIDE,
            "where a grasp is left depends on where palm and links stop the hand, which no bound of the spec says",
            "where such a trial ends depends on which link touches first, and on when the monitors end it",
            questions.second_peak,
        ),
        Point(
            "There one finger is on the top of the object.",
            "Sec. 4.5.1, Fig. 4.5(b)",
            OUTSIDE,
            "trials that are stopped while all fingers are on the side, or keep a slanting grasp there, have none",
            "most are stopped, or stay, with all fingers on the side",
            questions.on_top,
        ),
        Point(
            "There the force residual never significantly decreases.",
            "Sec. 4.5.1, Fig. 4.7(a)",
            f"{OUTSIDE}, over {FIXED_TIME:g} s of control, or until a trial was stopped",
            "the controller lowers the force as far as the hand lets it, which may be far",
            "the force falls until the hand is stopped",
            questions.force_outside,
            fixed=True,
        ),
        Point(
            "There the moment residual increases.",
            "Sec. 4.5.1, Fig. 4.7(b)",
            f"{OUTSIDE}, over {FIXED_TIME:g} s of control, or until a trial was stopped",
            "with a controller that lowers the moment, as this one does where it may, it falls",
            "the moment falls until the hand is stopped",
            questions.moment_outside,
            fixed=True,
        ),
        Point(
            "From a variety of starts the controller converges to low force and moment residuals.",
            "Sec. 4.5, 4.5.1",
            f"{ALL}, {FIXED}; those that a monitor stopped are not low",
            "no trial ends at these bounds: residuals stay where the hand closed unless the controller lowers them, "
            "and rise again where it wanders off",
            "some are stopped or caught",
            partial(questions.all_low, always=False),
            fixed=True,
        ),
        Point(
            "Grasps in the peak at π/2 converge to a low force residual.",
            "Sec. 4.5.1, Fig. 4.6(a)",
            f"{NEAR}, {STAYED}, {FIXED}",
            "a line across the axis may be any chord: with an orientation of π/2 goes any ‖ρ_f‖ from 0 to 2",
            "contacts do not oppose each other",
            partial(questions.low_force, place=RIGHT_ANGLE),
            fixed=True,
        ),
        Point(
            "Good grasps are perpendicular to the major axis.",
            "Sec. 4.5.1, Fig. 4.5(a)",
            "feasible starts that end with residuals as low as the spec asks for",
            "",
            "",
            questions.perpendicular,
        ),
        Point(
            "The force residual falls first, the moment residual after it.",
            "Sec. 4.5.1, Fig. 4.6",
            f"{NEAR}, over {FIXED_TIME:g} s of control",
            "priority binds directions, not speeds: the moment may fall as fast in what is left to it, or faster with "
            "a larger gain",
            "in the null space of the force residual alone the moment falls at the same time",
            questions.later,
        ),
        Point(
            "On average the force residual falls monotonically.",
            "Sec. 4.5.1, Fig. 4.6(a)",
            f"{NEAR}, over {FIXED_TIME:g} s of control",
            "trials rise while a contact is made anew, and a controller of the moment alone raises the force",
            "trials rise while a contact is made anew",
            questions.monotone,
        ),
        Point(
            "Residuals converge in about 1000 iterations at 50 Hz.",
            "Sec. 4.5.1, Fig. 4.6",
            f"{ALL}, those that never converge last",
            "iterations go as one over the gain, and nothing in the spec says how many",
            "the chapter does not state its gain; ours moves a contact half a millimetre a tick for a unit net force",
            questions.iterations,
        ),
    )


def _three_contacts() -> tuple[Point, ...]:
    return (
        Point(
            "Orientations at the start have a strong peak near 1 rad.",
            "Sec. 4.5.2, Fig. 4.8(a)",
            ALL,
            "",
            "",
            questions.starts,
        ),
        Point(
            "Orientations at the end have a peak near 0.",
            "Sec. 4.5.2, Fig. 4.8(b)",
            ENDS,
            "starts lie about 1 rad, and contacts that do not slide stay there",
            "grasps end, or are stopped, elsewhere",
            questions.peak_at_0,
        ),
        Point(
            "The controller funnels grasps from the peak near 1 rad to the peak near 0.",
            "Sec. 4.5.2, Fig. 4.8",
            f"feasible starts that came within {TENTHS:g} rad of 0, in contact, or left from there",
            "contacts can as well stay where they closed, slide off the top or be caught on the rim",
            "hardly any come there, or as many leave",
            questions.funnelled_to_0,
        ),
        Point(
            f"Grasps that end near 0 converge to ‖ρ_f‖ < {LOW_FORCE:g}.",
            "Sec. 4.5.2, Fig. 4.10(a)",
            f"feasible starts that ended in contact near 0, {STAYED}, {FIXED}",
            "a level plane of contacts does not say how they lie around the roll: with it goes any ‖ρ_f‖ from 0 to 3",
            "contacts do not oppose each other",
            partial(questions.low_force, place=0.0),
            fixed=True,
        ),
        Point(
            f"On a significant number of trials it converges to orientations between {STUCK:g} and π/2.",
            "Sec. 4.5.2, Fig. 4.8(b), 4.11",
            ALL,
            "grasps from there may all come to 0, or be stopped before they settle",
            "the monitors end trials in which a contact is lost or another link touches before they settle there",
            questions.some_stuck,
        ),
        Point(
            f"Those end with ‖ρ_f‖ near {STUCK_FORCE:g}.",
            "Sec. 4.5.2, Fig. 4.11(a)",
            f"feasible starts that ended in contact between {STUCK:g} and π/2, {STAYED}, {FIXED}",
            "a finger on the top against two on opposite sides leaves 1, against two side by side √5",
            "what a finger on the top leaves depends on where the other two have slid",
            questions.stuck_force,
            fixed=True,
        ),
        Point(
            "The moment residual is similarly low in both.",
            "Sec. 4.5.2, Fig. 4.10(b), 4.11(b)",
            f"feasible starts that ended in contact near 0, or between {STUCK:g} and π/2, {STAYED}, {FIXED}",
            f"nothing bounds the moment of trials that go on for the whole time, above {STUCK:g} rad not even where "
            "they are",
            "contacts have not settled by then",
            questions.stuck_moment,
            fixed=True,
        ),
    )


def _bottle(ends: str, means: str) -> tuple[Point, ...]:
    return (
        Point(
            "There is one mode.",
            f"Sec. 4.5.3, Fig. {ends}",
            ENDS,
            "grasps caught in another place make a second mode, or leave fewer in the first, as on the roll",
            "some grasps end in another place",
            questions.one_mode,
        ),
        _largest_peak(f"Sec. 4.5.3, Fig. {ends}"),
        _funnel(f"Sec. 4.5.3, Fig. {ends}", always=True),
        Point(
            "The controller never gets caught before residuals are low.",
            "Sec. 4.5.3",
            f"{ALL}, {FIXED}; those that a monitor stopped are not low",
            "no trial ends at these bounds: residuals stay where the hand closed unless the controller lowers them, "
            "and a palm or link in the way stops a trial",
            "some are stopped or caught",
            partial(questions.all_low, always=True),
            fixed=True,
        ),
        Point(
            "Averaged over all trials force and moment residuals are low.",
            f"Sec. 4.5.3, Fig. {means}",
            f"{ALL}, {FIXED}, or where a trial was stopped",
            "trials go on for the whole time and failed ones count: one in five with ‖ρ_f‖ = 1.5 is enough",
            "trials that were stopped or caught count, too",
            questions.low_means,
            fixed=True,
        ),
    )


EXPERIMENTS: Mapping[str, tuple[Point, ...]] = {
    "experiment-1": _two_contacts(),
    "experiment-2": _three_contacts(),
    "experiment-3": _bottle("4.12(b)", "4.14"),
    "experiment-4": _bottle("4.13(b)", "4.15"),
}
