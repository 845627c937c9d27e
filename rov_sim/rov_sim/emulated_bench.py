"""The thruster in its flow tank as the plant behind an emulated device: throttles in, counts of the sensors out.

    device ── throttle [V] ──> flow tank (RK4, effects) ── n, U, T, Q ──> noise, converters ── counts ──> device

One disturbance of each sensor is drawn for each period and held over it. They are drawn for an hour, after which they
come again. The load cell on its own recorder tells the mean thrust over each period, as the device's load channels do
not: the rig had no load cell in its loop.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import floor, nan
from typing import Any, NamedTuple

import numpy as np

from bench_driver.device import Inputs, Outputs
from bench_driver.text_protocol import count_from_flow, count_from_speed
from rov_sim.rig_sensors import Rig, disturbances, flow_read, speed_read
from thruster_model.compilation import compiled
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.effects.stages import LIBRARY
from thruster_model.flow_tank import AT_REST, PlantState, plant_step
from thruster_model.pipeline import memory_length, pipeline

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
        coefficients: of any model; effects: those that act in the plant.
        rig: the sensors.
        period: of the host's commands [s], for which one disturbance is drawn.
        seed: of everything random.

    Raises:
        ValueError: effects that act on whole recorded series, or a period that is no time.
    """

    coefficients: Any
    effects: ActiveEffects = NOTHING
    rig: Rig = field(default_factory=Rig)
    period: float = 0.04
    seed: int = 0

    def __post_init__(self) -> None:
        series = [name for name in self.effects.sizes if LIBRARY[name].samples is not None]
        if series:
            told = ", ".join(series)
            raise ValueError(
                f"effects: expected effects that act in the plant; found {told}, which act on whole recorded series: "
                "the offline closed loop and bench_campaign have them"
            )
        if not 0.0 < self.period < np.inf:
            raise ValueError(f"period: expected a finite time above 0 s; found {self.period} s")


@compiled
def _advanced(state, u, step, count, first, history, p, e):  # type: ignore[no-untyped-def]
    """Return (state, thrust's integral [N s], n, v, U, T, Q) after `count` steps under the throttle u [V].

    history: ring of the ambient flow, one longer than the effects' memory; first: steps since the start.
    """
    back = history.size - 1
    now = (0.0, 0.0, 0.0, 0.0, 0.0)
    force = 0.0
    for i in range(first, first + count + 1):
        past = history[i % (back + 1)] if i >= back else 0.0
        now = pipeline(state.n, state.v, state.ambient, state.u, state.heat, past, 1.0, 1.0, p, e)[3:]
        at_an_end = i == first or i == first + count
        force += (0.5 if at_an_end else 1.0) * step * now[3]
        if i < first + count:
            history[(i + back) % (back + 1)] = state.ambient
            state = plant_step(state, u, step, past, 1.0, 1.0, p, e)
    return state, (force if count > 0 else 0.0), now[0], now[1], now[2], now[3], now[4]


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
        self._p, self._e = settings.coefficients, settings.effects.plant
        self._state = PlantState(*map(float, AT_REST))
        self._history = np.zeros(round(memory_length(0.0, self._e) / _STEP) + 1)
        self._steps = 0
        self._force, self._since = 0.0, 0.0
        self._pass(0.0, 0)
        rng = np.random.default_rng((settings.seed, 0))
        count = round(_REPEATED_AFTER / settings.period)
        self._noise = disturbances(settings.rig, count, settings.period, rng)

    @property
    def time(self) -> float:
        """Return the time since the start [s]."""
        return self._steps * _STEP

    def read(self) -> Inputs:
        """Return what the sensors read now."""
        now, k = self.truth(), self._period_now(0.0)
        noise = self._noise
        n = float(speed_read(now.n, noise.speed[k], False))
        U = float(flow_read(now.U, noise.flow[k], noise.eddies[k], False))
        counts = () if self._loads is None else self._loads((now.T, 0.0, 0.0, now.Q, 0.0, 0.0))
        return Inputs(tachometer_counts=(count_from_speed(n),), flow_counts=(count_from_flow(U),), load_counts=counts)

    def __call__(self, period: float, outputs: Outputs) -> Inputs:
        """Let a period [s], a multiple of 1 ms, pass under the device's throttle; return what the sensors read then."""
        count = round(period / _STEP)
        if count < 1 or abs(period - count * _STEP) > 1e-9:
            raise ValueError(f"period: expected a multiple of {_STEP} s above 0; found {period} s")
        self._pass(float(outputs.throttles[0]), count)
        self._since += period
        return self.read()

    def truth(self) -> BenchTruth:
        """Return the true states."""
        return self._now

    def _pass(self, u: float, count: int) -> None:
        self._state, force, n, v, U, T, Q = _advanced(
            self._state, u, _STEP, count, self._steps, self._history, self._p, self._e
        )
        self._now = BenchTruth(n, v, U, T, Q, self._state.u)
        self._steps += count
        self._force += force

    def mean_thrust(self) -> MeanThrust:
        """Return the mean over the time since it was last asked for, and begin anew; NaN for no time."""
        if self._since <= 0.0:
            return MeanThrust(nan, nan)
        true = self._force / self._since
        noise = float(self._noise.load[self._period_now(-0.5 * self._since)])
        self._force = self._since = 0.0
        return MeanThrust(true, true + noise)

    def _period_now(self, later: float) -> int:
        return floor((self.time + later) / self._given.period + 1e-6) % self._noise.speed.size
