"""The summary of a run: every number that a report tells, worked out once.

Console, page and ``--json`` are three renderings of it. What could not be measured is None, NaN in a record.
"""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from operator import attrgetter
from typing import Annotated, Any, Literal, get_args, get_type_hints

import numpy as np
from pydantic import BaseModel

from graspdsl.compiler.alike import known_of
from graspdsl.report.balance import Holding, holding
from graspdsl.report.evidence import Evidence
from graspdsl.report.modes import modes, share_intervals
from graspdsl.report.outcomes import OutcomeCount, outcome_table
from graspdsl.report.priorities import Priorities, priorities
from graspdsl.report.quality import Quality, quality
from graspdsl.report.stages import StageSummary, stage_summaries
from graspdsl.report.start_selection import Starts, starts_of
from graspdsl.report.statistics import Interval, bandwidth, median, wilson
from graspdsl.spec.program import Until
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import SPEC, RunFolder

Ratio = Annotated[float | None, "1"]
Shares = Annotated[Interval, "1"]
Metres = Annotated[float | None, "m"]
SquareMetres = Annotated[float | None, "m²"]
Radians = Annotated[float | None, "rad"]
Newtons = Annotated[float | None, "N"]
Seconds = Annotated[float | None, "s"]
Count = Annotated[float | None, "ticks or probes, or samples"]


class At(str):
    """Where a number stands in JSON, if not under its own name: keys with dots between."""


@dataclass(frozen=True, slots=True)
class Medians:
    """Medians of a residual or of its square by the simulator's truth: ``start`` and ``end`` over all trials,
    ``end_in_contact`` over those whose contacts all touched at the end."""

    start: Annotated[float | None, "the residual's"]
    end: Annotated[float | None, "the residual's"]
    end_in_contact: Annotated[float | None, "the residual's"]


@dataclass(frozen=True, slots=True)
class Converged:
    """The share of finished trials that converged, None of none, its Wilson interval of 95 %, and what that means: the
    end conditions of the last phase."""

    share: Ratio
    interval: Shares
    means: Until


@dataclass(frozen=True, slots=True)
class ModeSummary:
    """A mode of the end orientations of trials that settled with all contacts touching: its peak and range, its share
    ``of`` so many with an interval, the medians over its trials, and these by number."""

    centre: Annotated[float, "rad"]
    share: Annotated[float, "1"]
    of: int
    interval: Shares
    force_residual: Ratio
    moment_residual: Metres
    force_squared: Ratio
    moment_squared: SquareMetres
    range: Annotated[Interval, "rad"]
    trials: tuple[int, ...]
    bandwidth: Annotated[float, "rad"]


