"""What a contact feels through: four kinds of tactile sensors with their imperfections.

A sensor takes samples; each is the physical value + bias + drift + white noise, rounded to its quantum. The samples of
a control tick are filtered and averaged, those of a slower sensor held; they arrive later by the latency. The random
numbers come from the trial's seed alone. A sensor without parameters is perfect: one true value each control tick. A
sensor with any noise, bias, drift or quantum also samples, filters and tares as is usual for its kind, unless told
otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from copy import copy
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, create_model, model_validator
from pydantic.fields import FieldInfo

from graspdsl.diagnostics import listed
from graspdsl.places.fields import Metres, Model, Number, Seconds, Unit, fault, form, forms
from graspdsl.places.wording import as_yaml
from graspdsl.spec.growing import Growing, Place, grow

Newtons = Annotated[Number, Unit("N"), Field(ge=0.0, le=100.0)]
NewtonMetres = Annotated[Number, Unit("N·m"), Field(ge=0.0, le=10.0)]
Radians = Annotated[Number, Unit("rad"), Field(ge=0.0, le=1.0)]
Gaps = Annotated[Metres, Field(ge=0.0, le=0.05)]
Hertz = Annotated[Number, Unit("Hz"), Field(ge=5.0, le=10_000.0)]

TARE_TIME = 0.5  # s, of a sensor that is not perfect


class Touch(Model):
    """When a contact counts as touching: hysteresis on the force that is sensed."""

    begins: Newtons = Field(default=0.06, description="a touch begins above this force (N)")
    ends: Newtons = Field(default=0.03, description="a touch ends below this force (N), no more than 'begins'")

    @model_validator(mode="after")
    def _ordered(self) -> Touch:
        if self.ends > self.begins:
            message = f"a touch that ends below {as_yaml(self.ends)} N cannot begin at {as_yaml(self.begins)} N"
            raise fault("out-of-range", message, "make 'ends' no larger than 'begins'")
        return self


class TactileSensor(Model):
    """What all sensors have: when a contact counts as touching. ``about``: what the kind is."""

    about: ClassVar[str]

    touch: Touch = Field(default=Touch.usual(), description="when a contact counts as touching")

    @property
    def is_perfect(self) -> bool:
        """Whether what is sensed is true, however late it comes."""
        return True

    @property
    def is_random(self) -> bool:
        """Whether what is sensed differs from trial to trial where nothing else does."""
        return False

    @property
    def tare_time(self) -> float:
        """How long [s] the hand rests at the start of a trial while the sensor's zero is taken."""
        return 0.0

    def force_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of the force in one control tick's reading, by white noise alone."""
        del control_rate
        return 0.0


class SampledSensor(TactileSensor):
    """A sensor that takes samples, which arrive late. ``flaws``: its fields that are zero in a perfect one."""

    flaws: ClassVar[tuple[str, ...]]
    usual_rate: ClassVar[float]
    usual_filter: ClassVar[float] = 0.0

    rate: Hertz | None = Field(
        default=None,
        description="samples a second (Hz), 5 to 10000: those of a control tick are averaged, those of a slower sensor "
        "held; by default one a control tick for a perfect sensor, and what is usual for its kind for any other",
    )
    latency: Annotated[Seconds, Field(ge=0.0, le=0.2)] = Field(
        default=0.0,
        description="how much later (s) a sample arrives, up to 0.2; a sensor that is read once a control tick rounds "
        "it up to whole ticks",
    )
    filter: Annotated[Seconds, Field(ge=0.0, le=2.0)] | None = Field(
        default=None,
        description="time constant (s) of a first-order low-pass filter on the samples; 0: none; by default 0.05 for "
        "load cells that are not perfect, 0 for anything else",
    )
    tare: Annotated[Seconds, Field(ge=0.0, le=10.0)] | None = Field(
        default=None,
        description="how long (s) readings are averaged at the start of a trial, at rest and before any contact, to be "
        "taken as zero; 0: a single reading; by default 0.5, and 0 for a perfect sensor",
    )

    @property
    def is_perfect(self) -> bool:
        """Whether a sample is the true value, however late it comes."""
        return not any(getattr(self, name) for name in self.flaws)

    @property
    def is_random(self) -> bool:
        """Whether it has noise, a bias or a drift; rounding alone is the same each time."""
        return any(getattr(self, name) for name in self.flaws if not name.endswith("_quantum"))

    @property
    def sampling_rate(self) -> float | None:
        """Samples a second; None: one each control tick."""
        return self.rate if self.rate is not None else None if self.is_perfect else self.usual_rate

    @property
    def time_constant(self) -> float:
        """The time constant [s] of the low-pass filter; 0: none."""
        return self.filter if self.filter is not None else 0.0 if self.is_perfect else self.usual_filter

    @property
    def tare_time(self) -> float:
        """How long [s] the hand rests at the start of a trial while the sensor's zero is taken."""
        return self.tare if self.tare is not None else 0.0 if self.is_perfect else TARE_TIME

    def averaged(self, noise: float, control_rate: float) -> float:
        """What is left of white noise of this standard deviation a sample in one control tick's reading."""
        rate = self.sampling_rate or control_rate
        left = noise / math.sqrt(max(1.0, rate / control_rate))
        constant = self.time_constant
        share = 1.0 - math.exp(-1.0 / (constant * rate)) if constant > 0.0 else 1.0
        return min(left, noise * math.sqrt(share / (2.0 - share)))


