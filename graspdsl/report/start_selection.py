"""What became of the starts that a spec asks for: those that a world could take up are no fair sample of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from graspdsl.spec.distributions import Choice, Normal, Uniform
from graspdsl.spec.trials import PARAMETERS, Trials
from graspdsl.trials.record import TrialRecord

QUANTILES = (0.05, 0.5, 0.95)


@dataclass(frozen=True, slots=True)
class StartNumber:
    """A number of a start that differs from trial to trial: its unit and its quantiles, of QUANTILES, as the spec asks
    for them and as trials began with them; None where none began."""

    unit: str
    asked: tuple[float, ...] | None
    kept: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class Starts:
    """What became of the starts that were drawn: those that a world could take up are no fair sample of them.

    draws: how many were drawn; kept: with how many of them trials began; rejected: how many could not be taken up, by
    reason.
    """

    draws: int
    kept: int
    rejected: Mapping[str, int]
    parameters: Mapping[str, StartNumber]


def starts_of(trials: Trials, records: Sequence[TrialRecord]) -> Starts:
    """What was drawn for trials and what was kept."""
    rejected = Counter(start.reason for record in records for start in record.rejected)
    kept = [record for record in records if record.start]
    return Starts(
        len(kept) + rejected.total(),
        len(kept),
        dict(rejected.most_common()),
        {
            name: StartNumber(unit, asked, _quantiles([record.start[name] for record in kept]))
            for name, unit, asked in _asked(trials, records)
            if all(name in record.start for record in kept)
        },
    )


def _asked(trials: Trials, records: Sequence[TrialRecord]) -> list[tuple[str, str, tuple[float, ...] | None]]:
    """The numbers of a start that differ from trial to trial, their units and their quantiles as asked for."""
    start, gridded = trials.start, {axis.parameter for axis in trials.grid or ()}
    asked: list[tuple[str, str, tuple[float, ...] | None]] = []
    for name, unit in PARAMETERS.items():
        if name in gridded:
            asked.append((name, unit, _quantiles([getattr(trials.start_of(r.number), name) for r in records])))
        elif (quantiles := _quantiles_of(getattr(start, name))) is not None:
            asked.append((name, unit, quantiles))
    places = ((name, _quantiles_of(place)) for name, place in start.posture.items())
    return asked + [(name, "", quantiles) for name, quantiles in places if quantiles is not None]


def _quantiles_of(distribution: float | Uniform | Normal | Choice) -> tuple[float, ...] | None:
    """Those of a distribution; None of a number, which is always the same."""
    match distribution:
        case Uniform(uniform=(low, high)):
            return tuple(low + share * (high - low) for share in QUANTILES)
        case Normal(normal=(mean, deviation)):
            from scipy.special import ndtri

            return tuple(float(mean + deviation * ndtri(share)) for share in QUANTILES)
        case Choice(choice=values):
            return tuple(float(value) for value in np.quantile(values, QUANTILES, method="inverted_cdf"))
    return None


def _quantiles(values: Sequence[float]) -> tuple[float, ...] | None:
    return tuple(float(value) for value in np.quantile(values, QUANTILES)) if values else None
