"""The closed loop of a vehicle offline: plant, sensors or noisy truth, outer loop, allocation, inner loops.

The step functions that the nodes call, at a fixed period, without ROS. Ticks are at t_k = k period, k = 1, 2, …; at
time 0 nothing is measured, and until the first tick throttles are zero. A run depends on its arguments and seed alone.
"""

from dataclasses import dataclass, field
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.closed_loop import Controller
from rov_sim.vehicle.inner_loops import ESTIMATES, Wiring, inner_loops_at_rest
from rov_sim.vehicle.kernel import record_width
from rov_sim.vehicle.loop_kernel import Feedback, Outer, Plant, Record, record_of, run_vehicle_loop
from rov_sim.vehicle.noisy_odometry import OdometryErrors, OdometryNoise
from rov_sim.vehicle.plant import VehicleSettings, sheet_of
from rov_sim.vehicle.poses import euler_angles
from rov_sim.vehicle.sensors.in_loop import loop_sensors
from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_control.allocation.failures import allocation
from thruster_control.allocation.settings import AllocationSettings, Method, allocation_memory
from thruster_control.outer_loop.settings import VehicleSetPoint, outer_memory
from thruster_control.settings import SteadyFlowLaw
from thruster_control.vehicle_set_points import Script
from thruster_estimation.navigation_belief import NavigationSettings, checked_navigation
from thruster_estimation.settings import SpeedEkfSettings

__all__ = ["Steering", "VehicleFeedback", "VehicleLoopRun", "simulate_vehicle_loop"]

Array = NDArray[np.float64]

_NO_NOISE = OdometryNoise()


@dataclass(frozen=True, kw_only=True)
class Steering:
    """The outer loop.

    Attributes:
        law: of `thruster_control.outer_loop`; vehicle: coefficients that it believes in.
        allocation: the thesis' pseudo-inverse without limits; largest_thrust: of each thruster [N], both ways.
        kinematic: whether observers are told U = K_t^T nu as measured.
    """

    law: Any
    vehicle: Any
    allocation: AllocationSettings = field(default_factory=lambda: AllocationSettings(method=Method.PSEUDO_INVERSE))
    largest_thrust: float = inf
    kinematic: bool = True


@dataclass(frozen=True, kw_only=True)
class VehicleFeedback:
    """What is measured and fed back.

    Attributes:
        sensors: of the vehicle; periods of those that are there are multiples of the loop's.
        navigation: settings of the filter that makes odometry of them; None: the truth with `noise` is fed back.
        noise: of that odometry.
    """

    sensors: VehicleSensors
    navigation: NavigationSettings | None = None
    noise: OdometryNoise = _NO_NOISE


class VehicleLoopRun(NamedTuple):
    """A run: instants [s] (K,), and its `Record`."""

    time: Array
    record: Record

    def of(self, column: str) -> Array:
        """Return a column of `ESTIMATES` of all thrusters, (K, N)."""
        return np.asarray(self.record.estimates[:, :, ESTIMATES.index(column)])

    def wanted(self) -> VehicleSetPoint:
        """Return the set points, (K, 3) each."""
        return VehicleSetPoint(*(self.record.points[:, i : i + 3] for i in range(0, 15, 3)))  # type: ignore[arg-type]

    def angles(self) -> Array:
        """Return roll, pitch, yaw [rad], (K, 3)."""
        return euler_angles(self.record.attitude)


def simulate_vehicle_loop(
    script: Script,
    true: VehicleSettings,
    steering: Steering,
    inner: Controller,
    feedback: VehicleFeedback,
    *,
    period: float,
    duration: float,
    seed: int = 0,
) -> VehicleLoopRun:
    """Run the loops against the vehicle.

    Args:
        script: set points, from time 0 on.
        true: the vehicle, where it begins, and the plant's largest step.
        steering: outer loop and allocation.
        inner: observer, law and beliefs of each thruster's loop; its first belief is what is measured.
        feedback: what is measured.
        period: of all loops [s]; duration: of the run [s], ticks lie before its end.
        seed: of everything random.

    Raises:
        ValueError: a sensor whose period is no multiple of the loops', or a run without a tick.
    """
    count, thrusters = round(duration / period) - 1, true.count
    if count < 1:
        raise ValueError(f"duration: expected two periods of {period:g} s or more; found {duration:g} s")
    watches = inner.observer if not isinstance(inner.observer, SpeedEkfSettings) else None
    told = _feedback(feedback, count, period, thrusters, seed)
    record = record_of(count, thrusters)
    run_vehicle_loop(
        script,
        _plant(true, period),
        float(period),
        told,
        _outer(steering, thrusters),
        inner_loops_at_rest(thrusters),
        Wiring(1, int(watches is not None), int(isinstance(inner.law, SteadyFlowLaw))),
        inner.observer,
        inner.law,
        inner.coefficients,
        record,
    )
    return VehicleLoopRun(np.asarray(period * np.arange(1, count + 1), dtype=np.float64), record)


def _plant(true: VehicleSettings, period: float) -> Plant:
    out = np.zeros(record_width(true.count))
    steps = true.steps_in(period)
    return Plant(sheet_of(true), out, np.ones(true.count), np.zeros(6), true.tables, steps, period / steps)


def _outer(steering: Steering, thrusters: int) -> Outer:
    limit = np.full(thrusters, float(steering.largest_thrust))
    chosen = allocation(steering.vehicle.K_t, steering.allocation)
    return Outer(
        steering.law, steering.vehicle, chosen, -limit, limit, outer_memory(), allocation_memory(thrusters),
        int(steering.kinematic),
    )  # fmt: skip


def _feedback(given: VehicleFeedback, count: int, period: float, thrusters: int, seed: int) -> Feedback:
    return Feedback(
        int(given.navigation is not None),
        OdometryErrors(given.noise, seed).take(count),
        loop_sensors(given.sensors, seed, thrusters, count, round(1e9 * period)),
        given.navigation or checked_navigation(NavigationSettings()),
    )
