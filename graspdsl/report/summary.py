"""The summary of a run: every number that a report tells, worked out once.

Console, page and ``--json`` are three renderings of it. What could not be measured is None, NaN in a record.
"""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from operator import attrgetter
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel

from graspdsl.report.evidence import Evidence
from graspdsl.report.outcomes import OutcomeCount, outcome_table
from graspdsl.report.quality import Quality, quality
from graspdsl.report.start_selection import Starts, starts_of
from graspdsl.report.statistics import Interval, bandwidth, median, modes, wilson
from graspdsl.spec.program import Until
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import SPEC, RunFolder

Ratio = Annotated[float | None, "1"]
Metres = Annotated[float | None, "m"]
SquareMetres = Annotated[float | None, "m²"]
Radians = Annotated[float | None, "rad"]
Newtons = Annotated[float | None, "N"]
Seconds = Annotated[float | None, "s"]
Count = Annotated[float | None, "ticks or probes, or samples"]


@dataclass(frozen=True, slots=True)
class TrialCounts:
    """How many trials were asked for and finished, and how many of these can differ: the others repeat them."""

    asked: int
    finished: int
    different: int


@dataclass(frozen=True, slots=True)
class Converged:
    """The share of finished trials that converged, with its Wilson interval of 95 %, and what that means."""

    share: Ratio
    interval: Interval
    means: Until


@dataclass(frozen=True, slots=True)
class InContact:
    """By trial: whether the hand felt all contacts at any time, and whether all truly touched at the last tick, None
    where the trajectory is lost."""

    start: tuple[bool, ...]
    end: tuple[bool | None, ...]


@dataclass(frozen=True, slots=True)
class Squared:
    """Medians of ε = ρᵀρ [1 or m²]."""

    start: Annotated[float | None, "1 or m²"]
    end: Annotated[float | None, "1 or m²"]
    end_in_contact: Annotated[float | None, "1 or m²"]


@dataclass(frozen=True, slots=True)
class Residual:
    """Medians of ‖ρ_f‖ (1) or ‖ρ_m‖ [m] by the simulator's truth: ``start`` and ``end`` over all trials,
    ``end_in_contact`` over those whose contacts all touched at the end."""

    start: Annotated[float | None, "1 or m"]
    end: Annotated[float | None, "1 or m"]
    end_in_contact: Annotated[float | None, "1 or m"]
    squared: Squared


@dataclass(frozen=True, slots=True)
class Residuals:
    """Those of force (1) and moment [m]."""

    force: Residual
    moment: Residual


@dataclass(frozen=True, slots=True)
class Orientations:
    """Orientations of the grasp [rad] by trial."""

    start: tuple[Radians, ...]
    end: tuple[Radians, ...]


@dataclass(frozen=True, slots=True)
class ModeSummary:
    """A mode of the end orientations of trials whose contacts all touched: its peak and range, its share ``of`` so
    many trials with an interval, the medians over its trials, and these by number."""

    centre: Annotated[float, "rad"]
    share: Annotated[float, "1"]
    of: int
    interval: Interval
    force_residual: Ratio
    moment_residual: Metres
    force_squared: Ratio
    moment_squared: SquareMetres
    range: Annotated[Interval, "rad"]
    trials: tuple[int, ...]
    bandwidth: Annotated[float, "rad"]


@dataclass(frozen=True, slots=True)
class Ticks:
    """Ticks or probes to converge."""

    median: Count
    p90: Count


@dataclass(frozen=True, slots=True)
class ContactForce:
    """Over the contacts of converged trials."""

    median: Newtons
    least: Newtons
    largest: Newtons


@dataclass(frozen=True, slots=True)
class ObjectShift:
    """How far the object was moved."""

    median: Metres
    largest: Metres


@dataclass(frozen=True, slots=True)
class Sensing:
    """Errors of sensed contact points and normals, percentiles over a trial's readings; ``tare_s``: the time to tare
    sensors. Medians over trials."""

    point_error_p50: Metres
    point_error_p95: Metres
    normal_error_p50: Radians
    normal_error_p95: Radians
    tare_s: Seconds


@dataclass(frozen=True, slots=True)
class MedianSamples:
    """Tactile samples of a converged trial."""

    median: Count


@dataclass(frozen=True, slots=True)
class MedianTime:
    """Simulated time of a converged trial."""

    median: Seconds


@dataclass(frozen=True, slots=True)
class Probes:
    """Probes of all trials together; 0 where contacts slide."""

    total: int


@dataclass(frozen=True, slots=True)
class Priorities:
    """How far lower priorities leaked into higher ones, and how many levels lie above another."""

    largest_leak: Ratio
    leaking_ticks: int = field(metadata={"key": "ticks_above_1e-6"})
    levels: int


