"""The contract of sensor transforms."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

import numpy as np

from graspdsl.basis.resources import ContactSet
from graspdsl.basis.sensors import SENSORS, Sensor
from graspdsl.contracts.drawing import (
    CONTACTS,
    NESTED,
    PLAIN,
    SHARED,
    SOME,
    VIRTUAL,
    Resources,
    drawn,
    one_of,
    sensed_by,
    sensing,
    sets_of,
)
from graspdsl.contracts.entries import (
    NEXT_TO_NOTHING,
    SAME,
    misplaced,
    misspelt,
    not_one_by_one,
    not_pure,
    undocumented,
    unreadable,
)
from graspdsl.contracts.rule import Breach, contract
from graspdsl.declared import misdeclared
from graspdsl.diagnostics import known_names_hint
from graspdsl.spec.program import Until

BATCH = (2, 3)


def declared(sensor: Sensor) -> Iterator[Breach]:
    """What a sensor transform says of itself is there, and of the right type."""
    yield from misdeclared(sensor, Sensor)


def symbol(sensor: Sensor) -> Iterator[Breach]:
    """A sensor transform is called σ_…, in every spelling."""
    yield from misspelt(sensor, "σ")


def table(sensor: Sensor) -> Iterator[Breach]:
    """A sensor transform is found by its own symbol."""
    yield from misplaced(sensor, SENSORS)


def docstring(sensor: Sensor) -> Iterator[Breach]:
    """A docstring tells symbol, source and unit."""
    yield from undocumented(sensor)


def reads(sensor: Sensor) -> Iterator[Breach]:
    """What it reads, an observation or the compiler has."""
    yield from unreadable(sensor.reads)


def roles(sensor: Sensor) -> Iterator[Breach]:
    """Joints are no contacts; reference forces are one a contact; what it measures is an end condition."""
    if sensor.over_joints and sensor.per_contact:
        yield "it is over joints and gives a row for each contact", "leave per_contact or over_joints out"
    for name in ("makes_forces", "turns_alike"):
        if getattr(sensor, name) and not sensor.per_contact:
            yield f"{name} is of contacts, one by one", f"leave {name} out, or give a row for each contact"
    if sensor.measures and sensor.measures not in Until.model_fields:
        hint = known_names_hint(sensor.measures, Until.model_fields, "end conditions")
        yield f"it measures {sensor.measures!r}, which no phase waits for", hint


def shape(sensor: Sensor) -> Iterator[Breach]:
    """σ is finite: (..., m, 3) by contact, (..., s) of joints, else (..., d), the same d for every set."""
    sizes = set()
    for name, resources in sets_of(sensor).items():
        found = sensed_by(sensor, resources, next(drawn(resources, *BATCH)))
        wanted = _shape(sensor, resources)
        sizes.add(found.shape)
        if wanted and found.shape != (*BATCH, *wanted):
            yield f"it gives {found.shape[2:]} for {name}, not {wanted}", "a row for each row of the mixing"
        elif not wanted and (found.shape[:2] != BATCH or found.ndim != 3 or len(sizes) > 1):
            yield f"it gives {found.shape} for {name}, not {BATCH} and one vector", "give (..., d), one d for all sets"
        elif not np.isfinite(found).all():
            yield f"it gives numbers that are not finite for {name}", "mind divisors and roots that can be zero"
        else:
            continue
        return


def batches(sensor: Sensor) -> Iterator[Breach]:
    """Many trials at once are sensed as one by one."""
    for resources in sets_of(sensor).values():
        batch = next(drawn(resources, *BATCH))
        each = (sensed_by(sensor, resources, one_of(batch, place)) for place in np.ndindex(BATCH))
        breaches = list(not_one_by_one(sensed_by(sensor, resources, batch), each))
        yield from breaches
        if breaches:
            return


def pure(sensor: Sensor) -> Iterator[Breach]:
    """It leaves what it reads as it is, and keeps nothing."""
    for resources in sets_of(sensor).values():
        given = next(drawn(resources, *BATCH))
        breaches = list(not_pure(sensor.evaluate, sensing(sensor, resources), *[given[name] for name in sensor.reads]))
        yield from breaches
        if breaches:
            return


def means(sensor: Sensor) -> Iterator[Breach]:
    """What is sensed of a virtual contact is the mean of what is sensed of its members (Eq. 4.32)."""
    if not sensor.per_contact or not sets_of(sensor):
        return
    given = next(drawn(PLAIN))
    each = sensed_by(sensor, PLAIN, given)
    for resources in (VIRTUAL, NESTED):
        found = sensed_by(sensor, resources, given)
        if not np.allclose(found, resources.matrix @ each, rtol=SAME, atol=NEXT_TO_NOTHING):
            hint = "work contact by contact and multiply by the mixing last: mixing @ …"
            yield "of a virtual contact it does not give the mean of its members (Eq. 4.32)", hint
            return


def own_contacts(sensor: Sensor) -> Iterator[Breach]:
    """Contacts outside a set have no part in what is sensed of it."""
    if sensor.over_joints or not sets_of(sensor):
        return
    given, other = islice(drawn(SOME), 2)
    others = np.setdiff1d(np.arange(CONTACTS), SOME.contacts)
    changed = {name: value.copy() for name, value in given.items()}
    for name in sensor.reads:
        if name not in SHARED and changed[name].shape[:1] == (CONTACTS,):
            changed[name][others] = other[name][others]
    if not np.allclose(sensed_by(sensor, SOME, changed), sensed_by(sensor, SOME, given), rtol=SAME):
        yield "contacts outside a set change what is sensed of it", "weigh contacts by the mixing alone"


RULES = contract(
    declared, symbol, table, docstring, reads, roles, shape, batches, pure, means, own_contacts, wording=(docstring,)
)


def _shape(sensor: Sensor, resources: Resources) -> tuple[int, ...]:
    """What is known of its shape; nothing of a vector over contacts."""
    if isinstance(resources, ContactSet):
        return (len(resources.members), 3) if sensor.per_contact else ()
    return (len(resources.joints),)
