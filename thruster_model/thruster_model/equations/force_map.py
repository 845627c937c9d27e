r"""A thruster as its maker measures it: speed and force over command and supply voltage, behind a first-order lag.

With x the drive, here the command beyond the dead zone as the speed of a straight line [rad/s], V the supply [V]:

    dn/dt = rate (n_s(x, V) - n),      T = share F_s(x', V)  with  n_s(x', V) = n

n_s and F_s are curves through measured points (x_k, n_mk, F_mk) at each measured supply V_m, linear between points and
between supplies. So the rotor lags, and the force is the measured one at the speed that the rotor has: once n has
settled, exactly F_s(x, V). Outside what was measured the ends hold.

Measured at a standstill: no flow reaches the force, no torque is known.
"""

from typing import Any

import numpy as np
from numba.extending import overload

from thruster_model.compilation import compiled, equation

__all__ = ["CURVES", "drive_for_force", "force_at_speed", "static_current", "static_speed"]

CURVES = ("drive", "speed", "force", "current")
"""First index of `curves` (4, M, K): drive [rad/s], n [rad/s], F [N], current [A], NaN for what was not measured."""
_DRIVE, _SPEED, _FORCE, _CURRENT = range(4)


@equation
def _place(nodes, x):  # type: ignore[no-untyped-def]
    """Return (index of the node below x, share of the way to the next), at the ends theirs."""
    k = 0
    while k < nodes.size - 2 and x >= nodes[k + 1]:
        k += 1
    if nodes.size == 1:
        return 0, 0, 0.0
    return k, k + 1, min(max((x - nodes[k]) / (nodes[k + 1] - nodes[k]), 0.0), 1.0)


@equation
def _from_to(given, wanted, x, volts, supplies, curves):  # type: ignore[no-untyped-def]
    """Return curve `wanted` where the ascending curve `given` is x, both at the supply of `volts`."""
    m, m1, w = _place(supplies, volts)
    a, b = curves[given], curves[wanted]
    low, high = 0, a.shape[1] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if (1.0 - w) * a[m, middle] + w * a[m1, middle] <= x:
            low = middle
        else:
            high = middle
    first = (1.0 - w) * a[m, low] + w * a[m1, low]
    last = (1.0 - w) * a[m, high] + w * a[m1, high]
    r = min(max((x - first) / (last - first), 0.0), 1.0) if last > first else 0.0
    below = (1.0 - r) * b[m, low] + r * b[m, high]
    above = (1.0 - r) * b[m1, low] + r * b[m1, high]
    return (1.0 - w) * below + w * above


@compiled
def _all_from_to(given, wanted, x, volts, supplies, curves, out):  # type: ignore[no-untyped-def]
    for i in range(out.size):
        out[i] = _from_to(given, wanted, x[i], volts[i], supplies, curves)


def _broadcast(given: int, wanted: int, x: Any, volts: Any, p: Any) -> Any:
    """Return `_from_to` of arguments that broadcast: what Python calls, compiled."""
    places, supply = (np.array(each, dtype=np.float64) for each in np.broadcast_arrays(x, volts))
    out = np.empty(places.size)
    _all_from_to(given, wanted, places.ravel(), supply.ravel(), p.supplies, p.curves, out)
    return out.reshape(places.shape)[()]


def static_speed(drive, volts, p):  # type: ignore[no-untyped-def]
    """Return n_s [rad/s] for the drive [rad/s] at the supply [V]; arguments broadcast."""
    return _broadcast(_DRIVE, _SPEED, drive, volts, p)


def force_at_speed(n, volts, p):  # type: ignore[no-untyped-def]
    """Return the table's force [N] at the rotor speed [rad/s] and supply [V]; arguments broadcast."""
    return _broadcast(_SPEED, _FORCE, n, volts, p)


def drive_for_force(force, volts, p):  # type: ignore[no-untyped-def]
    """Return the drive nearest zero [rad/s] that gives the table's force [N] at the supply [V], or the end's."""
    return _broadcast(_FORCE, _DRIVE, force, volts, p)


def static_current(n, volts, p):  # type: ignore[no-untyped-def]
    """Return the current [A] drawn at the rotor speed [rad/s] and supply [V]; NaN where the table has none."""
    return _broadcast(_SPEED, _CURRENT, n, volts, p)


@overload(static_speed)
def _compile_static_speed(drive, volts, p):  # type: ignore[no-untyped-def]
    return lambda drive, volts, p: _from_to(_DRIVE, _SPEED, drive, volts, p.supplies, p.curves)


@overload(force_at_speed)
def _compile_force_at_speed(n, volts, p):  # type: ignore[no-untyped-def]
    return lambda n, volts, p: _from_to(_SPEED, _FORCE, n, volts, p.supplies, p.curves)


@overload(drive_for_force)
def _compile_drive_for_force(force, volts, p):  # type: ignore[no-untyped-def]
    return lambda force, volts, p: _from_to(_FORCE, _DRIVE, force, volts, p.supplies, p.curves)


@overload(static_current)
def _compile_static_current(n, volts, p):  # type: ignore[no-untyped-def]
    return lambda n, volts, p: _from_to(_SPEED, _CURRENT, n, volts, p.supplies, p.curves)
