"""What a case makes of its assumptions: the true vehicle of a seed, outer loop, feedback."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import exp

import numpy as np

from rov_sim.bench_study.plants import drawn_plant
from rov_sim.vehicle.loop import Steering, VehicleFeedback
from rov_sim.vehicle.noisy_odometry import OdometryNoise
from rov_sim.vehicle.plant import VehicleSettings
from rov_sim.vehicle.sensors.believed import navigation_settings
from rov_sim.vehicle.sensors.settings import Sensor, VehicleSensors
from rov_sim.vehicle_study.assumptions import Assumptions
from thruster_control.outer_loop.settings import euler_law, quaternion_law
from thruster_model.parameter_set import Parameter, ParameterSet
from thruster_model.vehicle_coefficients import VehicleCoefficients
from thruster_model.vehicle_set import VehicleSet

__all__ = ["Sets", "drawn_vehicle", "feedback_of", "known_vehicle", "sensors_of", "steering_of"]

_SLOW = 5.0  # Hz, of velocity log and depth sensor: whole periods of 25 and of 100 Hz
_HULL = ("M_RB", "M_A", "D_L", "D_Q", "weight", "buoyancy", "r_G", "r_B")
_DRAWN = ("I_", "A_", "L_", "Q_")


@dataclass(frozen=True, kw_only=True)
class Sets:
    """All sets that a study names: vehicle sets, parameter sets of thrusters, by name; the sensors."""

    vehicles: Mapping[str, VehicleSet]
    thrusters: Mapping[str, ParameterSet]
    sensors: VehicleSensors


def known_vehicle(given: Assumptions, sets: Sets) -> VehicleCoefficients:
    """Return the vehicle without deviations, as controllers know it: no current."""
    return _combined(given, sets, sets.vehicles[given.hull or given.vehicle])


def _combined(given: Assumptions, sets: Sets, hull: VehicleSet) -> VehicleCoefficients:
    """Return the places of the thrusters with a hull."""
    c = sets.vehicles[given.layout or given.vehicle].coefficients
    return c._replace(**{name: getattr(hull.coefficients, name) for name in _HULL})


def drawn_vehicle(given: Assumptions, sets: Sets, seed: tuple[int, int]) -> VehicleSettings:
    """Return the true vehicle of a seed: each thruster's parameters and the hull's times factors of their own.

    Of the hull, inertia, added mass and drag are drawn; mass, buoyancy and places are what a scale, the trim and a rule
    tell. A deviation that a set states counts instead of the case's, as for thrusters.
    """
    truth, hull = sets.thrusters[given.truth], sets.vehicles[given.hull or given.vehicle]
    rng = np.random.default_rng((*seed, 0))
    drawn = {name: _factor(p, given.deviation, rng) for name, p in hull.parameters.items() if name.startswith(_DRAWN)}
    values = {name: factor * hull.parameters[name].value for name, factor in drawn.items()}
    c = _combined(given, sets, hull.with_values(values, source="drawn"))
    thrusters = tuple(drawn_plant(truth, given.deviation, rng).coefficients for _ in range(c.K_t.shape[1]))
    c = c._replace(current=np.array([given.current_north, given.current_east, 0.0]))
    return VehicleSettings(coefficients=c, thrusters=thrusters, largest_step=given.largest_step)


def _factor(parameter: Parameter, deviation: float, rng: np.random.Generator) -> float:
    draw, stated, value = float(rng.standard_normal()), parameter.standard_deviation, parameter.value
    share = deviation if stated is None or value == 0.0 else abs(stated / value)
    return exp(share * draw) if deviation > 0.0 else 1.0


def steering_of(given: Assumptions, sets: Sets) -> Steering:
    """Return the outer loop, which knows the vehicle without deviations and no current."""
    law = (euler_law if given.attitude_error == "euler" else quaternion_law)(given.gain, given.gain)
    return Steering(law=law, vehicle=known_vehicle(given, sets), kinematic=given.inflow == "kinematic")


def sensors_of(given: Assumptions, sensors: VehicleSensors) -> VehicleSensors:
    """Return the sensors of a case: IMU and tachometers read each period, the others at 5 Hz; no battery."""
    quiet = given.feedback == "exact"
    imu = replace(
        _at(sensors.imu, given.rate),
        noise=(given.attitude_noise,) * 3 + (given.rate_noise,) * 3 + sensors.imu.noise[6:],
    )
    tachometer = replace(_at(sensors.tachometer, given.rate), noise=(0.0 if quiet else given.speed_noise,))
    velocity = replace(_at(sensors.velocity, _SLOW), noise=(given.velocity_noise,) * 3)
    battery = replace(sensors.battery, rate=0.0)
    depth = _at(sensors.depth, _SLOW)
    return replace(sensors, imu=imu, tachometer=tachometer, velocity=velocity, depth=depth, battery=battery)


def feedback_of(given: Assumptions, sets: Sets) -> VehicleFeedback:
    """Return what is measured and fed back."""
    sensors = sensors_of(given, sets.sensors)
    if given.feedback == "estimator":
        return VehicleFeedback(sensors=sensors, navigation=navigation_settings(sensors))
    if given.feedback == "exact":
        return VehicleFeedback(sensors=sensors)
    noise = OdometryNoise(given.attitude_noise, given.velocity_noise, given.rate_noise)
    return VehicleFeedback(sensors=sensors, noise=noise)


def _at(sensor: Sensor, rate: float) -> Sensor:
    return replace(sensor, rate=rate, phase=0.0, delay=0.0)
