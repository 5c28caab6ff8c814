"""The table of tactile sensors."""

from __future__ import annotations

from graspdsl.spec.sensing import TactileSensor
from graspdsl.worlds.touch.exact import ExactContacts
from graspdsl.worlds.touch.fingertip_sensor import FingertipSensor
from graspdsl.worlds.touch.load_cells import LoadCells
from graspdsl.worlds.touch.proximity import ProximitySensors
from graspdsl.worlds.touch.skins import Skins

TACTILE_SENSORS: dict[str, type[FingertipSensor]] = {
    sensor.name: sensor for sensor in (LoadCells, Skins, ProximitySensors, ExactContacts)
}


def sensor_for(spec: TactileSensor) -> type[FingertipSensor]:
    """The tactile sensor that a spec's settings are of."""
    return next(sensor for sensor in TACTILE_SENSORS.values() if isinstance(spec, sensor.model))
