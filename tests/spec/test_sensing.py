"""Sensors in a spec: by name or with parameters, what follows from them, and what is refused."""

from __future__ import annotations

import pytest

from graspdsl.spec import load_spec_text
from graspdsl.spec.scene import Scene
from graspdsl.spec.sensing import SENSORS, Exact, LoadCell, Proximity, Skin, TactileSensor
from graspdsl.worlds.kinds import WORLDS

from .conftest import GOOD

CONTROL = 50.0  # Hz


def sensor(*overrides: str, sensing: str = "load-cell") -> TactileSensor:
    """The sensor of a spec."""
    text = GOOD.replace("sensing: load-cell", f"sensing: {sensing}")
    return felt(load_spec_text(text, "test.yaml", overrides).spec.scene)


def felt(scene: Scene) -> TactileSensor:
    """What contacts of a scene feel through."""
    return WORLDS[scene.world].sensor(scene.sensing)


@pytest.mark.parametrize("name", SENSORS)
def test_a_name_stands_for_the_sensor_without_parameters(name: str) -> None:
    assert sensor(sensing=name) == sensor(sensing=f"{{{name}: {{}}}}") == SENSORS[name]()
    assert sensor(f"scene.sensing={name}") == SENSORS[name]()


def test_load_cells_are_what_bullet_has_by_default() -> None:
    text = GOOD.replace("  sensing: load-cell\n", "")
    assert felt(load_spec_text(text, "test.yaml").spec.scene) == LoadCell()


def test_parameters_are_read() -> None:
    found = sensor(sensing="{load-cell: {force_noise: 0.02, latency: 0.01, touch: {begins: 0.1, ends: 0.05}}}")
    assert isinstance(found, LoadCell)
    assert (found.force_noise, found.latency, found.touch.begins, found.touch.ends) == (0.02, 0.01, 0.1, 0.05)


@pytest.mark.parametrize("sensing", ["load-cell", "{load-cell: {}}", "{load-cell: {latency: 0.02}}"])
def test_a_parameter_is_set_from_the_command_line(sensing: str) -> None:
    found = sensor("scene.sensing.load-cell.force_noise=0.02", sensing=sensing)
    assert isinstance(found, LoadCell)
    assert found.force_noise == 0.02
    assert found.latency == (0.02 if "latency" in sensing else 0.0)


def test_a_sensor_and_its_parameter_are_set_from_the_command_line() -> None:
    found = sensor("scene.sensing=skin", "scene.sensing.skin.pitch=0.001")
    assert isinstance(found, Skin)
    assert found.pitch == 0.001


@pytest.mark.parametrize("perfect", [LoadCell(), Skin(), Proximity(), LoadCell(latency=0.02)])
def test_a_perfect_sensor_is_read_once_a_tick(perfect: LoadCell | Skin | Proximity) -> None:
    assert perfect.is_perfect
    assert perfect.sampling_rate is None
    assert (perfect.time_constant, perfect.tare_time, perfect.force_noise_at(CONTROL)) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("kind", [LoadCell, Skin, Proximity])
def test_any_flaw_makes_a_sensor_sample_and_tare_as_is_usual(kind: type[LoadCell | Skin | Proximity]) -> None:
    for flaw in kind.flaws:
        flawed = kind.model_validate({flaw: 1e-4})
        assert not flawed.is_perfect, flaw
        assert flawed.sampling_rate == kind.usual_rate
        assert flawed.time_constant == kind.usual_filter
        assert flawed.tare_time == (0.0 if kind is Proximity else 0.5)
    given = kind.model_validate({kind.flaws[0]: 1e-4, "rate": 50.0, "filter": 0.0, "tare": 0.0})
    assert (given.sampling_rate, given.time_constant, given.tare_time) == (50.0, 0.0, 0.0)


def test_flaws_are_fields_that_are_zero() -> None:
    for kind in (LoadCell, Skin, Proximity):
        assert {kind.model_fields[flaw].default for flaw in kind.flaws} == {0.0}
        words = ("noise", "bias", "drift", "quantum")
        assert {name for name in kind.model_fields if name.endswith(words)} == set(kind.flaws)


def test_noise_left_in_a_reading() -> None:
    raw = LoadCell(force_noise=0.02, rate=CONTROL, filter=0.0)
    assert raw.force_noise_at(CONTROL) == pytest.approx(0.02)
    assert LoadCell(force_noise=0.02, rate=500.0, filter=0.0).force_noise_at(CONTROL) == pytest.approx(0.02 / 10**0.5)
    # A first-order filter leaves √(Δt / 2τ) of white noise, for τ much longer than Δt.
    slow = LoadCell(force_noise=0.02, rate=500.0, filter=0.1)
    assert slow.force_noise_at(CONTROL) == pytest.approx(0.02 * (0.002 / 0.2) ** 0.5, rel=0.01)
    assert Proximity(distance_noise=1e-4, rate=CONTROL).force_noise_at(CONTROL) == pytest.approx(0.15)
    assert Exact().force_noise_at(CONTROL) == 0.0
