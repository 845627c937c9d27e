"""Classes of thrusters: which equation each uses for supply, loads, rotor and axial flow.

All classes share the pipeline of `thruster_model.pipeline`. Where they differ, the class of the coefficients decides,
when a kernel is compiled: a class that is not used costs nothing.
"""

from collections import namedtuple
from collections.abc import Callable
from typing import Any

import numpy as np
from numba.extending import overload

from thruster_model.compilation import equation
from thruster_model.equations.airfoil import airfoil_loads
from thruster_model.equations.force_map import force_at_speed, static_speed
from thruster_model.equations.four_quadrant import four_quadrant_load
from thruster_model.equations.inflow import relative_axial_acceleration, steady_axial_flow
from thruster_model.equations.thruster import (
    ThrusterCoefficients,
    axial_acceleration,
    rotor_acceleration,
    thrust,
    torque,
)

__all__ = [
    "AirfoilCoefficients",
    "AmbientInflowCoefficients",
    "ForceTableCoefficients",
    "RelativeFlowCoefficients",
    "StaticCoefficients",
    "SteadyFlowCoefficients",
    "TableCoefficients",
    "axial_flow",
    "axial_rate",
    "loads",
    "powered",
    "rotor_rate",
    "rotor_speed",
]

Equation = Callable[..., Any]


def _class(name: str, *extra: str) -> Any:
    """Return a class of coefficients: the common ones (with their defaults) and `extra` ones (zero by default)."""
    common = ThrusterCoefficients._fields
    defaults = [ThrusterCoefficients._field_defaults.get(field, 0.0) for field in common]
    return namedtuple(name, (*common, *extra), defaults=[*defaults, *(0.0 for _ in extra)], module=__name__)


# v = k_s U cos(a) + k_r n (Kim and Chung)
SteadyFlowCoefficients = _class("SteadyFlowCoefficients", "k_s", "k_r", "inflow_angle")
# (4.2)
RelativeFlowCoefficients = _class("RelativeFlowCoefficients", "k_4", "k_5")
# (4.6)-(4.11)
AirfoilCoefficients = _class("AirfoilCoefficients", "radius", "density", "pitch", "lift", "drag")
# four quadrants over the ambient flow
AmbientInflowCoefficients = _class(
    "AmbientInflowCoefficients", "radius", "a1_T", "b1_T", "a3_T", "b3_T", "a1_Q", "b1_Q", "a3_Q", "b3_Q"
)
# a rotor without inertia
StaticCoefficients = _class("StaticCoefficients")
# `table` (4, K): throttle [V] ascending, rotor speed [rad/s], thrust [N], torque [N m]; columns are its nodes
TableCoefficients = _class("TableCoefficients", "table")
# a maker's table over command and supply voltage, behind a lag: `force_map`
ForceTableCoefficients = _class("ForceTableCoefficients", "nominal_supply", "thrust_scale", "supplies", "curves")


# ---- the drive as the supply leaves it; supply: its voltage over the nominal one


@equation
def _times_supply(drive, supply, p):  # type: ignore[no-untyped-def]
    return supply * drive


@equation
def _as_commanded(drive, supply, p):  # type: ignore[no-untyped-def]
    return drive


# ---- loads: (T [N], Q [N m]) over rotor speed, axial flow, acting throttle and relative supply


@equation
def _map_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    return thrust(n, v, p), torque(n, v, p)


@equation
def _airfoil_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    return airfoil_loads(n, v, p.radius, p.pitch, p.lift, p.drag, p.density)


@equation
def _four_quadrant_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    force = four_quadrant_load(n, v, p.radius, p.a1_T, p.b1_T, p.a3_T, p.b3_T)
    return force, four_quadrant_load(n, v, p.radius, p.a1_Q, p.b1_Q, p.a3_Q, p.b3_Q)


@equation
def _at_node(u, row, table):  # type: ignore[no-untyped-def]
    """Return a row of the table at the throttle u, linear between nodes; beyond the table its end nodes hold."""
    value = table[row, 0] + 0.0 * u
    for k in range(table.shape[1] - 1):
        share = (u - table[0, k]) / (table[0, k + 1] - table[0, k])
        value = value + np.minimum(np.maximum(share, 0.0), 1.0) * (table[row, k + 1] - table[row, k])
    return value


@equation
def _table_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    return _at_node(u, 2, p.table), _at_node(u, 3, p.table)


@equation
def _force_table_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    force = p.thrust_scale * force_at_speed(n, supply * p.nominal_supply, p)
    return force, 0.0 * force


# ---- rotor speed [rad/s] over the state n and the acting throttle, and the rate of that state


@equation
def _state_speed(n, drive, u, p):  # type: ignore[no-untyped-def]
    return n


@equation
def _static_speed(n, drive, u, p):  # type: ignore[no-untyped-def]
    return drive / p.k_n


@equation
def _table_speed(n, drive, u, p):  # type: ignore[no-untyped-def]
    return _at_node(u, 1, p.table)


@equation
def _no_rotor_rate(n, moment, drive, supply, p):  # type: ignore[no-untyped-def]
    return 0.0 * n


@equation
def _turned(n, moment, drive, supply, p):  # type: ignore[no-untyped-def]
    return rotor_acceleration(n, moment, drive, p)


