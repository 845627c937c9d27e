"""The inner loop node's parameters, and the strategy that they ask for."""

from collections.abc import Mapping
from dataclasses import replace
from math import inf, isnan, nan
from typing import Any

from thruster_control.errors import ThrusterControlError
from thruster_control.law_changes import changed_law
from thruster_control.settings import NO_TABLE, Limits, RateForm, TableLaw
from thruster_control.strategies import STRATEGIES, settings_for, strategy
from thruster_control.strategies_io import Ready, load_strategy
from thruster_model.errors import ThrusterModelError
from thruster_runtime.parameters import Parameter

__all__ = ["PARAMETERS", "chosen_strategy", "without_speed"]

_LIMITS = {
    "u_dot_max": ("V/s", "largest rate of the throttle; the parameter set's counts where it is smaller"),
    "oldest_estimate": ("s", "age beyond which an estimate is not used"),
    "longest_hold": ("s", "how long the throttle follows the set point without a usable estimate"),
    "run_down": ("V/s", "how fast the throttle then goes to zero"),
    "idle_thrust": ("N", "the propeller idles from here down, and up to twice this; negative: never"),
    "hysteresis": ("N", "how far the needed thrust passes zero before a propeller in the stream is reversed"),
    "bleed": ("s", "time constant with which the integral is emptied while the propeller idles"),
    "longest_period": ("s", "a longer period is a gap, over which nothing is integrated"),
}
_ABOVE_ZERO = ("u_dot_max", "run_down", "bleed", "longest_period")
_GAINS = {
    "k_P": ("1/s, pi-thrust: rad/s^2 per N", "proportional gain"),
    "k_I": ("1/s^2, pi-thrust: rad/s^3 per N", "integral gain"),
    "rate_time": ("s", "time constant with which the rate of n_d is formed"),
    "largest_rate": ("rad/s^2", "what changes n_d faster is a jump, whose rate is cut"),
    "feed_forward": ("1", "share of the feed-forward of pi-thrust"),
}
_FORMS = {"filtered": RateForm.FILTERED, "bench": RateForm.BENCH, "none": RateForm.NONE}

PARAMETERS = (
    Parameter(name="thruster", default=0, lower=0, upper=99, description="index of the thruster"),
    Parameter(name="strategy", default="hl-ekf", choices=tuple(STRATEGIES), description="control strategy"),
    Parameter(
        name="parameter_set", default="", description="parameter set, by name or YAML file; empty: the strategy's own"
    ),
    Parameter(
        name="period", default=0.04, unit="s", lower=0.0, above=True, upper=10.0,
        description="nominal period, that of the first step",
    ),
    Parameter(
        name="wait_for_setpoint", default=True,
        description="an estimate waits for the set point of its instant, until the next estimate at most; "
        "false where set points come at a rate of their own",
    ),
    Parameter(
        name="setpoint_timeout", default=0.5, unit="s", lower=0.0, above=True, upper=3600.0,
        description="age beyond which a set point counts no more: the throttle runs down",
    ),
    Parameter(name="load_cell", default=False, description="pi-thrust: feed back the load cell's thrust"),
    Parameter(
        name="battery_every", default=0.0, unit="s", lower=0.0, upper=60.0,
        description="force-table: period and delay together of rov/battery, whose voltage then counts; "
        "0: the supply voltage in the thruster's state",
    ),
    Parameter(
        name="measured_timeout", default=0.1, unit="s", lower=0.0, above=True, upper=3600.0,
        description="silence after which a measured flow or load is neither waited for nor used",
    ),
    Parameter(
        name="u_max", default=nan, unit="V", lower=0.0, above=True, unset=True, live=True,
        description="largest throttle; NaN: the strategy's own",
    ),
    *(
        Parameter(
            name=name, default=getattr(Limits(), name), unit=unit, description=words, above=name in _ABOVE_ZERO,
            lower=-inf if name == "idle_thrust" else 0.0, live=True,
        )
        for name, (unit, words) in _LIMITS.items()
    ),
    *(
        Parameter(
            name=name, default=nan, unit=unit, lower=0.0, unset=True, live=True,
            description=f"{words}; NaN: the strategy's own",
        )
        for name, (unit, words) in _GAINS.items()
    ),
    Parameter(
        name="rate_form", default="", choices=("", *_FORMS), live=True,
        description="what stands for the rate of n_d; empty: the strategy's own; bench: a gain of 1 / rate_time",
    ),
)  # fmt: skip


def chosen_strategy(values: Mapping[str, Any]) -> tuple[Ready | None, list[str]]:
    """Return the strategy that the values of `PARAMETERS` ask for, or None and a sentence for each contradiction."""
    changes: dict[str, Any] = {name: values[name] for name in _LIMITS}
    changes |= {name: values[name] for name in ("u_max", *_GAINS) if not isnan(values[name])}
    if values["rate_form"]:
        changes["rate_form"] = int(_FORMS[values["rate_form"]])
    chosen = strategy(values["strategy"])
    own_set = {"parameter_set": values["parameter_set"]} if values["parameter_set"] else {}
    problems = []
    if values["load_cell"] and values["strategy"] != "pi-thrust":
        problems.append(f"load_cell: expected the strategy pi-thrust; found {values['strategy']}")
    if values["battery_every"] > 0.0 and values["strategy"] != "force-table":
        problems.append(f"battery_every: expected the strategy force-table; found {values['strategy']}")
    try:
        ready = load_strategy(chosen.name, law=changed_law(chosen.law, changes), **own_set)
    except (ValueError, ThrusterControlError, ThrusterModelError) as error:
        return None, [*problems, *str(error).split("\n")]
    return (None if problems else ready), problems


def without_speed(ready: Ready) -> Any:
    """Return the law's settings for when its thruster's speed is not measured any more: a table of steady states.

    A strategy that needs no speed stays as it is; one whose parameter set gives no table follows the set point
    without feedback for as long as that lasts.
    """
    if ready.strategy.observer == "none":
        return ready.settings
    limits = ready.settings.limits
    try:
        return settings_for(replace(ready.strategy, law=TableLaw(NO_TABLE, limits)), ready.coefficients)
    except (ValueError, ThrusterControlError):
        return ready.settings._replace(limits=limits._replace(longest_hold=inf))
