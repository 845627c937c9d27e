r"""What each law demands: u, alpha, n_d, and the error that its integral collects.

(4.24)  u = gamma^-1(alpha)                                                            [V]
(4.25)  alpha = dn_d/dt + k_n n_d + k_Q Q(n_d, v) - k_P (n - n_d) - k_I sigma          [rad/s^2]
(4.26)  dsigma/dt = n - n_d                                                            [rad/s]
(3.13)  the same with n in the place of n_d in the feed-forward

PI on thrust:  alpha = share (k_n n_d + k_Q Q(n_d, 0)) - k_P (T - T_d) - k_I sigma,   dsigma/dt = T - T_d,
n_d by (3.6). T is the load cell's where there is one, else the map's T(n, v) at the estimates: such a loop holds the
estimated thrust, and no error of the map is seen by it.

A maker's table of force is looked up backwards at the present supply voltage: the command nearest the stop that gives
T_d, without any estimate.

Where the law has no usable estimate (`feedback` false), what is left is the feed-forward with the last flow, and the
integral as it stands.

Law and parameters go together by class; a law's class is the type of its settings.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numba.extending import overload

from thruster_control.settings import (
    FlowLaw,
    ForceTableLaw,
    RateForm,
    SimplifiedLaw,
    SteadyFlowLaw,
    TableLaw,
    ThrustLaw,
)
from thruster_control.wanted_speed import side_for_thrust, speed_on_side
from thruster_model.compilation import equation
from thruster_model.equations.classes import axial_flow
from thruster_model.equations.force_map import drive_for_force, static_speed
from thruster_model.equations.inflow import steady_axial_flow
from thruster_model.equations.inversion import speed_for_thrust_as_printed
from thruster_model.equations.thruster import input_map, input_map_inverse, rotor_acceleration, thrust, torque

__all__ = ["Demand", "demand", "usable"]

Equation = Callable[..., Any]
_BENCH = int(RateForm.BENCH)
_NONE = int(RateForm.NONE)


class Demand(NamedTuple):
    """Throttle before all limits [V], alpha [rad/s^2], n_d [rad/s], its rate [rad/s^2], side, error of the integral."""

    u: float
    alpha: float
    n_d: float
    n_d_rate: float
    side: float
    error: float


@equation
def _filtered_rate(memory, n_d, dt, gains):  # type: ignore[no-untyped-def]
    """Return the lagged backward difference of n_d [rad/s^2], a jump cut to `largest_rate`; 0 without a former n_d."""
    if not math.isfinite(memory.n_d):
        return 0.0
    difference = min(max((n_d - memory.n_d) / dt, -gains.largest_rate), gains.largest_rate)
    if gains.rate_time <= 0.0:
        return difference
    return memory.n_d_rate - math.expm1(-dt / gains.rate_time) * (difference - memory.n_d_rate)


@equation
def _losses(n, v, p):  # type: ignore[no-untyped-def]
    """Return k_n n + k_Q Q(n, v) [rad/s^2], what the rotor loses without drive."""
    return -rotor_acceleration(n, torque(n, v, p), 0.0, p)


@equation
def _speed_demand(memory, n_d, side, v, n, feedback, dt, gains, p):  # type: ignore[no-untyped-def]
    """Return the demand of (4.24)-(4.26) for n_d [rad/s] at the axial flow v [m/s]."""
    error, rate, n_d_rate, n_forward = 0.0, 0.0, 0.0, n_d
    if gains.rate_form != _BENCH and gains.rate_form != _NONE:
        n_d_rate = _filtered_rate(memory, n_d, dt, gains)
        rate = n_d_rate
    if feedback:
        error = n - n_d
        if gains.rate_form == _BENCH:
            rate = -error / gains.rate_time
        if gains.on_estimate != 0:
            n_forward = n
    wanted = rate + _losses(n_forward, v, p) - gains.k_P * error - gains.k_I * memory.sigma
    alpha = wanted / p.drive_gain
    return Demand(input_map_inverse(alpha, p), alpha, n_d, n_d_rate, side, error)


@equation
def _simplified(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    side = side_for_thrust(T_d, 0.0, 0.0, 0.0, 0.0, p)
    n_d = speed_on_side(T_d, 0.0, 0.0, side, p)
    return _speed_demand(memory, n_d, side, 0.0, n, feedback, dt, settings.gains, p)


@equation
def _output_feedback(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    if settings.as_printed != 0:
        side = side_for_thrust(T_d, 0.0, 0.0, 0.0, 0.0, p)
        n_d = speed_for_thrust_as_printed(T_d, v, p.c_T2, p.c_nv_T, p.c_v_T)
    else:
        side = side_for_thrust(T_d, v, 0.0, memory.side, settings.limits.hysteresis, p)
        n_d = speed_on_side(T_d, v, 0.0, side, p)
    return _speed_demand(memory, n_d, side, v, n, feedback, dt, settings.gains, p)


@equation
def _steady_flow(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    v_0 = steady_axial_flow(0.0, U, p.k_s, p.k_r, p.inflow_angle)
    side = side_for_thrust(T_d, v_0, p.k_r, memory.side, settings.limits.hysteresis, p)
    n_d = speed_on_side(T_d, v_0, p.k_r, side, p)
    v_d = steady_axial_flow(n_d, U, p.k_s, p.k_r, p.inflow_angle)
    return _speed_demand(memory, n_d, side, v_d, n, feedback, dt, settings.gains, p)


@equation
def _fed_back_thrust(n, v, U, T, p):  # type: ignore[no-untyped-def]
    """Return the measured thrust or, where it is NaN, the map's at the estimates; a map without flow needs none."""
    if math.isfinite(T):
        return T
    if p.c_nv_T == 0.0 and p.c_v_T == 0.0:
        return thrust(n, 0.0, p)
    return thrust(n, axial_flow(n, v, U, p), p)


