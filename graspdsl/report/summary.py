"""The summary of a run: the numbers of ``report --json``."""

from __future__ import annotations

import dataclasses
import math
import shlex
from collections import Counter
from collections.abc import Iterable, Sequence
from operator import attrgetter
from typing import Any, Literal

import numpy as np

from graspdsl.report.evidence import Evidence, gathered
from graspdsl.report.outcomes import outcome_table
from graspdsl.report.quality import quality
from graspdsl.report.start_selection import starts_of
from graspdsl.report.statistics import bandwidth, median, modes, wilson
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import SPEC, RunFolder


def summary(folder: RunFolder) -> dict[str, Any]:
    """The numbers of the run in a folder, as of :func:`numbers_of`. Raises DiagnosticError when it cannot be read."""
    return numbers_of(gathered(folder))


def numbers_of(evidence: Evidence) -> dict[str, Any]:
    """Everything a report says of a run, as plain data; what could not be measured is None.

    Residuals are medians over trials of ‖ρ_f‖ (1) and ‖ρ_m‖ (m) by the simulator's truth: ``start`` and ``end`` over
    all trials, ``end_in_contact`` over those whose contacts all touched at the end, ``squared`` of ε = ρᵀρ. Modes are
    of the latter trials only; orientations (rad) stand by trial number, as does ``in_contact``: whether the hand felt
    all contacts at any time (start) and whether all truly touched at the last tick (end, None where the trajectory is
    lost). Shares carry 95 % Wilson intervals, which take trials as independent: ``different`` is how many of them can
    differ from one another, the others repeat them.
    """
    folder, records = evidence.folder, evidence.records
    manifest, spec = folder.manifest, evidence.program.spec
    in_contact = [record for record in records if evidence.touching(record)]
    good = [record for record in records if record.outcome is Outcome.CONVERGED]
    converged = len(good)
    to_converge = [record.ticks_to_converge for record in records if record.ticks_to_converge is not None]
    return {
        "name": manifest.name,
        "run": str(folder.path),
        "seed": manifest.seed,
        "trials": {
            "asked": manifest.asked,
            "finished": len(records),
            "different": int(min(len(records), evidence.program.different_trials)),
        },
        "outcomes": dict(Counter(record.outcome.value for record in records).most_common()),
        "converged": {
            "share": _share(converged, len(records)),
            "interval": wilson(converged, len(records)),
            "means": spec.program[-1].until.model_dump(mode="json"),
        },
        "outcome_table": outcome_table(records),
        "in_contact": {
            "start": [record.samples > 0 for record in records],
            "end": [evidence.touching(record) for record in records],
        },
        "residuals": {
            "force": _residual(records, in_contact, "force"),
            "moment": _residual(records, in_contact, "moment"),
        },
        "orientation": {
            "start": [_known(record.orientation_start) for record in records],
            "end": [_known(record.orientation_end) for record in records],
        },
        "modes": _modes(in_contact),
        "ticks_to_converge": {"median": _percentile(to_converge, 50), "p90": _percentile(to_converge, 90)},
        "contact_force": {
            "median": median(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
            "least": _least(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
            "largest": _largest(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
        },
        "object_shift": {
            "median": median(r.object_shift for r in records),
            "largest": _largest(r.object_shift for r in records),
        },
        "sensing": {
            "point_error_p50": median(record.point_error[0] for record in records),
            "point_error_p95": median(record.point_error[1] for record in records),
            "normal_error_p50": median(record.normal_error[0] for record in records),
            "normal_error_p95": median(record.normal_error[1] for record in records),
            "tare_s": median(record.tare_s for record in records),
        },
        "samples": {"median": median(float(record.samples) for record in good)},
        "probes": {"total": sum(record.ticks for record in records) if evidence.program.probes else 0},
        "trial_s": {"median": median(record.world_s for record in good)},
        "priorities": {
            "largest_leak": _largest(record.largest_leak for record in records),
            "ticks_above_1e-6": sum(record.leaking_ticks for record in records),
            "levels": max(len(pipeline.leaks) for stages in evidence.program.pipelines() for pipeline in stages),
        },
        "quality": quality(records),
        "starts": starts_of(evidence.program.spec.trials, records),
        "wall_s": manifest.wall_s,
        "world_s": sum(record.world_s for record in records),
        "records": [_plain(record) for record in records],
        "versions": dict(manifest.versions),
        "command": repeating(folder),
    }


def repeating(folder: RunFolder) -> str:
    """The command that runs the same trials again."""
    manifest = folder.manifest
    words = ["graspdsl", "run", str(folder.path / SPEC)]
    words += [word for setting in manifest.settings for word in ("--set", setting)]
    words += ["--trials", str(manifest.asked), "--seed", str(manifest.seed)]
    return shlex.join(words)


def _residual(
    records: Sequence[TrialRecord], in_contact: Sequence[TrialRecord], kind: Literal["force", "moment"]
) -> dict[str, Any]:
    start, end = attrgetter(f"{kind}_residual_start"), attrgetter(f"{kind}_residual_end")
    return {
        "start": median(map(start, records)),
        "end": median(map(end, records)),
        "end_in_contact": median(map(end, in_contact)),
        "squared": {
            "start": median(_square(start(record)) for record in records),
            "end": median(_square(end(record)) for record in records),
            "end_in_contact": median(_square(end(record)) for record in in_contact),
        },
    }


def _modes(records: Sequence[TrialRecord]) -> list[dict[str, Any]]:
    measured = [record for record in records if math.isfinite(record.orientation_end)]
    ends = np.array([record.orientation_end for record in measured])
    found = []
    for mode in modes(ends):
        members = [measured[i] for i in mode.members]
        found.append(
            {
                "centre": mode.centre,
                "share": len(members) / len(measured),
                "of": len(measured),
                "interval": wilson(len(members), len(measured)),
                "force_residual": median(record.force_residual_end for record in members),
                "moment_residual": median(record.moment_residual_end for record in members),
                "force_squared": median(_square(record.force_residual_end) for record in members),
                "moment_squared": median(_square(record.moment_residual_end) for record in members),
                "range": [mode.low, mode.high],
                "trials": [record.number for record in members],
                "bandwidth": bandwidth(ends),
            }
        )
    return found


def _plain(record: TrialRecord) -> dict[str, Any]:
    plain: dict[str, Any] = {}
    for name, value in dataclasses.asdict(record).items():
        if isinstance(value, tuple):
            plain[name] = [_known(part) if isinstance(part, float) else part for part in value]
        else:
            plain[name] = _known(value) if isinstance(value, float) else value
    return {**plain, "outcome": record.outcome.value}


def _square(value: float) -> float:
    return value * value


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _finite(values: Iterable[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


def _percentile(values: Sequence[float], percent: float) -> float | None:
    return float(np.percentile(values, percent)) if values else None


def _least(values: Iterable[float]) -> float | None:
    return min(_finite(values), default=None)


def _largest(values: Iterable[float]) -> float | None:
    return max(_finite(values), default=None)


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