@dataclass(frozen=True, slots=True)
class Stopped:
    """Trials that a monitor stopped while all contacts touched, by number: where they ended tells of what stopped them,
    and they are in no mode. Their share ``of`` all that ended in contact, None of none, with its Wilson interval."""

    share: Ratio
    of: int
    interval: Shares
    trials: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Summary:
    """Everything a report says of a run.

    Of ``finished`` trials so many ``different`` ones can differ from one another, the others repeat them; shares carry
    Wilson intervals of 95 %, which take all as independent; those of modes know that the modes were found in the same
    trials. By trial, in the order of the records: whether the hand felt all contacts at any time (``in_contact_start``)
    and whether all truly touched at the last tick (``_end``, None where that is not known), and orientations.
    ``lost``: trials, by number, whose trajectories cannot be read; they are in no mode and in no stage. Residuals are
    medians of ‖ρ_f‖ (1) and ‖ρ_m‖ [m], squared of ε = ρᵀρ; modes are of trials that settled with all contacts touching,
    those ``stopped`` before are apart. ``stages`` are those of a program that has 'a then b'; ``known`` is what holds
    of its controllers whatever they met, with why. Contact forces, samples and time are of converged trials, sensing
    errors percentiles over a trial's readings and then medians over trials. ``command`` runs the same trials again.
    """

    name: str
    run: str
    seed: int
    asked: Annotated[int, At("trials.asked")]
    finished: Annotated[int, At("trials.finished")]
    different: Annotated[int, At("trials.different")]
    outcomes: Mapping[str, int]
    converged: Converged
    outcome_table: tuple[OutcomeCount, ...]
    in_contact_start: Annotated[tuple[bool, ...], At("in_contact.start")]
    in_contact_end: Annotated[tuple[bool | None, ...], At("in_contact.end")]
    force: Annotated[Medians, At("residuals.force")]
    force_squared: Annotated[Medians, At("residuals.force.squared")]
    moment: Annotated[Medians, At("residuals.moment")]
    moment_squared: Annotated[Medians, At("residuals.moment.squared")]
    lost: tuple[int, ...]
    orientation_start: Annotated[tuple[Radians, ...], At("orientation.start")]
    orientation_end: Annotated[tuple[Radians, ...], At("orientation.end")]
    modes: tuple[ModeSummary, ...]
    stopped: Stopped
    ticks_to_converge: Annotated[Count, At("ticks_to_converge.median")]
    ticks_to_converge_p90: Annotated[Count, At("ticks_to_converge.p90")]
    contact_force: Annotated[Newtons, At("contact_force.median")]
    least_contact_force: Annotated[Newtons, At("contact_force.least")]
    largest_contact_force: Annotated[Newtons, At("contact_force.largest")]
    object_shift: Annotated[Metres, At("object_shift.median")]
    largest_object_shift: Annotated[Metres, At("object_shift.largest")]
    point_error_p50: Annotated[Metres, At("sensing.point_error_p50")]
    point_error_p95: Annotated[Metres, At("sensing.point_error_p95")]
    normal_error_p50: Annotated[Radians, At("sensing.normal_error_p50")]
    normal_error_p95: Annotated[Radians, At("sensing.normal_error_p95")]
    tare_s: Annotated[Seconds, At("sensing.tare_s")]
    samples: Annotated[Count, At("samples.median")]
    probes: Annotated[int, At("probes.total")]
    trial_s: Annotated[Seconds, At("trial_s.median")]
    priorities: Priorities
    stages: tuple[StageSummary, ...]
    known: tuple[str, ...]
    balance: Holding
    quality: Quality
    starts: Starts
    wall_s: Seconds
    world_s: Seconds
    records: tuple[TrialRecord, ...]
    versions: Mapping[str, str]
    command: str

    def as_data(self) -> dict[str, Any]:
        """Its fields, each where it stands in JSON."""
        whole: dict[str, Any] = {}
        for name, kind in get_type_hints(Summary, include_extras=True).items():
            *within, key = next((note for note in get_args(kind) if isinstance(note, At)), name).split(".")
            part = whole
            for step in within:
                part = part.setdefault(step, {})
            part[key] = plain(getattr(self, name))
        return whole

    def count(self, outcome: Outcome) -> int:
        """How many trials ended so."""
        return self.outcomes.get(outcome.value, 0)


