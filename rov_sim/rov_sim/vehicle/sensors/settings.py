"""The sensors of a vehicle as settings: when each reads, where it sits, how wrong it is.

Instants are integers of nanoseconds from the start. A sensor reads at phase + k period, after the start; what it reads
is available `delay` later and bears the instant as its stamp.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, isfinite
from typing import NamedTuple

__all__ = ["COLUMNS", "MOUNTED", "QUANTITIES", "Quantity", "Sensor", "VehicleSensors"]

Vector = tuple[float, float, float]


class Quantity(NamedTuple):
    """What a sensor reads: name, unit, number of axes."""

    name: str
    unit: str
    axes: int


QUANTITIES: Mapping[str, tuple[Quantity, ...]] = {
    "imu": (Quantity("attitude", "rad", 3), Quantity("gyro", "rad/s", 3), Quantity("force", "m/s^2", 3)),
    "velocity": (Quantity("velocity", "m/s", 3),),
    "depth": (Quantity("depth", "m", 1),),
    "tachometer": (Quantity("speed", "rad/s", 1),),
    "battery": (Quantity("voltage", "V", 1), Quantity("current", "A", 1)),
}
"""By sensor, in the order of the columns of its errors; the force is the specific force."""

COLUMNS = {name: sum(q.axes for q in quantities) for name, quantities in QUANTITIES.items()}
"""How many errors each sensor has."""

MOUNTED = {"imu": ("position", "rotation"), "velocity": ("position", "rotation"), "depth": ("position",)}
"""What of a sensor's place matters."""
FARTHEST = 10.0
"""[m] From the body's origin that a sensor may be, as its centres may."""


@dataclass(frozen=True, kw_only=True)
class Sensor:
    """One sensor.

    Attributes:
        rate: readings a second [Hz]; 0: not there.
        phase: instant of the first reading after the start [s], less than a period.
        delay: how long after its instant a reading is available [s].
        lost_share: share of readings that hold nothing; lost_length: how many of them in a row, in the mean.
        position: in body axes [m].
        rotation: roll, pitch, yaw from the body's to the sensor's axes [rad].
        noise, bias, bias_deviation: of each column of `QUANTITIES`, in its unit.
    """

    rate: float
    noise: tuple[float, ...]
    bias: tuple[float, ...]
    bias_deviation: tuple[float, ...]
    phase: float = 0.0
    delay: float = 0.0
    lost_share: float = 0.0
    lost_length: float = 1.0
    position: Vector = (0.0, 0.0, 0.0)
    rotation: Vector = (0.0, 0.0, 0.0)

    def problems(self) -> list[str]:
        """Return what is wrong, one sentence for each setting."""
        wrong = []
        numbers = (*self.noise, *self.bias, *self.bias_deviation, *self.position, *self.rotation)
        if not all(isfinite(x) for x in numbers):
            wrong.append("expected finite numbers in noise, bias, position and rotation")
        if max(map(abs, self.position)) > FARTHEST:
            wrong.append(f"position: expected at most {FARTHEST:g} m from the origin; found {list(self.position)}")
        if min(*self.noise, *self.bias_deviation, 0.0) < 0.0:
            wrong.append("noise, bias_deviation: expected 0 or more")
        if not 0.0 <= self.rate <= 1e4:
            wrong.append(f"rate: expected 0 to 10000 Hz; found {self.rate!r}")
        elif self.rate > 0.0 and abs(self.period * self.rate * 1e-9 - 1.0) > 1e-6:
            wrong.append(f"rate: expected one whose period is a number of nanoseconds; found {self.rate!r} Hz")
        elif self.rate > 0.0 and not 0.0 <= self.phase < 1.0 / self.rate:
            wrong.append(f"phase: expected 0 to less than a period of {1.0 / self.rate:g} s; found {self.phase!r}")
        if not 0.0 <= self.delay <= 10.0:
            wrong.append(f"delay: expected 0 to 10 s; found {self.delay!r}")
        if not self.lost_length >= 1.0:
            wrong.append(f"lost_length: expected 1 or more; found {self.lost_length!r}")
        elif not 0.0 <= self.lost_share <= self.lost_length / (self.lost_length + 1.0):
            largest = self.lost_length / (self.lost_length + 1.0)
            wrong.append(
                f"lost_share: expected 0 to {largest:.3g}, as one reading at least lies between losses of "
                f"{self.lost_length:g} in a row; found {self.lost_share!r}"
            )
        return wrong

    @property
    def period(self) -> int:
        """Between readings [ns]."""
        return round(1e9 / self.rate)

    @property
    def first(self) -> int:
        """Instant of the first reading after the start [ns]."""
        return round(1e9 * self.phase) or self.period

    @property
    def lateness(self) -> int:
        """The delay [ns]."""
        return round(1e9 * self.delay)


@dataclass(frozen=True, kw_only=True)
class VehicleSensors:
    """All sensors of a vehicle; every thruster has a tachometer.

    Attributes:
        signed: whether tachometers tell the direction.
        nominal_voltage: of the battery at rest [V].
        current_at_full: drawn by all thrusters at full [A]; idle_current: by the rest.
        origin: where the values come from.
    """

    imu: Sensor
    velocity: Sensor
    depth: Sensor
    tachometer: Sensor
    battery: Sensor
    signed: bool = True
    nominal_voltage: float = 16.0
    current_at_full: float = 100.0
    idle_current: float = 1.5
    origin: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        problems = self.problems()
        if problems:
            raise ValueError("\n".join(problems))

    def problems(self) -> list[str]:
        """Return what is wrong, one sentence each."""
        wrong = [f"{name}: {each}" for name in QUANTITIES for each in getattr(self, name).problems()]
        for name, count in COLUMNS.items():
            sensor = getattr(self, name)
            if {len(sensor.noise), len(sensor.bias), len(sensor.bias_deviation)} != {count}:
                wrong.append(f"{name}: expected {count} values of noise, bias and bias_deviation")
        if not 0.0 < self.nominal_voltage < inf:
            wrong.append(f"battery: nominal_voltage: expected more than 0 V, finite; found {self.nominal_voltage!r}")
        for name in ("current_at_full", "idle_current"):
            if not (isfinite(getattr(self, name)) and getattr(self, name) >= 0.0):
                wrong.append(f"battery: {name}: expected a finite number, 0 or more; found {getattr(self, name)!r}")
        return wrong

    def there(self) -> tuple[str, ...]:
        """Return the names of the sensors that are there."""
        return tuple(name for name in QUANTITIES if getattr(self, name).rate > 0.0)