@equation
def _thrust_loop(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    side = side_for_thrust(T_d, 0.0, 0.0, 0.0, 0.0, p)
    n_d = speed_on_side(T_d, 0.0, 0.0, side, p)
    error = _fed_back_thrust(n, v, U, T, p) - T_d if feedback else 0.0
    wanted = settings.feed_forward * _losses(n_d, 0.0, p) - settings.k_P * error - settings.k_I * memory.sigma
    alpha = wanted / p.drive_gain
    return Demand(input_map_inverse(alpha, p), alpha, n_d, 0.0, side, error)


@equation
def _looked_up(x, over, wanted, side, table):  # type: ignore[no-untyped-def]
    """Return row `wanted` of the table where row `over` is x, on the side of the dead zone; its end beyond its end."""
    last = table.shape[1] - 1
    if side > 0.0:
        k = last - 1
        while k > 0 and table[over, k] > x:
            k -= 1
    else:
        k = 0
        while k < last - 1 and table[over, k + 1] < x:
            k += 1
    share = (x - table[over, k]) / (table[over, k + 1] - table[over, k])
    share = min(max(share, 0.0), 1.0)
    return table[wanted, k] + share * (table[wanted, k + 1] - table[wanted, k])


@equation
def _table(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    side = side_for_thrust(T_d, 0.0, 0.0, 0.0, 0.0, p)
    if settings.by_thrust != 0:
        n_d = _looked_up(T_d, 1, 2, side, settings.table)
        u = _looked_up(T_d, 1, 0, side, settings.table)
    else:
        n_d = speed_on_side(T_d, 0.0, 0.0, side, p)
        u = _looked_up(n_d, 2, 0, side, settings.table)
    return Demand(u, input_map(u, p), n_d, 0.0, side, 0.0)


@equation
def _force_table(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    volts = supply * p.nominal_supply
    drive = drive_for_force(T_d / p.thrust_scale, volts, p)
    return Demand(input_map_inverse(drive, p), drive, static_speed(drive, volts, p), 0.0, np.sign(T_d), 0.0)


@equation
def _needs_nothing(n, v, U, T, valid, p):  # type: ignore[no-untyped-def]
    return True


@equation
def _needs_speed(n, v, U, T, valid, p):  # type: ignore[no-untyped-def]
    return valid and math.isfinite(n)


@equation
def _needs_flow(n, v, U, T, valid, p):  # type: ignore[no-untyped-def]
    return valid and math.isfinite(n) and math.isfinite(v)


@equation
def _needs_ambient(n, v, U, T, valid, p):  # type: ignore[no-untyped-def]
    return valid and math.isfinite(n) and math.isfinite(U)


@equation
def _needs_thrust(n, v, U, T, valid, p):  # type: ignore[no-untyped-def]
    return math.isfinite(T) or (valid and math.isfinite(_fed_back_thrust(n, v, U, T, p)))


_LAWS: dict[type, tuple[Equation, Equation]] = {
    TableLaw: (_table, _needs_nothing),
    ForceTableLaw: (_force_table, _needs_nothing),
    SimplifiedLaw: (_simplified, _needs_speed),
    FlowLaw: (_output_feedback, _needs_flow),
    SteadyFlowLaw: (_steady_flow, _needs_ambient),
    ThrustLaw: (_thrust_loop, _needs_thrust),
}


def demand(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    """Return the `Demand` of the law of `settings` for T_d [N], which is not zero; `supply`: relative voltage."""
    return _LAWS[type(settings)][0](memory, T_d, n, v, U, T, supply, feedback, dt, settings, p)


def usable(n, v, U, T, valid, settings, p):  # type: ignore[no-untyped-def]
    """Return whether the law has what it feeds back: each needs other estimates, a table none."""
    return _LAWS[type(settings)][1](n, v, U, T, valid, p)


@overload(demand, inline="always")
def _compile_demand(memory, T_d, n, v, U, T, supply, feedback, dt, settings, p):  # type: ignore[no-untyped-def]
    chosen = _LAWS[settings.instance_class][0]
    return lambda memory, T_d, n, v, U, T, supply, feedback, dt, settings, p: chosen(
        memory, T_d, n, v, U, T, supply, feedback, dt, settings, p
    )


@overload(usable, inline="always")
def _compile_usable(n, v, U, T, valid, settings, p):  # type: ignore[no-untyped-def]
    chosen = _LAWS[settings.instance_class][1]
    return lambda n, v, U, T, valid, settings, p: chosen(n, v, U, T, valid, p)
