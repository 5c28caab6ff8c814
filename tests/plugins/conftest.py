"""Tables that are, after a test, as they were before it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from graspdsl.plugins.kinds import BROUGHT, KINDS, OF_OTHERS
from graspdsl.plugins.loading import OF_CODE
from graspdsl.spec import growing
from graspdsl.spec.models import Spec
from graspdsl.spec.monitors import OUTCOMES, MonitorBounds
from graspdsl.spec.scene import InlineObject, Scene
from graspdsl.spec.sensing import SENSORS, Sensing

MODELS = (InlineObject, Sensing, MonitorBounds, Scene, Spec)


@pytest.fixture
def site(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Where a test installs packages, which are there for as long as it runs."""
    place = tmp_path / "site"
    place.mkdir()
    monkeypatch.syspath_prepend(place)
    tables = [kind.table() for name, kind in KINDS.items() if name != "controllers"]
    tables += [OF_OTHERS, BROUGHT, OF_CODE, OUTCOMES, SENSORS, MonitorBounds.meant_by]
    tables += [model.model_fields for model in MODELS]
    before = [dict(table) for table in tables]
    yield place
    for table, things in zip(tables, before, strict=True):
        table.clear()
        table.update(things)
    for model in (InlineObject, Sensing, MonitorBounds):
        model.later.clear()
    growing._make_anew(MODELS)
    for name in [name for name in sys.modules if name.startswith(("kit", "graspdsl_code_"))]:
        del sys.modules[name]