class LoadCell(SampledSensor):
    """A six-axis load cell behind each fingertip: intrinsic contact sensing, from the wrench and the tip's shape.

    Noise, bias and drift are of each axis. Of a 17 mm cell at 500 Hz one may expect force_noise 0.02 N, moment_noise
    2e-4 N·m, biases of 0.5 N and 5e-3 N·m before taring, drifts of 2e-3 N and 2e-5 N·m in a second, quanta of 3e-3 N
    and 1.6e-5 N·m, and 20 ms from the contact to the controller.
    """

    about: ClassVar = "fingertip load cells"

    flaws = (
        *("force_noise", "moment_noise", "force_bias", "moment_bias"),
        *("force_drift", "moment_drift", "force_quantum", "moment_quantum"),
    )
    usual_rate = 500.0
    usual_filter = 0.05

    force_noise: Newtons = Field(default=0.0, description="white noise of a sample's force, standard deviation (N)")
    moment_noise: NewtonMetres = Field(
        default=0.0, description="white noise of a sample's moment about the cell, standard deviation (N·m)"
    )
    force_bias: Newtons = Field(default=0.0, description="standard deviation (N) of the bias drawn for each trial")
    moment_bias: NewtonMetres = Field(
        default=0.0, description="standard deviation (N·m) of the bias drawn for each trial"
    )
    force_drift: Newtons = Field(
        default=0.0, description="drift: a random walk of this standard deviation (N) after one second"
    )
    moment_drift: NewtonMetres = Field(
        default=0.0, description="drift: a random walk of this standard deviation (N·m) after one second"
    )
    force_quantum: Newtons = Field(default=0.0, description="step (N) that forces are rounded to; 0: none")
    moment_quantum: NewtonMetres = Field(default=0.0, description="step (N·m) that moments are rounded to; 0: none")

    def force_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of one axis of the force in one control tick's reading."""
        return self.averaged(self.force_noise, control_rate)


class Skin(SampledSensor):
    """A grid of taxels on each fingertip: extrinsic contact sensing, from the centroid of the pressure.

    Each contact presses on the taxels around it with a Gaussian footprint. A taxel reads the normal force on it, never
    friction; the force is their sum about the strongest one. Of a soft capacitive skin one may expect taxel_noise
    2e-3 N at 100 Hz, biases of 0.02 N before taring, drifts of 2e-4 N in a second and quanta of 2e-3 N.
    """

    about: ClassVar = "taxels on the fingertips"

    flaws = ("taxel_noise", "taxel_bias", "taxel_drift", "taxel_quantum")
    usual_rate = 100.0

    pitch: Annotated[Metres, Field(ge=5e-4, le=0.02)] = Field(
        default=0.002, description="distance (m) between neighbouring taxels, 0.0005 to 0.02"
    )
    patch: Annotated[Metres, Field(ge=2e-4, le=0.02)] = Field(
        default=0.002, description="standard deviation (m) of the footprint of a contact's pressure under the skin"
    )
    threshold: Newtons | None = Field(
        default=None,
        description="there is a contact only where a taxel reads more than this (N); by default five times the noise "
        "of a reading",
    )
    taxel_noise: Newtons = Field(default=0.0, description="white noise of a taxel's sample, standard deviation (N)")
    taxel_bias: Newtons = Field(default=0.0, description="standard deviation (N) of the bias drawn for each trial")
    taxel_drift: Newtons = Field(
        default=0.0, description="drift: a random walk of this standard deviation (N) after one second"
    )
    taxel_quantum: Newtons = Field(default=0.0, description="step (N) that taxels are rounded to; 0: none")

    @property
    def window(self) -> float:
        """The radius [m] about the strongest taxel within which taxels are counted to a contact."""
        return 2.5 * self.patch + 0.5 * self.pitch

    def taxel_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of one taxel in one control tick's reading."""
        return self.averaged(self.taxel_noise, control_rate)

    def force_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of the sum over the window in one control tick's reading."""
        taxels = max(1.0, math.pi * (self.window / self.pitch) ** 2)
        return math.sqrt(taxels) * self.taxel_noise_at(control_rate)