@dataclass(frozen=True, slots=True)
class Summary:
    """Everything a report says of a run. ``command`` runs the same trials again."""

    name: str
    run: str
    seed: int
    trials: TrialCounts
    outcomes: Mapping[str, int]
    converged: Converged
    outcome_table: tuple[OutcomeCount, ...]
    in_contact: InContact
    residuals: Residuals
    orientation: Orientations
    modes: tuple[ModeSummary, ...]
    ticks_to_converge: Ticks
    contact_force: ContactForce
    object_shift: ObjectShift
    sensing: Sensing
    samples: MedianSamples
    probes: Probes
    trial_s: MedianTime
    priorities: Priorities
    quality: Quality
    starts: Starts
    wall_s: Seconds
    world_s: Seconds
    records: tuple[TrialRecord, ...]
    versions: Mapping[str, str]
    command: str

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
        trials=TrialCounts(manifest.asked, len(records), int(min(len(records), spec.different_trials))),
        outcomes=dict(Counter(record.outcome.value for record in records).most_common()),
        converged=Converged(
            len(good) / len(records) if records else None, wilson(len(good), len(records)), spec.program[-1].until
        ),
        outcome_table=tuple(outcome_table(records)),
        in_contact=InContact(
            tuple(record.samples > 0 for record in records), tuple(evidence.touching(record) for record in records)
        ),
        residuals=Residuals(_residual(records, in_contact, "force"), _residual(records, in_contact, "moment")),
        orientation=Orientations(
            tuple(_known(record.orientation_start) for record in records),
            tuple(_known(record.orientation_end) for record in records),
        ),
        modes=tuple(_modes(in_contact)),
        ticks_to_converge=Ticks(_percentile(to_converge, 50), _percentile(to_converge, 90)),
        contact_force=ContactForce(median(forces), min(_finite(forces), default=None), _largest(forces)),
        object_shift=ObjectShift(
            median(record.object_shift for record in records), _largest(record.object_shift for record in records)
        ),
        sensing=Sensing(
            point_error_p50=median(record.point_error[0] for record in records),
            point_error_p95=median(record.point_error[1] for record in records),
            normal_error_p50=median(record.normal_error[0] for record in records),
            normal_error_p95=median(record.normal_error[1] for record in records),
            tare_s=median(record.tare_s for record in records),
        ),
        samples=MedianSamples(median(float(record.samples) for record in good)),
        probes=Probes(sum(record.ticks for record in records) if evidence.program.probes else 0),
        trial_s=MedianTime(median(record.world_s for record in good)),
        priorities=Priorities(
            _largest(record.largest_leak for record in records),
            sum(record.leaking_ticks for record in records),
            max(len(pipeline.leaks) for stages in evidence.program.pipelines() for pipeline in stages),
        ),
        quality=quality(records),
        starts=starts_of(spec.trials, records),
        wall_s=manifest.wall_s,
        world_s=sum(record.world_s for record in records),
        records=records,
        versions=dict(manifest.versions),
        command=repeating(folder),
    )


def repeating(folder: RunFolder) -> str:
    """The command that runs the same trials again."""
    manifest = folder.manifest
    words = ["graspdsl", "run", str(folder.path / SPEC)]
    words += [word for setting in manifest.settings for word in ("--set", setting)]
    words += ["--trials", str(manifest.asked), "--seed", str(manifest.seed)]
    return shlex.join(words)


def _residual(
    records: Sequence[TrialRecord], in_contact: Sequence[TrialRecord], kind: Literal["force", "moment"]
) -> Residual:
    start, end = attrgetter(f"{kind}_residual_start"), attrgetter(f"{kind}_residual_end")
    return Residual(
        start=median(map(start, records)),
        end=median(map(end, records)),
        end_in_contact=median(map(end, in_contact)),
        squared=Squared(
            start=median(_square(start(record)) for record in records),
            end=median(_square(end(record)) for record in records),
            end_in_contact=median(_square(end(record)) for record in in_contact),
        ),
    )


def _modes(records: Sequence[TrialRecord]) -> Iterable[ModeSummary]:
    measured = [record for record in records if math.isfinite(record.orientation_end)]
    ends = np.array([record.orientation_end for record in measured])
    for mode in modes(ends):
        members = [measured[i] for i in mode.members]
        yield ModeSummary(
            centre=mode.centre,
            share=len(members) / len(measured),
            of=len(measured),
            interval=wilson(len(members), len(measured)),
            force_residual=median(record.force_residual_end for record in members),
            moment_residual=median(record.moment_residual_end for record in members),
            force_squared=median(_square(record.force_residual_end) for record in members),
            moment_squared=median(_square(record.moment_residual_end) for record in members),
            range=(mode.low, mode.high),
            trials=tuple(record.number for record in members),
            bandwidth=bandwidth(ends),
        )


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
        return {one.metadata.get("key", one.name): plain(getattr(value, one.name)) for one in fields(value)}
    if isinstance(value, BaseModel):
        return value.model_dump(mode="json")
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if isinstance(value, list | tuple):
        return [plain(part) for part in value]
    if isinstance(value, Enum):
        return value.value
    return None if isinstance(value, float) and not math.isfinite(value) else value
