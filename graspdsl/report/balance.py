"""What holds the grasps of a run: the forces and moments of contacts, table and gravity on the object."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from graspdsl.arrays import Array
from graspdsl.compiler.program import Program
from graspdsl.report.statistics import HIGH, LOW
from graspdsl.spec.scene import InlineObject
from graspdsl.trials.outcomes import Outcome
from graspdsl.trials.record import TrialRecord
from graspdsl.worlds.protocol import PARTIES

NOTICED = 1e-3  # of any unit; what is less is not told in numbers


@dataclass(frozen=True, slots=True)
class Spread:
    """The median of some values and the percentiles 10 and 90."""

    median: Annotated[float, "its unit"]
    low: Annotated[float, "its unit"]
    high: Annotated[float, "its unit"]

    @classmethod
    def of(cls, values: Array) -> Spread:
        """Of values (n,)."""
        return cls(*np.percentile(values, [50.0, LOW, HIGH]).tolist())


@dataclass(frozen=True, slots=True)
class Load:
    """What acts on the object, over trials: its force across, the size of the horizontal part, and up [N], and the size
    of its moment about the centre of mass [N·m]."""

    across: Spread
    up: Spread
    moment: Spread

    @classmethod
    def of(cls, loads: Array) -> Load:
        """Of loads (n, 6)."""
        across, moment = (np.linalg.norm(part, axis=1) for part in (loads[:, :2], loads[:, 3:]))
        return cls(Spread.of(across), Spread.of(loads[:, 2]), Spread.of(moment))


@dataclass(frozen=True, slots=True)
class Alone:
    """How a free object would begin to move without the table [m/s²]: ``aside``, and ``falling`` downwards."""

    aside: Spread
    falling: Spread


@dataclass(frozen=True, slots=True)
class Holding:
    """What acts on the object in the grasps that converged, ``trials`` of them, by party, and all ``together``.

    ``bound``: what the object is fixed to and what bears that; empty where it is free. ``acceleration`` [m/s²]: what
    comes of it where it is free, and ``alone`` what would without the table. Of no trial nothing is known.
    """

    trials: int
    bound: str
    parties: Mapping[str, Load]
    together: Load | None = None
    acceleration: Spread | None = None
    alone: Alone | None = None

    def as_data(self) -> dict[str, Any]:
        """With what is said of it."""
        return {
            "trials": self.trials,
            "parties": self.parties,
            "together": self.together,
            "acceleration": self.acceleration,
            "without_table": self.alone,
            "says": self.says,
        }

    @property
    def says(self) -> str:
        """What holds the grasps, in a sentence or two; nothing where nothing is known."""
        if self.together is None:
            return ""
        if self.bound:
            return (
                f"The object is {self.bound}: that bears what is left over, {_told(self.together.across, 'N')} across "
                f"and {_upright(self.together.up)}. Whether the contacts would hold it, these forces do not say."
            )
        contacts, table, gravity = map(self.parties.get, ("contacts", "table", "gravity"))
        left = "nothing"
        if contacts is not None:
            left = f"{_told(contacts.across, 'N')} across and {_upright(contacts.up)}"
        if table is None or gravity is None or self.alone is None:
            came = f"it accelerates at {_told(self.acceleration, 'm/s²')}" if self.acceleration else ""
            return f"The contacts leave {left} on the object, and no table holds it: {came}."
        return (
            f"The contacts leave {left} on the object; the table holds against them with {_told(table.across, 'N')} of "
            f"friction, and bears {_told(table.up, 'N')} where the weight is {-gravity.up.median:.3g} N. Without the "
            f"table the object would begin to move aside at {_told(self.alone.aside, 'm/s²')} and to fall at "
            f"{_told(self.alone.falling, 'm/s²')}."
        )


def _upright(force: Spread) -> str:
    if force.median >= 0.0:
        return f"{_told(force, 'N')} up"
    return f"{_told(Spread(-force.median, -force.high, -force.low), 'N')} down"


def _told(spread: Spread, unit: str) -> str:
    if max(abs(spread.low), abs(spread.high)) < NOTICED:
        return f"less than {NOTICED:g} {unit}"
    ends = [f"{size:.2g}" for size in (spread.low, spread.high)]
    within = "" if ends[0] == ends[1] else f" ({ends[0]} to {ends[1]})"
    return f"{spread.median:.2g} {unit}{within}"


def holding(program: Program, records: Iterable[TrialRecord]) -> Holding:
    """What holds the converged grasps of a program's trials."""
    known = [record.balance for record in records if record.outcome is Outcome.CONVERGED and record.balance]
    scene, bound = program.spec.scene, ""
    if isinstance(scene.object, InlineObject):
        bound = "held by the hand" if scene.object.held else "fixed to the world" if scene.object.fixed else ""
    if not known:
        return Holding(0, bound, {})
    loads = {party: np.array([getattr(balance, party) for balance in known]) for party in PARTIES}
    together: Array = sum(loads.values(), np.zeros((len(known), 6)))
    acting = {party: Load.of(load) for party, load in loads.items() if load.any()}
    if bound:
        return Holding(len(known), bound, acting, Load.of(together))
    accelerating, alone = (force[:, :3] / program.body.mass for force in (together, together - loads["table"]))
    begins = Alone(Spread.of(np.linalg.norm(alone[:, :2], axis=1)), Spread.of(-alone[:, 2]))
    acceleration = Spread.of(np.linalg.norm(accelerating, axis=1))
    return Holding(len(known), bound, acting, Load.of(together), acceleration, begins)