@equation
def _to_static_speed(n, moment, drive, supply, p):  # type: ignore[no-untyped-def]
    return p.drive_gain * static_speed(drive, supply * p.nominal_supply, p) - p.k_n * n


# ---- axial flow [m/s] over rotor speed, the state v and the ambient flow, and the rate of that state


@equation
def _state_flow(n, v, ambient, p):  # type: ignore[no-untyped-def]
    return v


@equation
def _steady_flow(n, v, ambient, p):  # type: ignore[no-untyped-def]
    return steady_axial_flow(n, ambient, p.k_s, p.k_r, p.inflow_angle)


@equation
def _ambient_flow(n, v, ambient, p):  # type: ignore[no-untyped-def]
    return ambient


@equation
def _relative_rate(v, ambient, force, p):  # type: ignore[no-untyped-def]
    return relative_axial_acceleration(v, ambient, force, p.k_4, p.k_5)


@equation
def _no_axial_rate(v, ambient, force, p):  # type: ignore[no-untyped-def]
    return 0.0 * v


_THESIS: dict[str, Equation] = {
    "powered": _times_supply,
    "loads": _map_loads,
    "speed": _state_speed,
    "rotor_rate": _turned,
    "flow": _state_flow,
    "axial_rate": axial_acceleration,
}
_STATIC: dict[str, Equation] = {"rotor_rate": _no_rotor_rate, "axial_rate": _no_axial_rate}
_EQUATIONS: dict[type, dict[str, Equation]] = {
    ThrusterCoefficients: _THESIS,
    SteadyFlowCoefficients: {**_THESIS, "flow": _steady_flow, "axial_rate": _no_axial_rate},
    RelativeFlowCoefficients: {**_THESIS, "axial_rate": _relative_rate},
    AirfoilCoefficients: {**_THESIS, "loads": _airfoil_loads},
    AmbientInflowCoefficients: {
        **_THESIS,
        "loads": _four_quadrant_loads,
        "flow": _ambient_flow,
        "axial_rate": _no_axial_rate,
    },
    StaticCoefficients: {**_THESIS, **_STATIC, "speed": _static_speed},
    TableCoefficients: {**_THESIS, **_STATIC, "loads": _table_loads, "speed": _table_speed},
    ForceTableCoefficients: {
        **_THESIS,
        "powered": _as_commanded,
        "loads": _force_table_loads,
        "rotor_rate": _to_static_speed,
        "axial_rate": _no_axial_rate,
    },
}


def powered(drive, supply, p):  # type: ignore[no-untyped-def]
    """Return what is left of the drive at a relative supply voltage; a table over the supply takes it from there."""
    return _EQUATIONS[type(p)]["powered"](drive, supply, p)


def loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    """Return (T [N], Q [N m]) of the class of `p`; `supply`: relative voltage."""
    return _EQUATIONS[type(p)]["loads"](n, v, u, supply, p)


def rotor_speed(n, drive, u, p):  # type: ignore[no-untyped-def]
    """Return the rotor speed [rad/s]: the state n or, for a rotor without inertia, what throttle or drive make it."""
    return _EQUATIONS[type(p)]["speed"](n, drive, u, p)


def rotor_rate(n, moment, drive, supply, p):  # type: ignore[no-untyped-def]
    """Return dn/dt [rad/s^2] of the class of `p`; `supply`: relative voltage."""
    return _EQUATIONS[type(p)]["rotor_rate"](n, moment, drive, supply, p)


def axial_flow(n, v, ambient, p):  # type: ignore[no-untyped-def]
    """Return the axial flow [m/s]: the state v or, where it is steady, what rotor speed and ambient flow make it."""
    return _EQUATIONS[type(p)]["flow"](n, v, ambient, p)


def axial_rate(v, ambient, force, p):  # type: ignore[no-untyped-def]
    """Return dv/dt [m/s^2] of the class of `p`."""
    return _EQUATIONS[type(p)]["axial_rate"](v, ambient, force, p)


@overload(loads, inline="always")
def _compile_loads(n, v, u, supply, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["loads"]
    return lambda n, v, u, supply, p: chosen(n, v, u, supply, p)


@overload(powered, inline="always")
def _compile_powered(drive, supply, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["powered"]
    return lambda drive, supply, p: chosen(drive, supply, p)


@overload(rotor_speed, inline="always")
def _compile_speed(n, drive, u, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["speed"]
    return lambda n, drive, u, p: chosen(n, drive, u, p)


@overload(rotor_rate, inline="always")
def _compile_rotor_rate(n, moment, drive, supply, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["rotor_rate"]
    return lambda n, moment, drive, supply, p: chosen(n, moment, drive, supply, p)


@overload(axial_flow, inline="always")
def _compile_flow(n, v, ambient, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["flow"]
    return lambda n, v, ambient, p: chosen(n, v, ambient, p)


@overload(axial_rate, inline="always")
def _compile_axial_rate(v, ambient, force, p):  # type: ignore[no-untyped-def]
    chosen = _EQUATIONS[p.instance_class]["axial_rate"]
    return lambda v, ambient, force, p: chosen(v, ambient, force, p)
