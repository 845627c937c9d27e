"""The observer node's parameters, and the observer that they ask for."""

from collections.abc import Mapping
from math import inf, isnan, nan
from typing import Any, NamedTuple

from thruster_estimation.online import LARGEST_FLOW, LARGEST_SPEED
from thruster_estimation.replay import Job, problem_with
from thruster_estimation.settings import BENCH, OBSERVERS, PERIOD, PROPER, bench_settings, checked
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_runtime.parameters import Parameter

__all__ = ["PARAMETERS", "Chosen", "chosen_observer"]

_OWN = "NaN: the bench's"


def _own(name: str, unit: str, description: str, *, above: bool = False, lower: float = 0.0, **more: Any) -> Parameter:
    words = f"{description}; {_OWN}"
    return Parameter(
        name=name, default=nan, unit=unit, description=words, unset=True, lower=lower, above=above, live=True,
        **more,
    )  # fmt: skip


_SETTINGS = (
    _own("q_n", "rad^2/s^3", "density of the process noise of n"),
    _own("q_v", "m^2/s^3", "density of the process noise of v"),
    _own("q_U", "m^2/s^3", "density of the process noise of U"),
    _own("gate", "1", "largest NIS of a measurement that is used, chi-square of one degree", above=True, infinite=True),
    _own("largest_innovation", "m/s", "largest innovation of U that the NLO uses", above=True, infinite=True),
    _own("patience", "s", "refusals in a row after which a measurement is used all the same", above=True),
    _own("stale", "s", "time without a used measurement after which the estimate is invalid", above=True),
    _own("largest_n", "rad/s", "ceiling of the deviation of n", above=True),
    _own("largest_v", "m/s", "ceiling of the deviation of v", above=True),
    _own("largest_U", "m/s", "ceiling of the deviation of U", above=True),
    _own("unknown_drive", "rad/s^2", "deviation of the drive while the throttle is not known"),
    _own("largest_step", "s", "upper bound of the integration's steps", above=True),
    _own("k_11", "1/s", "linear gain of v", lower=-inf),
    _own("k_12", "1", "gain of v per rotor speed", lower=-inf),
    _own("k_21", "1/s", "linear gain of U", lower=-inf),
    _own("k_22", "1", "gain of U per rotor speed", lower=-inf),
)
_NOISE = (
    _own("speed_noise", "rad/s", "standard deviation of a measured speed", above=True),
    _own("flow_noise", "m/s", "standard deviation of a measured ambient flow", above=True),
)
PARAMETERS = (
    Parameter(name="thruster", default=0, lower=0, upper=99, description="index of the thruster"),
    Parameter(name="estimator", default="ekf", choices=tuple(OBSERVERS), description="observer"),
    Parameter(name="parameter_set", default="hl", description="parameter set, by name or YAML file"),
    Parameter(
        name="form", default="proper", choices=("proper", "bench"),
        description="properly discretised, or Euler one period behind as the bench ran it",
    ),
    Parameter(
        name="period", default=PERIOD, unit="s", lower=0.0, above=True, upper=10.0,
        description="nominal period, at which the bench's noise densities become variances of one sample",
    ),
    Parameter(
        name="throttle", default="commanded", choices=("commanded", "sent"),
        description="which throttle acts: throttle.commanded, or throttle_sent.sent after the device's quantisation",
    ),
    Parameter(
        name="wait_for_throttle", default=True,
        description="a state waits for the throttle that acted since the former one, until the next state at most",
    ),
    Parameter(
        name="throttle_timeout", default=0.5, unit="s", lower=0.0, above=True, upper=3600.0,
        description="silence after which the throttle is not known and not waited for",
    ),
    Parameter(
        name="wait_for_flow", default=True,
        description="a state waits for the ambient flow of its instant, until the next state at most",
    ),
    Parameter(
        name="flow_timeout", default=0.5, unit="s", lower=0.0, above=True, upper=3600.0,
        description="silence after which the ambient flow is not waited for",
    ),
    Parameter(
        name="largest_speed", default=LARGEST_SPEED, unit="rad/s", lower=0.0, above=True, live=True,
        description="a speed measured beyond is none that a thruster has: refused and counted",
    ),
    Parameter(
        name="largest_flow", default=LARGEST_FLOW, unit="m/s", lower=0.0, above=True, live=True,
        description="an ambient flow measured beyond is none that a thruster meets: refused and counted",
    ),
    *_NOISE,
    *_SETTINGS,
)  # fmt: skip


class Chosen(NamedTuple):
    """Settings of an observer and the coefficients that it believes in."""

    settings: Any
    coefficients: Any


def chosen_observer(values: Mapping[str, Any]) -> tuple[Chosen | None, list[str]]:
    """Return the observer that the values of `PARAMETERS` ask for, or None and a sentence for each contradiction."""
    try:
        p = load_parameter_set(values["parameter_set"]).coefficients
    except ThrusterModelError as error:
        return None, [f"parameter_set: {error}"]
    form, name = BENCH if values["form"] == "bench" else PROPER, values["estimator"]
    settings = bench_settings(name, form=form, k_U=p.k_U, dt=values["period"])
    changes = {each.name: values[each.name] for each in _SETTINGS if not isnan(values[each.name])}
    for noise, field in (("speed_noise", "r_n"), ("flow_noise", "r_U")):
        if not isnan(values[noise]):
            changes[field] = values[noise] ** 2
    problems = [
        f"{key}: expected a setting of {name}; found one that it does not have"
        for key in changes
        if key not in settings._fields
    ]
    if problem := problem_with(Job(name, values["parameter_set"], settings, p)):
        problems.append(f"parameter_set: {problem}")
    if problems:
        return None, problems
    try:
        return Chosen(checked(settings._replace(**changes)), p), []
    except ValueError as error:
        return None, [str(error)]
