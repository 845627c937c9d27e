"""Settings of the inner loops: one class for each law, which decides on the equations when a kernel is compiled.

All are tuples of floats, so that kernels take them as they are; `checked` says what is wrong with one.

Gains: k_P = 5 1/s, k_I = 10 1/s^2 are the rig's. Its dn_d/dt = (n_d - n) / 0.04 s is `RateForm.BENCH`: no derivative,
but 25 1/s on top of k_P, which the loop's own delay makes unstable.
"""

from enum import IntEnum
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.command_scale import FULL_THROTTLE

__all__ = [
    "BENCH_GAINS",
    "NO_TABLE",
    "FlowLaw",
    "ForceTableLaw",
    "Gains",
    "Limits",
    "RateForm",
    "SimplifiedLaw",
    "SteadyFlowLaw",
    "TableLaw",
    "ThrustLaw",
    "checked",
]


class RateForm(IntEnum):
    """What stands for dn_d/dt."""

    FILTERED = 0
    """Backward difference of n_d through a first-order lag of `rate_time`."""
    BENCH = 1
    """(n_d - n) / rate_time, the rig's with 0.04 s."""
    NONE = 2
    """Zero."""


class Limits(NamedTuple):
    """What holds for every law.

    u_max [V] and u_dot_max [V/s]: of the throttle; the smaller of this rate and the parameter set's counts.
    oldest_estimate [s]: an estimate that is older is not used.
    longest_hold [s]: how long the throttle follows the set point without a usable estimate.
    run_down [V/s]: how fast the throttle then goes to zero.
    idle_thrust [N]: the propeller idles from |T_d| <= idle_thrust until |T_d| > 2 idle_thrust; negative: never.
    hysteresis [N]: how far the needed thrust must pass zero before a propeller that turns with the stream is reversed.
    bleed [s]: time constant with which the integral is emptied while the propeller idles or runs down.
    longest_period [s]: a longer dt is a gap, over which nothing is integrated.
    """

    u_max: float = 3.0
    u_dot_max: float = 100.0
    oldest_estimate: float = 0.1
    longest_hold: float = 0.5
    run_down: float = 10.0
    idle_thrust: float = 0.02
    hysteresis: float = 0.1
    bleed: float = 0.5
    longest_period: float = 0.5


class Gains(NamedTuple):
    """Of the speed loops: k_P [1/s], k_I [1/s^2], how dn_d/dt is formed and with which time constant [s].

    `largest_rate` [rad/s^2]: what changes n_d faster than that is a jump, which no rotor follows: the filtered rate
    of a jump would push the rotor past n_d once the throttle leaves its limit.
    `on_estimate` 1: the feed-forward takes the measured speed as in (3.13); 0: the desired one as in (4.25).
    """

    k_P: float = 5.0
    k_I: float = 10.0
    rate_form: int = int(RateForm.FILTERED)
    rate_time: float = 0.1
    largest_rate: float = 400.0
    on_estimate: int = 0


BENCH_GAINS = Gains(rate_form=int(RateForm.BENCH), rate_time=0.04)
"""As the rig ran."""

NO_TABLE: NDArray[np.float64] = np.empty((3, 0))


class TableLaw(NamedTuple):
    """Open loop: throttle from a table of steady states, without any estimate.

    `table` (3, K): throttle [V], thrust [N], speed [rad/s], each ascending, with the two edges of the dead zone as
    neighbouring nodes of zero thrust and speed (`steady_table`). `by_thrust` 1: throttle over thrust; 0: speed by
    (3.6), throttle over speed.
    """

    table: NDArray[np.float64]
    limits: Limits = Limits()
    by_thrust: int = 1


class ForceTableLaw(NamedTuple):
    """Open loop: throttle from the parameter set's table of force, at the supply voltage of the moment."""

    limits: Limits = Limits(u_max=FULL_THROTTLE)


