"""A stranger's entries, each in its table. Monitors are keys of a model, too: they are entered where they are tried."""

from __future__ import annotations

import pytest
from graspdsl_stranger.effector import NetLeverDisplacement
from graspdsl_stranger.grade import IsotropyGrade
from graspdsl_stranger.potential import Centring
from graspdsl_stranger.sensor import NetLever

from graspdsl.basis.effectors import EFFECTORS
from graspdsl.basis.potentials import POTENTIALS
from graspdsl.basis.sensors import SENSORS
from graspdsl.quality.grades import GRADES


@pytest.fixture(autouse=True)
def _strangers(monkeypatch: pytest.MonkeyPatch) -> None:
    for table, entry in ((POTENTIALS, Centring()), (SENSORS, NetLever()), (EFFECTORS, NetLeverDisplacement())):
        monkeypatch.setitem(table, entry.symbol, entry)
    monkeypatch.setitem(GRADES, IsotropyGrade.name, IsotropyGrade())
