"""The thruster in its flow tank as the plant behind an emulated device: throttles in, counts of the sensors out.

    device ── throttle [V] ──> stepper (plant, effects) ── n, U, T, Q ──> noise, converters ── counts ──> device

One disturbance of each sensor is drawn for each period and held over it. They are drawn for an hour, after which they
come again. The load cell on its own recorder tells the mean thrust over each period, as the device's load channels do
not: the rig had no load cell in its loop. Effects of the log change nothing here: they act on what has been recorded.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import floor, nan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bench_driver.device import Inputs, Outputs
from bench_driver.text_protocol import count_from_flow, count_from_speed
from rov_sim.rig_sensors import Rig, disturbances, flow_read, speed_read
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.effects.chains import SENSED
from thruster_model.effects.chains import Outputs as Sensed
from thruster_model.effects.gates import drawn_gates
from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.stepper import (
    AT_REST,
    NO_GATES,
    NOMINAL_SUPPLY,
    ROWS,
    advance,
    new_memory,
    new_sensors,
    sense,
    substeps_of,
)

__all__ = ["QUIET", "BenchPlant", "BenchSettings", "BenchTruth", "Loads", "MeanThrust"]

_STEP = 1e-3  # s, largest of the integration
_REPEATED_AFTER = 3600.0  # s

Loads = Callable[[tuple[float, ...]], tuple[int, ...]]
"""Counts of the load channels for a wrench (Fx, Fy, Fz [N], Mx, My, Mz [N m])."""

QUIET = Rig(speed_noise=0.0, flow_noise=0.0, turbulence=0.0, spike_share=0.0, load_noise=0.0)
"""Sensors without noise; converters still round."""


class BenchTruth(NamedTuple):
    """Speed n [rad/s], axial and ambient flow v, U [m/s], thrust T [N], torque Q [N m], acting throttle u [V]."""

    n: float
    v: float
    U: float
    T: float
    Q: float
    u: float


class MeanThrust(NamedTuple):
    """Thrust [N] over a period: the true mean, and what the load cell tells."""

    true: float
    told: float


@dataclass(frozen=True, kw_only=True)
class BenchSettings:
    """What stands on the bench.

    Attributes:
        coefficients: of any model; effects: those of the log are passed over.
        rig: the sensors.
        period: of the host's commands [s], for which one disturbance is drawn.
        seed: of everything random.

    Raises:
        ValueError: a period that is no time.
    """

    coefficients: Any
    effects: ActiveEffects = NOTHING
    rig: Rig = field(default_factory=Rig)
    period: float = 0.04
    seed: int = 0

    def __post_init__(self) -> None:
        if not 0.0 < self.period < np.inf:
            raise ValueError(f"period: expected a finite time above 0 s; found {self.period} s")


class BenchPlant:
    """The thruster, from rest.

    Args:
        settings: see there.
        loads: of the device's load channels, None: it has none.

    Attributes:
        time: since the start [s].
    """

    def __init__(self, settings: BenchSettings, loads: Loads | None = None) -> None:
        self._given, self._loads = settings, loads
        self._p, self._e, self._e_sensors = settings.coefficients, settings.effects.plant, settings.effects.sensors
        self._state, self._substeps = AT_REST, substeps_of(_STEP, _STEP, self._e)
        self._memory = new_memory(_STEP, self._substeps, self._e)
        self._sensors = new_sensors(_STEP, self._e_sensors, settings.seed + 1)
        self._steps = 0
        self._force, self._told, self._since = 0.0, 0.0, 0.0
        rng = np.random.default_rng((settings.seed, 0))
        count = round(_REPEATED_AFTER / settings.period)
        self._noise = disturbances(settings.rig, count, settings.period, rng)
        self._gates = drawn_gates(settings.effects, round(_REPEATED_AFTER / _STEP), _STEP, rng)
        self._true, self._read = np.zeros((len(ROWS), 1)), np.zeros((len(SENSED), 1))
        self._pass(0.0, 0)

    @property
    def time(self) -> float:
        """Return the time since the start [s]."""
        return self._steps * _STEP

    def read(self) -> Inputs:
        """Return what the sensors read now."""
        now, k = self.sensed(), self._period_now(0.0)
        noise = self._noise
        n = float(speed_read(now.speed, noise.speed[k], False))
        U = float(flow_read(now.ambient, noise.flow[k], noise.eddies[k], False))
        wrench = (now.thrust, 0.0, 0.0, now.torque, 0.0, 0.0)
        counts = () if self._loads is None else self._loads(wrench)
        return Inputs(tachometer_counts=(count_from_speed(n),), flow_counts=(count_from_flow(U),), load_counts=counts)

    def __call__(self, period: float, outputs: Outputs) -> Inputs:
        """Let a period [s], a multiple of 1 ms, pass under the device's throttle; return what the sensors read then."""
        count = round(period / _STEP)
        if count < 1 or abs(period - count * _STEP) > 1e-9:
            raise ValueError(f"period: expected a multiple of {_STEP} s above 0; found {period} s")
        self._pass(float(outputs.throttles[0]), count)
        self._since += period
        return self.read()

    def sensed(self) -> Sensed:
        """Return what the sensors make of the true states, before noise and converters."""
        return Sensed(*self._read[:, -1].tolist())

    def truth(self) -> BenchTruth:
        """Return the true states."""
        n, v, U, T, Q, u = self._true[:, -1].tolist()
        return BenchTruth(n, v, U, T, Q, u)

    def _pass(self, u: float, count: int) -> None:
        begins = self._steps
        true, read = np.empty((len(ROWS), count + 1)), np.empty((len(SENSED), count + 1))
        self._state = advance(
            self._state, np.full((count, 1), u), _STEP, self._substeps, self._p, self._e,
            self.gates(count + 1, self._steps), NOMINAL_SUPPLY, self._memory, true, 0,
        )  # fmt: skip
        if self._e_sensors is NO_EFFECTS:
            read = true[: len(SENSED)]
        else:
            read[:, 0] = self._read[:, -1]
            sense(true, int(begins + count > 0), count + 1, _STEP, self._e_sensors, self._sensors, read)
        self._true, self._read = true, read
        self._steps += count
        thrust = SENSED.index("thrust")
        self._force += _integral(true[thrust])
        self._told += _integral(read[thrust])

    def gates(self, count: int, first: int = 0) -> NDArray[np.float64]:
        """Return from `first` on for `count` steps 0 where the propeller may draw air, else 1; none: it never does."""
        return np.take(self._gates, range(first, first + count), mode="wrap") if self._gates.size else NO_GATES

    def mean_thrust(self) -> MeanThrust:
        """Return the mean over the time since it was last asked for, and begin anew; NaN for no time."""
        if self._since <= 0.0:
            return MeanThrust(nan, nan)
        true, told = self._force / self._since, self._told / self._since
        noise = float(self._noise.load[self._period_now(-0.5 * self._since)])
        self._force = self._told = self._since = 0.0
        return MeanThrust(true, told + noise)

    def _period_now(self, later: float) -> int:
        return floor((self.time + later) / self._given.period + 1e-6) % self._noise.speed.size


def _integral(values: NDArray[np.float64]) -> float:
    """Return the integral over time of values at the ends of steps, by the trapezium."""
    return _STEP * float(values.sum() - 0.5 * (values[0] + values[-1]))
