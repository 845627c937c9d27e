"""What one case of the study assumes: a value for all that section 5.2 leaves open, checked."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from math import isfinite
from typing import Any

__all__ = ["CHOICES", "Assumptions", "unit_of"]

CHOICES: Mapping[str, tuple[str, ...]] = {
    "feedback": ("exact", "truth", "estimator"),
    "observers": ("told", "bench"),
    "inflow": ("kinematic", "tank"),
    "beliefs": ("published", "refitted"),
    "attitude_error": ("quaternion", "euler"),
}
"""exact: the true state; truth: with Gaussian noise; estimator: from the vehicle's sensors.
told: observers told the noise as it is; bench: the numbers that the bench ran with.
kinematic: U = K_t^T nu enters observers as measured; tank: nothing does, they predict U by (4.5) alone.
published: table and simplified model by Table 3.1; refitted: to the true thruster at rest in the water.
quaternion, euler: how the outer loop forms the error of attitude."""

_UNITS = {
    "vehicle": "set", "hull": "set", "layout": "set", "truth": "set", "script": "set points", "duration": "s",
    "largest_throttle": "V", "gain": "1/s", "speed_gain": "1/s", "rate": "Hz", "feedback": "choice",
    "attitude_error": "choice", "attitude_noise": "rad", "rate_noise": "rad/s", "velocity_noise": "m/s",
    "speed_noise": "rad/s", "observers": "choice", "inflow": "choice", "beliefs": "choice", "current_north": "m/s",
    "current_east": "m/s", "deviation": "1", "largest_step": "s",
}  # fmt: skip
_ABOVE_ZERO = ("duration", "largest_throttle", "gain", "speed_gain", "rate", "largest_step")
_ANY_SIGN = ("current_north", "current_east")


@dataclass(frozen=True, kw_only=True)
class Assumptions:
    """One case.

    Attributes:
        vehicle: vehicle set; hull, layout: other sets whose hull or whose thrusters' places count instead, "": none.
        truth: parameter set of the true thrusters.
        script: set points of the vehicle; duration: of a run [s].
        largest_throttle: of the inner loops [V].
        gain: K_P = gain I [1/s], k_I = gain times 1/s [1/s^2].
        speed_gain: k_u of (3.13) [1/s], for the strategy `dead-zone`.
        rate: of all loops [Hz].
        feedback, observers, inflow, beliefs, attitude_error: one of `CHOICES`.
        attitude_noise [rad], rate_noise [rad/s], velocity_noise [m/s]: of the feedback `truth`, each axis, each period.
        speed_noise: of the tachometers [rad/s].
        current_north, current_east: of the water [m/s], unknown to the controllers.
        deviation: of the true values of thrusters and hull [1].
        largest_step: of the plant's integration [s].

    Raises:
        ValueError: with all values that cannot be.
    """

    vehicle: str
    hull: str
    layout: str
    truth: str
    script: str
    duration: float
    largest_throttle: float
    gain: float
    speed_gain: float
    rate: float
    feedback: str
    attitude_error: str
    attitude_noise: float
    rate_noise: float
    velocity_noise: float
    speed_noise: float
    observers: str
    inflow: str
    beliefs: str
    current_north: float
    current_east: float
    deviation: float
    largest_step: float

    def __post_init__(self) -> None:
        wrong = []
        for field in fields(self):
            name, value = field.name, getattr(self, field.name)
            if name in CHOICES:
                if value not in CHOICES[name]:
                    wrong.append(f"{name}: expected one of {', '.join(CHOICES[name])}; found {value!r}")
            elif field.type in (str, "str"):
                if not isinstance(value, str):
                    wrong.append(f"{name}: expected a name; found {value!r}")
            else:
                wrong += _number_problems(name, value)
        if not wrong:
            periods = self.duration * self.rate
            if abs(periods - round(periods)) > 1e-6:
                wrong.append(f"duration: expected whole periods of {1.0 / self.rate:g} s; found {self.duration:g} s")
        if wrong:
            raise ValueError("assumptions: " + "; ".join(wrong))

    @property
    def period(self) -> float:
        """Of all loops [s]."""
        return 1.0 / self.rate

    @property
    def periods(self) -> int:
        """Periods in a run."""
        return round(self.duration * self.rate)


def unit_of(name: str) -> str:
    """Return the unit of an assumption, or what kind of word it is."""
    return _UNITS[name]


def _number_problems(name: str, value: Any) -> list[str]:
    if isinstance(value, bool) or not isinstance(value, int | float) or not isfinite(value):
        return [f"{name}: expected a finite number [{_UNITS[name]}]; found {value!r}"]
    least = "above 0" if name in _ABOVE_ZERO else "0 or more"
    if name not in _ANY_SIGN and (value < 0.0 or (value == 0.0 and name in _ABOVE_ZERO)):
        return [f"{name}: expected a number {least} [{_UNITS[name]}]; found {value:g}"]
    return []
