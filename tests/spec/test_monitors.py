"""Monitors as lines of a spec: defaults, words for on and off, and what a held object needs none of."""

from __future__ import annotations

import pytest

from graspdsl.diagnostics import DiagnosticError
from graspdsl.spec import Spec, load_spec_text
from graspdsl.spec.monitors import MONITORS, MonitorBounds
from graspdsl.spec.watching import AT_ONCE, OFF

LINES = tuple(MonitorBounds.model_fields)
TIMES = tuple(key for key, monitor in MONITORS.items() if "stop" in monitor.words)
SPELLINGS = [
    (written, monitor.outcome.value, key)
    for key, monitor in MONITORS.items()
    for outcome in [monitor.outcome.value]
    for written in sorted({outcome, outcome.replace("-", "_")})
    if written not in LINES
]


def monitors(good: str, *lines: str) -> MonitorBounds:
    """The monitors of a spec with some lines of its own."""
    spec: Spec = load_spec_text(good + "\nmonitors:\n" + "".join(f"  {line}\n" for line in lines), "test.yaml").spec
    return spec.monitors


def test_every_line_has_a_default_with_its_unit() -> None:
    for name, field in MonitorBounds.model_fields.items():
        assert not field.is_required(), name
        assert field.description
        assert (
            name == "progress"
            or "(s)" in field.description
            or "(m)" in field.description
            or "(rad)" in field.description
        )


@pytest.mark.parametrize(("written", "outcome", "name"), SPELLINGS)
def test_an_outcome_in_place_of_its_monitor_names_the_monitor(good: str, written: str, outcome: str, name: str) -> None:
    with pytest.raises(DiagnosticError) as caught:
        monitors(good, f"{written}: off")
    [found] = caught.value.diagnostics
    assert (found.code, found.hint) == ("unknown-key", f"the monitor of {outcome} is {name}")
    assert f": {outcome}" in str(MonitorBounds.model_fields[name].description)


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("word", ["off", "'off'", "false"])
def test_a_line_can_be_switched_off(good: str, name: str, word: str) -> None:
    assert getattr(monitors(good, f"{name}: {word}"), name) == OFF


@pytest.mark.parametrize("name", LINES)
@pytest.mark.parametrize("word", ["on", "true"])
def test_a_line_can_be_switched_on(good: str, name: str, word: str) -> None:
    assert getattr(monitors(good, f"{name}: {word}"), name) == MonitorBounds.model_fields[name].default


@pytest.mark.parametrize("name", TIMES)
def test_stop_is_a_time_of_nothing(good: str, name: str) -> None:
    assert getattr(monitors(good, f"{name}: stop"), name) == AT_ONCE


def test_the_lines_of_a_whole_mapping(good: str) -> None:
    found = monitors(good, "lost: 1", "lean: 0.2", "dragged: 0.01", "progress: {window: 3.0, least: 0.1}")
    assert (found.lost, found.lean, found.dragged, found.palm) == (1.0, 0.2, 0.01, AT_ONCE)
    assert found.progress != OFF
    assert (found.progress.window, found.progress.least, found.progress.probes) == (3.0, 0.1, 15)


def test_a_held_object_may_touch_and_move_unless_the_spec_minds() -> None:
    plain = MonitorBounds()
    assert plain.in_effect(held=False) == plain
    held = plain.in_effect(held=True)
    assert {name for name in LINES if getattr(held, name) == OFF} == {"palm", "link", "lean", "shift", "dragged"}
    minded = MonitorBounds.model_validate({"palm": True, "shift": 0.3}).in_effect(held=True)
    assert (minded.palm, minded.shift, minded.link) == (AT_ONCE, 0.3, OFF)
