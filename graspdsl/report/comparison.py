"""Runs side by side: what each did, and differences from the first with intervals."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from graspdsl.arrays import Array, Flags
from graspdsl.report.compared_measures import MEASURES, Measure
from graspdsl.report.differences import (
    Estimate,
    difference_of_medians,
    difference_of_paired_shares,
    difference_of_shares,
    ratio_of_medians,
)
from graspdsl.report.evidence import Evidence, gathered
from graspdsl.report.statistics import median, wilson
from graspdsl.report.summary import numbers_of
from graspdsl.spec.loading import load_spec_text
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.trials.store import RunFolder

Pairs = Sequence[tuple[TrialRecord, TrialRecord]]  # of the first run, of the other
Run = tuple[RunFolder, list[TrialRecord]]


def comparison(folders: Sequence[RunFolder]) -> dict[str, Any]:
    """Everything ``compare`` says, as plain data; what could not be measured is None.

    Shares carry 95 % Wilson intervals. Medians are over all finished trials that have the measure, those of costs
    over converged ones. Differences and ratios are against the first run, each with its method; an interval that ends
    at infinity has None for that end. Trials are paired where at least half of the smaller run's trials began like
    those of the same number in the first run.
    ``orientation_difference``: the median of |difference| [rad] over pairs of converged trials. Raises
    DiagnosticError when a run cannot be read.
    """
    gatherings = [gathered(folder) for folder in folders]  # read once: a run may grow meanwhile
    runs = [(evidence.folder, list(evidence.records)) for evidence in gatherings]
    return {
        "measures": {name: measure.label for name, measure in MEASURES.items()},
        "runs": [_column(evidence) for evidence in gatherings],
        "against_first": [_against(runs[0], other) for other in runs[1:]],
    }


def _column(evidence: Evidence) -> dict[str, Any]:
    numbers, records, folder = numbers_of(evidence), evidence.records, evidence.folder
    finished, converged = len(records), numbers["outcomes"].get(Outcome.CONVERGED.value, 0)
    return {
        "name": numbers["name"],
        "settings": list(folder.manifest.settings),
        "run": numbers["run"],
        "seed": numbers["seed"],
        "command": numbers["command"],
        "asked": numbers["trials"]["asked"],
        "finished": finished,
        "converged": converged,
        "share": converged / finished if finished else None,
        "interval": wilson(converged, finished),
        "outcomes": {
            name: {"count": count, "share": count / finished, "interval": wilson(count, finished)}
            for name, count in numbers["outcomes"].items()
        },
        "modes": [
            {**{key: mode[key] for key in ("centre", "share", "interval")}, "count": len(mode["trials"])}
            for mode in numbers["modes"]
        ],
        "medians": {name: median(measure.values(records)) for name, measure in MEASURES.items()},
    }


def _against(first: Run, other: Run) -> dict[str, Any]:
    pairs = pairs_of(first, other)
    paired = len(pairs) > 0 and 2 * len(pairs) >= min(len(first[1]), len(other[1]))
    if paired:
        converged = difference_of_paired_shares(_converged([b for _, b in pairs]), _converged([a for a, _ in pairs]))
    else:
        converged = difference_of_shares(_converged(other[1]), _converged(first[1]))
    differences, ratios = {}, {}
    for name, measure in MEASURES.items():
        theirs, ours = _values(measure, pairs if paired else None, first[1], other[1])
        differences[name] = _plain(difference_of_medians(ours, theirs, paired=paired))
        if measure.ratio:
            ratios[name] = _plain(ratio_of_medians(ours, theirs, paired=paired))
    turned = [abs(a.orientation_end - b.orientation_end) for a, b in pairs if _both_converged(a, b)]
    return {
        "run": str(other[0].path),
        "pairs": len(pairs),
        "paired": paired,
        "only_first_converged": sum(_has_converged(a) and not _has_converged(b) for a, b in pairs),
        "only_other_converged": sum(_has_converged(b) and not _has_converged(a) for a, b in pairs),
        "converged": _plain(converged),
        "differences": differences,
        "ratios": ratios,
        "orientation_difference": median(np.array(turned)),
    }


def _values(
    measure: Measure, pairs: Pairs | None, first: Sequence[TrialRecord], other: Sequence[TrialRecord]
) -> tuple[Array, Array]:
    return (measure.values(first), measure.values(other)) if pairs is None else measure.paired(pairs)


def pairs_of(first: Run, other: Run) -> Pairs:
    """Trials of the same number that began alike, whatever became of them: first run's, other run's.

    In a world with a hand, where all that was drawn is equal: the two may differ in mount, sensing or controller. In
    the floating world contacts are drawn by the seed, over the object: both must be equal.
    """
    if _ground(first[0]) != _ground(other[0]):
        return []
    floats = _ground(first[0])[0] == "floating"
    known = {record.number: record for record in first[1] if floats or record.start}
    return [
        (known[record.number], record)
        for record in other[1]
        if record.number in known and known[record.number].start == record.start
    ]


def _ground(folder: RunFolder) -> tuple[object, ...]:
    """What must be the same for equal draws to be equal starts."""
    manifest = folder.manifest
    scene = load_spec_text(folder.spec_text, manifest.spec_file, manifest.overrides).spec.scene
    return (scene.world, manifest.seed, scene.hand, scene.object) if scene.world == "floating" else (scene.world,)


def _has_converged(record: TrialRecord) -> bool:
    return record.outcome is Outcome.CONVERGED


def _both_converged(one: TrialRecord, other: TrialRecord) -> bool:
    return _has_converged(one) and _has_converged(other)


def _converged(records: Sequence[TrialRecord]) -> Flags:
    return np.array([_has_converged(record) for record in records], dtype=bool)


def _plain(estimate: Estimate | None) -> dict[str, Any] | None:
    """An estimate as plain data, an end of its interval at infinity as None."""
    if estimate is None:
        return None
    ends = None if estimate.interval is None else [end if math.isfinite(end) else None for end in estimate.interval]
    return {**dataclasses.asdict(estimate), "interval": None if ends is None else tuple(ends)}
