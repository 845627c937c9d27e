"""A vehicle in its water with its sensors, period by period: what a graph of nodes sees of it, without the graph.

From t_k to t_k+1 each thruster holds its throttle, and so does the random wrench. In between the vehicle stops at each
instant of a sensor. Everything random depends on the seed alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import IntEnum
from math import isfinite, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.noisy_odometry import OdometryErrors, OdometryNoise, odometry_with
from rov_sim.vehicle.plant import VehiclePlant, VehicleSettings
from rov_sim.vehicle.random_wrench import RandomWrench, WrenchStream
from rov_sim.vehicle.sensors.coefficients import SensorCoefficients
from rov_sim.vehicle.sensors.live import Reading, Sensors
from rov_sim.vehicle.sensors.settings import VehicleSensors
from rov_sim.vehicle.truth import VehicleTruth
from thruster_model.effects.stages import NEUTRAL, NO_EFFECTS

__all__ = ["LOSABLE", "Failing", "FailureKind", "Instant", "LiveSettings", "LiveVehicle", "Losing", "Odometry"]

Array = NDArray[np.float64]
LOSABLE = ("imu", "velocity", "depth", "battery")
"""Sensors of the vehicle that can be lost."""


class FailureKind(IntEnum):
    """How a thruster fails, numbered as in thruster_msgs/ThrusterFailure."""

    NONE = 0
    DEAD = 1
    WEAK = 2
    STUCK = 3


class Failing(NamedTuple):
    """A failure to come.

    Attributes:
        thruster: index.
        kind: dead: no thrust at all; weak: `effectiveness` times the thrust; stuck: the throttle stays as it is.
        time: when [s].
        effectiveness: of a weak one [1].
    """

    thruster: int
    kind: FailureKind
    time: float
    effectiveness: float = nan


class Losing(NamedTuple):
    """A sensor of `LOSABLE` that tells nothing any more from a time [s] on."""

    sensor: str
    time: float


class Odometry(NamedTuple):
    """Truth with noise: position (3,) [m], attitude (4,), velocity (6,) [m/s, rad/s]."""

    position: Array
    attitude: Array
    velocity: Array


class Instant(NamedTuple):
    """What there is at an instant.

    Attributes:
        time: [ns] since the start.
        truth: the true states.
        readings: of sensors, those that arrived since the former instant.
        odometry: the truth with noise.
        failed: failures that began in this instant.
    """

    time: int
    truth: VehicleTruth
    readings: tuple[Reading, ...]
    odometry: Odometry
    failed: tuple[Failing, ...]


@dataclass(frozen=True, kw_only=True)
class LiveSettings:
    """What is simulated.

    Attributes:
        plant: vehicle with its thrusters; sensors: of it; sensed: their coefficients with effects, None: without.
        period: between instants [s].
        wrench: random, on the body; noise: of the odometry.
        failures: to come, of thrusters; lost: of sensors.
        seed: of everything random.

    Raises:
        ValueError: with all that is wrong.
    """

    plant: VehicleSettings
    sensors: VehicleSensors
    sensed: SensorCoefficients | None = None
    period: float = 0.04
    wrench: RandomWrench = field(default_factory=RandomWrench)
    noise: OdometryNoise = field(default_factory=OdometryNoise)
    failures: tuple[Failing, ...] = ()
    lost: tuple[Losing, ...] = ()
    seed: int = 0

    def __post_init__(self) -> None:
        count = self.thrusters
        wrong = [] if 0.0 < self.period <= 10.0 else [f"period: expected a time up to 10 s; found {self.period} s"]
        for each in self.failures:
            if not 0 <= each.thruster < count:
                wrong.append(f"failures: expected T1 to T{count}; found T{each.thruster + 1}")
            if each.kind == FailureKind.WEAK and not 0.0 < each.effectiveness < 1.0:
                wrong.append(f"failures: expected an effectiveness between 0 and 1; found {each.effectiveness}")
        for losing in self.lost:
            if losing.sensor not in LOSABLE:
                wrong.append(f"lost: expected one of {', '.join(LOSABLE)}; found {losing.sensor!r}")
        for time in [each.time for each in self.failures] + [each.time for each in self.lost]:
            if not (isfinite(time) and time >= 0.0):
                wrong.append(f"failures: expected a time of 0 s or more; found {time}")
        if wrong:
            raise ValueError("; ".join(wrong))

    @property
    def thrusters(self) -> int:
        """Number of thrusters."""
        return self.plant.count


class LiveVehicle:
    """The vehicle, from its initial state.

    Attributes:
        time: since the start [ns].
    """

    def __init__(self, settings: LiveSettings) -> None:
        """Begin."""
        self._healthy = _able_to_fail(settings)
        count = settings.thrusters
        self._plant = VehiclePlant(self._healthy)
        self._sensors = Sensors(settings.sensors, settings.seed, count, settings.sensed)
        self._wrenches = WrenchStream(settings.wrench, settings.period, settings.seed)
        self._errors = OdometryErrors(settings.noise, settings.seed)
        self._period = round(1e9 * settings.period)
        self._coming = sorted(settings.failures, key=lambda each: each.time)
        self._lost_at = {each.sensor: round(1e9 * each.time) for each in reversed(settings.lost)}
        self._stuck: dict[int, float] = {}
        self._held = np.zeros(count)
        self.time = 0

    def advance(self, throttles: Sequence[float], told: Mapping[int, float] | None = None) -> Instant:
        """Let a period pass under these throttles [V]; return what there is at its end.

        Args:
            throttles: one for each thruster; one that is not finite is zero.
            told: rotor speeds [rad/s] of thrusters that are not simulated, by index: they have these.
        """
        commands = np.array([u if isfinite(u) else 0.0 for u in throttles])
        for i, held in self._stuck.items():
            commands[i] = held
        self._held = commands
        for i, n in (told or {}).items():
            self._plant.turn(i, n)
        end = self.time + self._period
        wrench = self._wrenches.take(1)[0]
        readings: list[Reading] = []
        truth = None
        while self.time < end:
            instant = self._sensors.next_instant
            stop = end if instant is None else min(instant, end)
            truth = self._plant.advance(commands, 1e-9 * (stop - self.time), wrench=wrench)
            self.time = stop
            readings += map(self._told, self._sensors.read(stop, truth))
        assert truth is not None
        return Instant(self.time, truth, tuple(readings), self._odometry(truth), self._failing())

    def _told(self, reading: Reading) -> Reading:
        """Return a reading, without its values where its sensor was lost by then."""
        at = self._lost_at.get(reading.sensor)
        if at is None or reading.taken < at:
            return reading
        return reading._replace(values=(nan,) * len(reading.values))

    def _weaken(self, thruster: int, share: float) -> None:
        """Leave a share of its thrust: less thrust lets less water flow, as with the effect that is diagnosed."""
        settings, healthy = self._plant.settings, self._healthy.effects[thruster]
        effects = list(settings.effects)
        effects[thruster] = healthy._replace(thrust_loss_share=1.0 - share * (1.0 - healthy.thrust_loss_share))
        self._plant.change(replace(settings, effects=tuple(effects)))

    def _odometry(self, truth: VehicleTruth) -> Odometry:
        attitude, velocity = np.empty(4), np.empty(6)
        odometry_with(truth.attitude, truth.velocity, self._errors.take(1)[0], attitude, velocity)
        return Odometry(truth.position, attitude, velocity)

    def _failing(self) -> tuple[Failing, ...]:
        begun = []
        while self._coming and round(1e9 * self._coming[0].time) <= self.time:
            failing = self._coming.pop(0)
            begun.append(failing)
            self._stuck.pop(failing.thruster, None)
            left = {FailureKind.DEAD: 0.0, FailureKind.WEAK: failing.effectiveness}.get(failing.kind, 1.0)
            self._weaken(failing.thruster, left)
            if failing.kind == FailureKind.STUCK:
                self._stuck[failing.thruster] = float(self._held[failing.thruster])
        return tuple(begun)


def _able_to_fail(settings: LiveSettings) -> VehicleSettings:
    """Return a plant whose thrusters have effects, neutral ones where it has none, if any is to fail."""
    plant = settings.plant
    if not settings.failures:
        return plant
    return replace(plant, effects=tuple(NEUTRAL if e is NO_EFFECTS else e for e in plant.effects))