class SimplifiedLaw(NamedTuple):
    """Speed loop with the simplified map: n_d by (3.6), throttle by (4.24)-(4.26), or (3.12) with `on_estimate`."""

    gains: Gains = Gains()
    limits: Limits = Limits()


class FlowLaw(NamedTuple):
    """Output feedback with HL or HQ: n_d by (4.22) or (4.23) with the observer's axial flow, (4.24)-(4.26).

    `as_printed` 1: n_d exactly as (4.22), (4.23) print it, without hysteresis, for reproducing the bench.
    """

    gains: Gains = Gains()
    limits: Limits = Limits()
    as_printed: int = 0


class SteadyFlowLaw(NamedTuple):
    """Kim and Chung's steady flow: n_d and v = k_s U cos(a) + k_r n_d solved together, (4.24)-(4.26)."""

    gains: Gains = Gains()
    limits: Limits = Limits()


class ThrustLaw(NamedTuple):
    """PI loop on thrust: k_P [rad/s^2 per N], k_I [rad/s^3 per N], share of the feed-forward of (3.6) (0 to 1)."""

    k_P: float = 10.0
    k_I: float = 100.0
    feed_forward: float = 1.0
    limits: Limits = Limits()


def checked(settings: Any) -> Any:
    """Return the settings; ValueError with all that is wrong with them."""
    limits, wrong = settings.limits, []
    for name in ("u_max", "u_dot_max", "run_down", "bleed", "longest_period"):
        if not 0.0 < getattr(limits, name) < inf:
            wrong.append(f"{name}: expected a finite number above 0; found {getattr(limits, name)}")
    for name in ("oldest_estimate", "longest_hold", "hysteresis"):
        if not 0.0 <= getattr(limits, name) < inf:
            wrong.append(f"{name}: expected a finite number, 0 or more; found {getattr(limits, name)}")
    if not isfinite(limits.idle_thrust):
        wrong.append(f"idle_thrust: expected a finite number; found {limits.idle_thrust}")
    gains = getattr(settings, "gains", settings)
    for name in ("k_P", "k_I", "rate_time", "largest_rate"):
        value = getattr(gains, name, 0.0)
        if not 0.0 <= value < inf:
            wrong.append(f"{name}: expected a finite number, 0 or more; found {value}")
    if isinstance(gains, Gains):
        if gains.rate_form not in list(RateForm):
            wrong.append(f"rate_form: expected one of {[*map(int, RateForm)]}; found {gains.rate_form}")
        if gains.rate_form == RateForm.BENCH and gains.rate_time == 0.0:
            wrong.append("rate_time: expected more than 0 s with the bench's form; found 0")
    if isinstance(settings, ThrustLaw) and not 0.0 <= settings.feed_forward <= 1.0:
        wrong.append(f"feed_forward: expected a share from 0 to 1; found {settings.feed_forward}")
    if isinstance(settings, TableLaw):
        wrong += _table_problems(settings.table)
    if wrong:
        raise ValueError(f"{type(settings).__name__}: " + "; ".join(wrong))
    return settings


def _table_problems(table: NDArray[np.float64]) -> list[str]:
    if table.ndim != 2 or table.shape[0] != 3 or table.shape[1] < 4 or not np.all(np.isfinite(table)):
        return [f"table: expected finite numbers of shape (3, K), K >= 4; found shape {table.shape}"]
    edges = np.flatnonzero((table[1] == 0.0) & (table[2] == 0.0))
    if edges.size != 2 or edges[1] != edges[0] + 1:
        return [f"table: expected two neighbouring nodes without thrust and speed; found {edges.size} such nodes"]
    falls = np.any(np.diff(table) < 0.0, axis=1) | np.any(np.diff(np.delete(table, edges[0], axis=1)) <= 0.0, axis=1)
    names = ("throttle", "thrust", "speed")
    return [f"table: expected ascending {names[i]}; found a fall or a repeated node" for i in np.flatnonzero(falls)]
