"""The parameters of the plant's node, and the settings that they make."""

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from math import isfinite, radians
from typing import Any, NamedTuple

import numpy as np
from rclpy.node import Node

from rov_sim.vehicle.effects.active import sensing_with
from rov_sim.vehicle.effects.words import effects_of_words
from rov_sim.vehicle.failure_words import parse_failures
from rov_sim.vehicle.live import LiveSettings
from rov_sim.vehicle.noisy_odometry import OdometryNoise
from rov_sim.vehicle.random_wrench import RandomWrench
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.settings import QUANTITIES, VehicleSensors
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle.settings import active_effects, vehicle_settings
from rov_sim.vehicle.truth import at_rest
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set
from thruster_runtime.parameters import Parameter, declare, refused

__all__ = ["PARAMETERS", "PlantNodeSettings", "settings_of"]

PARAMETERS = (
    Parameter(name="vehicle", default="ngs", description="the true vehicle: a vehicle set or YAML file"),
    Parameter(
        name="truth", default="",
        description="the true thrusters: a parameter set or YAML file for all, or one for each, separated by spaces; "
        "empty: those of the vehicle set",
    ),
    Parameter(
        name="effects", default="",
        description="unmodelled effects, besides the set's: EFFECT.PARAMETER=SIZE, EFFECT[T2,axis=x].PARAMETER=SIZE, "
        "separated by spaces",
    ),
    Parameter(name="sensors", default="", description="YAML file of the sensors; empty: those of the package"),
    Parameter(name="noise", default=True, description="whether sensors and odometry are noisy"),
    Parameter(
        name="random_wrench", default="0 0 0 0 0 0", unit="N, N m",
        description="standard deviations of a random wrench on the body, along x, y, z and about them",
    ),
    Parameter(
        name="random_wrench_time", default=3.0, unit="s", lower=0.0, upper=3600.0, description="its correlation time"
    ),
    Parameter(
        name="current", default="0 0 0", unit="m/s", description="of the water, along north, east, down"
    ),
    Parameter(name="position", default="0 0 0", unit="m", description="at first: north, east, down"),
    Parameter(name="attitude_deg", default="0 0 0", unit="deg", description="at first: roll, pitch, yaw"),
    Parameter(name="seed", default=0, lower=0, description="of everything random"),
    Parameter(
        name="rate", default=25.0, unit="Hz", lower=1.0, upper=1000.0,
        description="of throttles and tachometers: all loops' rate",
    ),
    Parameter(
        name="largest_step", default=1e-3, unit="s", lower=0.0, above=True, upper=0.1,
        description="of the integration; it is shortened where an effect needs it",
    ),
    Parameter(
        name="feedback", default="truth", choices=("truth", "estimator"),
        description="whether rov/odometry is the truth with noise from here, or a navigation node's",
    ),
    Parameter(
        name="attitude_noise", default=0.004, unit="rad", lower=0.0, upper=10.0,
        description="feedback truth: standard deviation about each axis",
    ),
    Parameter(
        name="velocity_noise", default=0.008, unit="m/s", lower=0.0, upper=10.0,
        description="feedback truth: standard deviation along each axis",
    ),
    Parameter(
        name="rate_noise", default=0.003, unit="rad/s", lower=0.0, upper=10.0,
        description="feedback truth: standard deviation about each axis",
    ),
    Parameter(
        name="failures", default="",
        description="failures to come, such as 'T2 dead at 12 s; T1 weak 0.5 at 20 s; T3 stuck at 5 s; velocity lost "
        "at 8 s', the last also of imu, depth and battery",
    ),
    Parameter(
        name="report_failures", default=True, description="whether they are told on rov/thruster_failure at once"
    ),
    Parameter(
        name="elsewhere", default="",
        description="thrusters, such as 'T1', that are not simulated: real ones, whose driver tells speed and throttle",
    ),
    Parameter(
        name="lockstep", default=True,
        description="whether time passes when all participants are done, on /clock; false: by the wall's clock",
    ),
    Parameter(
        name="participants", default="rov/setpoint rov/wrench",
        description="topics besides the throttles whose message stamped t ends the period t; in real time those whose "
        "silence stops the thrusters, but for the recorder",
    ),
    Parameter(
        name="wires", default="", description="topics that need a publisher and a subscription before time begins"
    ),
    Parameter(
        name="settle", default=0.5, unit="s", lower=0.0, upper=60.0,
        description="wall time between the last wire's appearance and the beginning",
    ),
    Parameter(
        name="timeout", default=15.0, unit="s", lower=0.0, above=True, upper=3600.0,
        description="in lockstep: wall time after which what is waited for is named on /diagnostics",
    ),
    Parameter(
        name="silence", default=0.12, unit="s", lower=0.0, above=True, upper=10.0,
        description="in real time: wall time without a throttle, or a word of a participant, after which throttles are "
        "zero",
    ),
)  # fmt: skip