class Proximity(SampledSensor):
    """Infrared sensors in each fingertip: the distance of the nearest surface, and where on the tip it is nearest.

    It knows the normal before it touches. It cannot measure force: a tip of known stiffness that is dented by some
    depth is pressed as its compliance says, and that is the force that the controller gets, along the normal. There
    is nothing to tare at a distance: the bias stays. It sees the object only. One may expect distance_noise 5e-5 m and
    direction_noise 0.05 rad at 500 Hz, distance_bias 2e-5 m, direction_bias 0.01 rad and distance_quantum 1e-5 m. A
    filter would make it believe that what comes nearer is farther off.
    """

    about: ClassVar = "infrared distance sensors in the fingertips"

    flaws = (
        *("distance_noise", "direction_noise", "distance_bias", "direction_bias"),
        *("distance_drift", "direction_drift", "distance_quantum"),
    )
    usual_rate = 500.0

    range: Annotated[Metres, Field(gt=0.0, le=0.5)] = Field(
        default=0.05, description="the distance (m) within which surfaces are sensed"
    )
    stiffness: Annotated[Number, Unit("N/m"), Field(gt=0.0, le=1e6)] = Field(
        default=1500.0, description="stiffness (N/m) of the tip under light forces, which turns its dent into a force"
    )
    distance_noise: Gaps = Field(default=0.0, description="white noise of a sample's distance, standard deviation (m)")
    direction_noise: Radians = Field(
        default=0.0, description="white noise of a sample's direction from the tip's centre, standard deviation (rad)"
    )
    distance_bias: Gaps = Field(default=0.0, description="standard deviation (m) of the bias drawn for each trial")
    direction_bias: Radians = Field(
        default=0.0, description="standard deviation (rad) of the bias drawn for each trial"
    )
    distance_drift: Gaps = Field(
        default=0.0, description="drift: a random walk of this standard deviation (m) after one second"
    )
    direction_drift: Radians = Field(
        default=0.0, description="drift: a random walk of this standard deviation (rad) after one second"
    )
    distance_quantum: Gaps = Field(default=0.0, description="step (m) that distances are rounded to; 0: none")

    @property
    def tare_time(self) -> float:
        """There is nothing to take as zero."""
        return 0.0

    def force_noise_at(self, control_rate: float) -> float:
        """The standard deviation [N] of the force in one control tick's reading."""
        return self.stiffness * self.averaged(self.distance_noise, control_rate)


class Exact(TactileSensor):
    """The engine's own contacts."""

    about: ClassVar = "the true contacts"


SENSORS: dict[str, type[TactileSensor]] = {
    "load-cell": LoadCell,
    "skin": Skin,
    "proximity": Proximity,
    "exact": Exact,
}


def _field_of(name: str) -> str:
    return name.replace("-", "_")


def _key(name: str, kind: type[TactileSensor]) -> Any:
    return Field(default=None, alias=name, description=kind.about)


if TYPE_CHECKING:
    _Sensed = Growing
else:  # with a key for each sensor of the table
    _keys = {_field_of(name): (kind | None, _key(name, kind)) for name, kind in SENSORS.items()}
    _Sensed = create_model("_Sensed", __base__=Growing, **_keys)


class Sensing(_Sensed):
    """Exactly one sensor with its parameters."""

    model_config = ConfigDict(serialize_by_alias=True, json_schema_extra={"minProperties": 1, "maxProperties": 1})
    later: ClassVar = set()

    def _chosen(self) -> dict[str, TactileSensor]:
        sensors = {name: self.given(_field_of(name)) for name in SENSORS}
        return {name: sensor for name, sensor in sensors.items() if sensor is not None}

    @model_validator(mode="after")
    def _one_sensor(self) -> Sensing:
        chosen = self._chosen()
        if len(chosen) != 1:
            message = f"sensing is by exactly one sensor, found {' and '.join(chosen) or 'none'}"
            raise fault("wrong-form", message, "for example {load-cell: {force_noise: 0.02}}")
        return self

    @property
    def sensor(self) -> TactileSensor:
        """The sensor there is."""
        [sensor] = self._chosen().values()
        return sensor


def _form_of(value: Any) -> str | None:
    if isinstance(value, str):
        return "name"
    return "parameters" if isinstance(value, dict | Sensing) else None


def _choice(names: Iterable[str]) -> Any:
    expected = f"{listed(names, 'or')}, or one with parameters: {{load-cell: {{force_noise: 0.02}}}}"
    return Annotated[
        Annotated[Literal[*names], form("name")] | Annotated[Sensing, form("parameters")], forms(expected, _form_of)
    ]


if TYPE_CHECKING:
    SensingChoice = str | Sensing
else:
    SensingChoice = _choice(SENSORS)


def add_sensor(name: str, kind: type[TactileSensor], chosen: Place, around: Sequence[type[BaseModel]]) -> None:
    """Enter the model of a sensor into the table and the models: ``chosen`` is the field of a :data:`SensingChoice`,
    ``around`` are the models around it, the inner first."""
    model, field = chosen
    choice = copy(model.model_fields[field])
    choice.annotation = _choice([*SENSORS, name]) | None
    optional: Any = kind | None
    key = FieldInfo.from_annotated_attribute(optional, _key(name, kind))
    grow({(Sensing, _field_of(name)): key, chosen: choice}, around)
    Sensing.later.add(name)
    SENSORS[name] = kind


def sensor_of(choice: str | Sensing) -> TactileSensor:
    """The sensor that a spec names or describes."""
    return choice.sensor if isinstance(choice, Sensing) else SENSORS[choice]()