def summarised(evidence: Evidence) -> Summary:
    """The summary of a run."""
    folder, records = evidence.folder, evidence.records
    manifest, spec = folder.manifest, evidence.program.spec
    in_contact = [record for record in records if evidence.touching(record)]
    good = [record for record in records if record.outcome is Outcome.CONVERGED]
    to_converge = [record.ticks_to_converge for record in records if record.ticks_to_converge is not None]
    forces = [force for record in good for force in record.contact_forces]
    return Summary(
        name=manifest.name,
        run=str(folder.path),
        seed=manifest.seed,
        asked=manifest.asked,
        finished=len(records),
        different=int(min(len(records), evidence.program.different_trials)),
        outcomes=dict(Counter(record.outcome.value for record in records).most_common()),
        converged=Converged(
            len(good) / len(records) if records else None, wilson(len(good), len(records)), spec.program[-1].until
        ),
        outcome_table=tuple(outcome_table(records)),
        in_contact_start=tuple(record.samples > 0 for record in records),
        in_contact_end=tuple(evidence.touching(record) for record in records),
        force=_medians(records, in_contact, "force"),
        force_squared=_medians(records, in_contact, "force", _square),
        moment=_medians(records, in_contact, "moment"),
        moment_squared=_medians(records, in_contact, "moment", _square),
        lost=tuple(sorted(evidence.lost)),
        orientation_start=tuple(_known(record.orientation_start) for record in records),
        orientation_end=tuple(_known(record.orientation_end) for record in records),
        modes=tuple(_modes([record for record in in_contact if record.outcome.settled])),
        stopped=_stopped(in_contact),
        ticks_to_converge=_percentile(to_converge, 50),
        ticks_to_converge_p90=_percentile(to_converge, 90),
        contact_force=median(forces),
        least_contact_force=min(_finite(forces), default=None),
        largest_contact_force=_largest(forces),
        object_shift=median(record.object_shift for record in records),
        largest_object_shift=_largest(record.object_shift for record in records),
        point_error_p50=median(record.point_error[0] for record in records),
        point_error_p95=median(record.point_error[1] for record in records),
        normal_error_p50=median(record.normal_error[0] for record in records),
        normal_error_p95=median(record.normal_error[1] for record in records),
        tare_s=median(record.tare_s for record in records),
        samples=median(float(record.samples) for record in good),
        probes=sum(record.ticks for record in records) if evidence.program.probes else 0,
        trial_s=median(record.world_s for record in good),
        priorities=priorities(evidence),
        stages=stage_summaries(evidence),
        known=tuple(map(str, known_of(evidence.program))),
        balance=holding(evidence.program, records),
        quality=quality(records),
        starts=starts_of(spec.trials, records),
        wall_s=manifest.wall_s,
        world_s=sum(record.world_s for record in records),
        records=records,
        versions=manifest.made_with,
        command=repeating(folder),
    )


def repeating(folder: RunFolder) -> str:
    """The command that runs the same trials again."""
    manifest = folder.manifest
    words = ["graspdsl", "run", str(folder.whole / SPEC)]
    words += [word for setting in manifest.settings for word in ("--set", setting)]
    words += ["--trials", str(manifest.asked // max(1, len(manifest.points))), "--seed", str(manifest.seed)]
    words += ["--allow-code"] if folder.allow_code else []
    return shlex.join(words)


def _medians(
    records: Sequence[TrialRecord],
    in_contact: Sequence[TrialRecord],
    kind: Literal["force", "moment"],
    of: Callable[[float], float] = float,
) -> Medians:
    start, end = attrgetter(f"{kind}_residual_start"), attrgetter(f"{kind}_residual_end")
    return Medians(
        median(of(start(record)) for record in records),
        median(of(end(record)) for record in records),
        median(of(end(record)) for record in in_contact),
    )


def _modes(records: Sequence[TrialRecord]) -> Iterable[ModeSummary]:
    measured = [record for record in records if math.isfinite(record.orientation_end)]
    ends = np.array([record.orientation_end for record in measured])
    found = modes(ends)
    for mode, interval in zip(found, share_intervals(ends, found), strict=True):
        members = [measured[i] for i in mode.members]
        yield ModeSummary(
            centre=mode.centre,
            share=len(members) / len(measured),
            of=len(measured),
            interval=interval,
            force_residual=median(record.force_residual_end for record in members),
            moment_residual=median(record.moment_residual_end for record in members),
            force_squared=median(_square(record.force_residual_end) for record in members),
            moment_squared=median(_square(record.moment_residual_end) for record in members),
            range=(mode.low, mode.high),
            trials=tuple(record.number for record in members),
            bandwidth=bandwidth(ends),
        )


def _stopped(in_contact: Sequence[TrialRecord]) -> Stopped:
    stopped, of = [record.number for record in in_contact if not record.outcome.settled], len(in_contact)
    return Stopped(len(stopped) / of if of else None, of, wilson(len(stopped), of), tuple(stopped))


def _square(value: float) -> float:
    return value * value


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _finite(values: Iterable[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


def _percentile(values: Sequence[float], percent: float) -> float | None:
    return float(np.percentile(values, percent)) if values else None


def _largest(values: Iterable[float]) -> float | None:
    return max(_finite(values), default=None)


def plain(value: Any) -> Any:
    """Plain data, for JSON: a dataclass by its fields or as its ``as_data`` says; None for what is not finite."""
    if hasattr(value, "as_data"):
        return plain(value.as_data())
    if is_dataclass(value):
        return {one.name: plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, Enum):
        return value.value
    return None if isinstance(value, float) and not math.isfinite(value) else value
