"""The allocator node's parameters, and the controller that they ask for."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from thruster_control.allocation.failures import allocation
from thruster_control.allocation.limits import limits_of_sets
from thruster_control.allocation.settings import AllocationSettings, Method
from thruster_control.outer_loop.controller import Controller
from thruster_control.outer_loop.linear import linear_law
from thruster_control.outer_loop.settings import euler_law, pid_law, quaternion_law
from thruster_control.vehicle_loop import VehicleLoop
from thruster_model.errors import ThrusterModelError, VehicleError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set
from thruster_runtime.parameters import Parameter

__all__ = ["PARAMETERS", "chosen_loop"]

LAWS = ("quaternion", "euler", "linear", "pid")
_METHODS = {
    "pseudo-inverse": Method.PSEUDO_INVERSE,
    "direction": Method.DIRECTION,
    "least-squares": Method.LEAST_SQUARES,
}
_DEFAULT = AllocationSettings()

PARAMETERS = (
    Parameter(name="vehicle", default="ngs", description="vehicle set, by name or YAML file"),
    Parameter(
        name="parameter_set", default="",
        description="parameter set of all thrusters, by name or YAML file: what they can give at the present inflow; "
        "empty: the vehicle's own",
    ),
    Parameter(
        name="law", default="quaternion", choices=LAWS,
        description="outer loop: (2.22) with quaternions or Euler angles, that made linear, or a PID for each axis",
    ),
    Parameter(
        name="K_P_linear", default=1.0, unit="1/s", lower=0.0, above=True, upper=100.0, live=True,
        description="proportional gain of surge, sway, heave",
    ),
    Parameter(
        name="K_P_angular", default=2.0, unit="1/s", lower=0.0, above=True, upper=100.0, live=True,
        description="proportional gain of the body's rates",
    ),
    Parameter(
        name="k_I", default=2.0, unit="1/s^2", lower=0.0, upper=100.0, live=True,
        description="gain of the error of attitude",
    ),
    Parameter(
        name="k_integral", default=0.2, unit="1/s^2, 1/s^3", lower=0.0, upper=100.0, live=True,
        description="pid: gain of the integrals of speed and of angle",
    ),
    Parameter(
        name="method", default="least-squares", choices=tuple(_METHODS),
        description="what is done with a wrench beyond the thrusters' limits",
    ),
    Parameter(
        name="moment_weight", default=_DEFAULT.moment_weight, unit="1/m", lower=1e-3, upper=1e3,
        description="least-squares: weight of a newton metre against a newton",
    ),
    Parameter(
        name="smallest_thrust", default=_DEFAULT.smallest_thrust, unit="N", lower=0.0, upper=100.0,
        description="thrusters keep at least this much, away from their dead zones; 0: they need not",
    ),
    Parameter(
        name="hysteresis", default=_DEFAULT.hysteresis, unit="N", lower=0.0, upper=100.0,
        description="how much better another way around a dead zone must be before it is taken",
    ),
    Parameter(
        name="given_up", default="",
        description="axes, separated by commas, whose wrench counts last: where the vehicle is steady by itself",
    ),
    Parameter(name="u_max", default=3.0, unit="V", lower=0.0, above=True, upper=100.0, description="largest throttle"),
    Parameter(
        name="estimated_inflow", default=False,
        description="inflow as the observers estimate it; false: that of the vehicle's own motion",
    ),
    Parameter(
        name="flow", default="kinematic", choices=("kinematic", "none"),
        description="whether observers are told thruster_i/flow: the inflow of the vehicle's own motion",
    ),
    Parameter(
        name="period", default=0.04, unit="s", lower=0.0, above=True, upper=10.0,
        description="nominal period, that of the first step",
    ),
    Parameter(
        name="wait_for_setpoint", default=True,
        description="odometry waits for the set point of its instant, until the next odometry at most",
    ),
    Parameter(
        name="setpoint_timeout", default=0.5, unit="s", lower=0.0, above=True, upper=3600.0,
        description="age beyond which a set point counts no more: no thrust",
    ),
    Parameter(
        name="odometry_timeout", default=0.2, unit="s", lower=0.0, above=True, upper=3600.0,
        description="silence of the odometry after which no thrust is asked for",
    ),
    Parameter(
        name="estimate_timeout", default=0.1, unit="s", lower=0.0, above=True, upper=3600.0,
        description="silence after which an observer's inflow is neither waited for nor used",
    ),
)  # fmt: skip


def chosen_loop(values: Mapping[str, Any]) -> tuple[VehicleLoop | None, list[str]]:
    """Return the loop that the values of `PARAMETERS` ask for, or None and a sentence for each contradiction."""
    problems: list[str] = []
    thrusters: list[Any] = []
    try:
        vehicle_set = load_vehicle_set(values["vehicle"])
        vehicle, models = vehicle_set.coefficients, vehicle_set.models
        if values["parameter_set"]:
            models = (values["parameter_set"],) * len(models)
        found = {name: load_parameter_set(name).coefficients for name in set(models)}
        thrusters = [found[name] for name in models]
    except VehicleError as error:
        problems += [f"vehicle: {line}" for line in str(error).split("\n")]
    except ThrusterModelError as error:
        problems += [f"parameter_set: {line}" for line in str(error).split("\n")]
    axes = tuple(axis.strip() for axis in values["given_up"].split(",") if axis.strip())
    try:
        settings = AllocationSettings(
            method=_METHODS[values["method"]],
            given_up=axes,
            **{name: values[name] for name in ("moment_weight", "smallest_thrust", "hysteresis")},
        )
    except ValueError as error:
        problems.append(str(error))
    if problems:
        return None, problems
    K_t = np.array(vehicle.K_t, dtype=np.float64)
    limits = limits_of_sets(thrusters, values["u_max"])
    most = np.abs(K_t) @ np.maximum(limits.forward, -limits.reverse)[:, limits.forward.shape[1] // 2]
    controller = Controller(_law(values, vehicle, most), vehicle, limits, allocation(K_t, settings))
    return VehicleLoop(controller, settings, values["period"]), []


def _law(values: Mapping[str, Any], vehicle: Any, most: Any) -> Any:
    """Return the law; `most` (6,): the largest wrench of each axis [N, N m]."""
    K_P = 3 * [values["K_P_linear"]] + 3 * [values["K_P_angular"]]
    k_I = values["k_I"]
    if values["law"] == "quaternion":
        return quaternion_law(K_P, k_I)
    if values["law"] == "euler":
        return euler_law(K_P, k_I)
    if values["law"] == "linear":
        return linear_law(vehicle, K_P, k_I)
    inertia = np.diag(vehicle.M_RB + vehicle.M_A)
    proportional = inertia * np.array(K_P[:3] + 3 * [k_I])
    return pid_law(proportional, values["k_integral"] * inertia, inertia[3:] * values["K_P_angular"], most)