class PlantNodeSettings(NamedTuple):
    """What the node is made of; participants and wires are names of topics, times in s of the wall's clock."""

    live: LiveSettings
    from_truth: bool
    report_failures: bool
    elsewhere: frozenset[int]
    lockstep: bool
    participants: tuple[str, ...]
    wires: tuple[str, ...]
    settle: float
    timeout: float
    silence: float


def settings_of(node: Node) -> PlantNodeSettings:
    """Declare the parameters of a node and return the settings they make.

    Raises:
        StartRefused: with a sentence for all that is wrong.
    """
    given = declare(node, PARAMETERS)
    problems: list[str] = []

    def made(make: Callable[[], Any]) -> Any:
        try:
            return make()
        except (ValueError, ThrusterModelError) as error:
            problems.extend(str(error).split("\n"))
            return None

    live = made(lambda: _live(given))
    elsewhere = made(lambda: _indices(given["elsewhere"], live.thrusters)) if live is not None else frozenset()
    if elsewhere and given["lockstep"]:
        problems.append("elsewhere: expected lockstep:=false, as real thrusters do not wait; found lockstep")
    if problems:
        raise refused(node, problems)
    words = {name: tuple(given[name].split()) for name in ("participants", "wires")}
    return PlantNodeSettings(
        live, given["feedback"] == "truth", given["report_failures"], elsewhere, given["lockstep"],
        words["participants"], words["wires"], given["settle"], given["timeout"], given["silence"],
    )  # fmt: skip


def _live(given: Mapping[str, Any]) -> LiveSettings:
    vehicle = load_vehicle_set(given["vehicle"])
    sets = [load_parameter_set(name) for name in given["truth"].split() or vehicle.models]
    sensors = load_sensors(given["sensors"] or None)
    sensors = replace(sensors, tachometer=replace(sensors.tachometer, rate=given["rate"]))
    noise = OdometryNoise(given["attitude_noise"], given["velocity_noise"], given["rate_noise"])
    if not given["noise"]:
        sensors, noise = _quiet(sensors), OdometryNoise()
    added = effects_of_words(given["effects"].split())
    angles = tuple(radians(angle) for angle in _numbers(given, "attitude_deg", 3))
    initial = at_rest(len(vehicle.layout), position=_numbers(given, "position", 3), angles=angles)
    plant = vehicle_settings(vehicle, sets, effects=added, initial=initial, largest_step=given["largest_step"])
    c = plant.coefficients
    plant = replace(plant, coefficients=c._replace(current=c.current + np.array(_numbers(given, "current", 3))))
    effects = (*active_effects(vehicle), *added)
    gravity = vehicle.values["gravity"]
    failures, lost = parse_failures(given["failures"])
    return LiveSettings(
        plant=plant, sensors=sensors, sensed=sensing_with(sensor_coefficients(sensors, gravity), effects), noise=noise,
        period=1.0 / given["rate"], seed=given["seed"], failures=failures, lost=lost,
        wrench=RandomWrench(size=_numbers(given, "random_wrench", 6), time=given["random_wrench_time"]),
    )  # fmt: skip


def _quiet(sensors: VehicleSensors) -> VehicleSensors:
    """Return the sensors without noise, losses and random biases; they still stand where they stand."""
    quiet = {}
    for name in QUANTITIES:
        sensor = getattr(sensors, name)
        nothing = tuple(0.0 for _ in sensor.noise)
        quiet[name] = replace(sensor, noise=nothing, bias_deviation=nothing, lost_share=0.0)
    return replace(sensors, **quiet)


def _numbers(given: Mapping[str, Any], name: str, count: int) -> Any:
    """Return so many numbers as a tuple."""
    try:
        found = tuple(float(word) for word in given[name].replace(",", " ").split())
    except ValueError as error:
        raise ValueError(f"{name}: expected numbers; {error}") from error
    if len(found) != count or not all(map(isfinite, found)):
        raise ValueError(f"{name}: expected {count} finite numbers; found {given[name]!r}")
    return found


def _indices(text: str, count: int) -> frozenset[int]:
    found = set()
    for word in text.replace(",", " ").split():
        if not re.fullmatch(r"T\d+", word) or not 1 <= int(word[1:]) <= count:
            raise ValueError(f"elsewhere: expected thrusters T1 to T{count}; found {word!r}")
        found.add(int(word[1:]) - 1)
    return frozenset(found)
