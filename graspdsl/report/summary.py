"""The summary of a run: the numbers of ``report --json``."""

from __future__ import annotations

import dataclasses
import math
import shlex
from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from graspdsl.report.quality import quality
from graspdsl.report.statistics import bandwidth, modes, wilson
from graspdsl.spec.loading import load_spec_text
from graspdsl.spec.models import Spec
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import SPEC, RunFolder


def summary(folder: RunFolder) -> dict[str, Any]:
    """Everything a report says of a run, as plain data; what could not be measured is None.

    Residuals are medians over trials of ‖ρ_f‖ (1) and ‖ρ_m‖ (m) by the simulator's truth; orientations (rad) stand by
    trial number; shares carry 95 % Wilson intervals. Raises DiagnosticError when the run cannot be read.
    """
    records, manifest = folder.records(), folder.manifest
    spec = _spec(folder)
    probing = spec.control.displacement == "probing" and spec.scene.world != "floating"
    good = [record for record in records if record.outcome is Outcome.CONVERGED]
    converged = len(good)
    to_converge = [record.ticks_to_converge for record in records if record.ticks_to_converge is not None]
    return {
        "name": manifest.name,
        "run": str(folder.path),
        "seed": manifest.seed,
        "trials": {"asked": manifest.asked, "finished": len(records)},
        "outcomes": dict(Counter(record.outcome.value for record in records).most_common()),
        "converged": {
            "share": _share(converged, len(records)),
            "interval": wilson(converged, len(records)),
            "means": spec.program[-1].until.model_dump(mode="json"),
        },
        "residuals": {
            "force": {
                "start": _median(record.force_residual_start for record in records),
                "end": _median(record.force_residual_end for record in records),
            },
            "moment": {
                "start": _median(record.moment_residual_start for record in records),
                "end": _median(record.moment_residual_end for record in records),
            },
        },
        "orientation": {
            "start": [_known(record.orientation_start) for record in records],
            "end": [_known(record.orientation_end) for record in records],
        },
        "modes": _modes(records),
        "ticks_to_converge": {"median": _percentile(to_converge, 50), "p90": _percentile(to_converge, 90)},
        "contact_force": {
            "median": _median(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
            "least": _least(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
            "largest": _largest(f for r in records if r.outcome is Outcome.CONVERGED for f in r.contact_forces),
        },
        "object_shift": {
            "median": _median(r.object_shift for r in records),
            "largest": _largest(r.object_shift for r in records),
        },
        "sensing": {
            "point_error_p95": _median(record.point_error[1] for record in records),
            "normal_error_p95": _median(record.normal_error[1] for record in records),
        },
        "samples": {"median": _median(float(record.samples) for record in good)},
        "probes": {"total": sum(record.ticks for record in records) if probing else 0},
        "trial_s": {"median": _median(record.world_s for record in good)},
        "priorities": {
            "largest_leak": _largest(record.largest_leak for record in records),
            "ticks_above_1e-6": sum(record.leaking_ticks for record in records),
        },
        "quality": quality(records),
        "redraws": sum(record.redraws for record in records),
        "wall_s": manifest.wall_s,
        "world_s": sum(record.world_s for record in records),
        "records": [_plain(record) for record in records],
        "versions": dict(manifest.versions),
        "command": repeating(folder),
    }


def repeating(folder: RunFolder) -> str:
    """The command that runs the same trials again."""
    manifest = folder.manifest
    settings = [setting for setting in manifest.overrides if not setting.startswith(("trials.count=", "trials.seed="))]
    words = ["graspdsl", "run", str(folder.path / SPEC)]
    words += [word for setting in settings for word in ("--set", setting)]
    words += ["--trials", str(manifest.asked), "--seed", str(manifest.seed)]
    return shlex.join(words)


def _spec(folder: RunFolder) -> Spec:
    """The spec of a run as it was run, overrides applied."""
    manifest = folder.manifest
    return load_spec_text(folder.spec_text, manifest.spec_file, manifest.overrides).spec


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
                "interval": wilson(len(members), len(measured)),
                "force_residual": _median(record.force_residual_end for record in members),
                "moment_residual": _median(record.moment_residual_end for record in members),
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
            plain[name] = [_known(number) for number in value]
        else:
            plain[name] = _known(value) if isinstance(value, float) else value
    return {**plain, "outcome": record.outcome.value}


def _known(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _finite(values: Iterable[float]) -> list[float]:
    return [value for value in values if math.isfinite(value)]


def _median(values: Iterable[float]) -> float | None:
    return _percentile(_finite(values), 50)


def _percentile(values: Sequence[float], percent: float) -> float | None:
    return float(np.percentile(values, percent)) if values else None


def _least(values: Iterable[float]) -> float | None:
    return min(_finite(values), default=None)


def _largest(values: Iterable[float]) -> float | None:
    return max(_finite(values), default=None)


def _share(part: int, whole: int) -> float | None:
    return part / whole if whole else None
