"""What became of the starts that a spec asks for: those that a world could take up are no fair sample of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy.stats import norm

from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.trials import PARAMETERS, Trials
from graspdsl.trials.record import TrialRecord

QUANTILES = (0.05, 0.5, 0.95)


def starts_of(trials: Trials, records: Sequence[TrialRecord]) -> dict[str, Any]:
    """What was drawn and what was kept, as plain data.

    draws: how many starts were drawn; kept: with how many of them trials began; rejected: how many could not be taken
    up, by reason; parameters: for every number of a start that differs from trial to trial, its unit and its 5 %, 50 %
    and 95 % quantiles as the spec asks for them and as trials began with them (None where none began).
    """
    rejected = Counter(start.reason for record in records for start in record.rejected)
    kept = [record for record in records if record.start]
    return {
        "draws": len(kept) + rejected.total(),
        "kept": len(kept),
        "rejected": dict(rejected.most_common()),
        "parameters": {
            name: {
                "unit": unit,
                "asked": asked,
                "kept": _quantiles([record.start[name] for record in kept]),
            }
            for name, unit, asked in _asked(trials, records)
            if all(name in record.start for record in kept)
        },
    }


def _asked(trials: Trials, records: Sequence[TrialRecord]) -> list[tuple[str, str, list[float] | None]]:
    """The numbers of a start that differ from trial to trial, their units and their quantiles as asked for."""
    start, gridded = trials.start, {axis.parameter for axis in trials.grid or ()}
    asked: list[tuple[str, str, list[float] | None]] = []
    for name in PARAMETERS:
        unit = "rad" if name in ("roll", "yaw", "tilt") else "m"
        if name in gridded:
            asked.append((name, unit, _quantiles([getattr(trials.start_of(r.number), name) for r in records])))
        elif (quantiles := _quantiles_of(getattr(start, name))) is not None:
            asked.append((name, unit, quantiles))
    places = ((name, _quantiles_of(place)) for name, place in start.posture.items())
    return asked + [(name, "", quantiles) for name, quantiles in places if quantiles is not None]


def _quantiles_of(distribution: float | Uniform | Normal | Choice) -> list[float] | None:
    """Those of a distribution; None of a number, which is always the same."""
    match distribution:
        case Uniform(uniform=(low, high)):
            return [low + share * (high - low) for share in QUANTILES]
        case Normal(normal=(mean, deviation)):
            return [float(mean + deviation * norm.ppf(share)) for share in QUANTILES]
        case Choice(choice=values):
            return [float(value) for value in np.quantile(values, QUANTILES, method="inverted_cdf")]
    return None


def _quantiles(values: Sequence[float]) -> list[float] | None:
    return [float(value) for value in np.quantile(values, QUANTILES)] if values else None
