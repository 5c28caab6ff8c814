"""Runs side by side: what each did, and ratios against the first with intervals."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.report.statistics import wilson
from graspdsl.spec.loading import load_spec_text
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import RunFolder

RESAMPLES = 2000
BOOTSTRAP_SEED = 0  # the interval of a comparison is the same whenever it is made

MEASURES: dict[str, tuple[str, Callable[[TrialRecord], float]]] = {
    "world_s": ("time of a trial [s]", lambda record: record.world_s),
    "samples": ("tactile samples", lambda record: float(record.samples)),
    "ticks": ("ticks or probes", lambda record: float(record.ticks)),
    "orientation_end": ("orientation at the end [rad]", lambda record: record.orientation_end),
    "force_residual_end": ("force residual at the end", lambda record: record.force_residual_end),
    "moment_residual_end": ("moment residual at the end [m]", lambda record: record.moment_residual_end),
}
RATIOS = ("world_s", "samples", "ticks")


def comparison(folders: Sequence[RunFolder]) -> dict[str, Any]:
    """Everything ``compare`` says, as plain data.

    Medians are over converged trials. Ratios are of medians against the first run, with 95 % intervals by the
    percentile bootstrap over trials: over pairs of trials where both runs have the same starts, else over each run's
    trials on its own. ``orientation_difference``: the median of |difference| [rad] over pairs.
    """
    runs = [(folder, folder.records()) for folder in folders]
    first = runs[0]
    return {
        "measures": {name: label for name, (label, _) in MEASURES.items()},
        "runs": [_column(folder, records) for folder, records in runs],
        "against_first": [_against(first, other) for other in runs[1:]],
    }


def _column(folder: RunFolder, records: Sequence[TrialRecord]) -> dict[str, Any]:
    converged = _converged(records)
    return {
        "name": folder.manifest.name,
        "run": str(folder.path),
        "seed": folder.manifest.seed,
        "finished": len(records),
        "converged": len(converged),
        "share": len(converged) / len(records) if records else None,
        "interval": wilson(len(converged), len(records)),
        "medians": {name: _median([measure(r) for r in converged]) for name, (_, measure) in MEASURES.items()},
    }


def _against(first: tuple[RunFolder, list[TrialRecord]], other: tuple[RunFolder, list[TrialRecord]]) -> dict[str, Any]:
    pairs = _pairs(first, other)
    ratios = {}
    for name in RATIOS:
        measure = MEASURES[name][1]
        if pairs:
            values = np.array([[measure(a), measure(b)] for a, b in pairs])
            ratios[name] = _ratio(values[:, 1], values[:, 0], paired=True)
        else:
            ours, theirs = _converged(other[1]), _converged(first[1])
            ratios[name] = _ratio(
                np.array([measure(r) for r in ours]), np.array([measure(r) for r in theirs]), paired=False
            )
    turned = [abs(a.orientation_end - b.orientation_end) for a, b in pairs]
    return {
        "run": str(other[0].path),
        "pairs": len(pairs),
        "ratios": ratios,
        "orientation_difference": _median(turned),
    }


def _pairs(
    first: tuple[RunFolder, list[TrialRecord]], other: tuple[RunFolder, list[TrialRecord]]
) -> list[tuple[TrialRecord, TrialRecord]]:
    """Converged trials of the same number that began alike."""
    if first[0].manifest.seed != other[0].manifest.seed or _scene(first[0]) != _scene(other[0]):
        return []
    known = {record.number: record for record in _converged(first[1])}
    return [
        (known[record.number], record)
        for record in _converged(other[1])
        if record.number in known and known[record.number].start == record.start
    ]


def _scene(folder: RunFolder) -> tuple[object, ...]:
    """What, besides the seed, makes starts equal: the same robot before the same object."""
    manifest = folder.manifest
    scene = load_spec_text(folder.spec_text, manifest.spec_file, manifest.overrides).spec.scene
    return scene.world, scene.hand, scene.mount, scene.object


def _converged(records: Sequence[TrialRecord]) -> list[TrialRecord]:
    return [record for record in records if record.outcome is Outcome.CONVERGED]


def _ratio(above: Array, below: Array, *, paired: bool) -> dict[str, Any] | None:
    """The ratio of two medians and its interval; None where there is none."""
    if len(above) == 0 or len(below) == 0 or np.median(below) == 0.0:
        return None
    random = np.random.default_rng(BOOTSTRAP_SEED)
    rows = random.integers(len(above), size=(RESAMPLES, len(above)))
    columns = rows if paired else random.integers(len(below), size=(RESAMPLES, len(below)))
    medians = np.median(below[columns], axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.median(above[rows], axis=1) / medians
    low, high = np.percentile(ratios[np.isfinite(ratios)], [2.5, 97.5])
    return {"value": float(np.median(above) / np.median(below)), "interval": [float(low), float(high)]}


def _median(values: Sequence[float]) -> float | None:
    known = [value for value in values if math.isfinite(value)]
    return float(np.median(known)) if known else None
