r"""One step of an outer loop: from a set point and the vehicle's state to the wrench, for every law.

What it does, in this order, is also what is answered for inputs that fail:

    dt not a positive finite time        no wrench; the memory is emptied                             BAD_PERIOD
    set point not finite                 no wrench; the memory is emptied                             NO_SET_POINT
    attitude or body rates not finite,   no wrench; the memory is emptied                             NO_STATE
      or a quaternion of no length
    surge, sway or heave not finite      the law, with these speeds as if they were as wanted         ATTITUDE_ONLY
    otherwise                            the law; BEYOND where it is used beyond what it is for       FOLLOWING

A period longer than `LONGEST_PERIOD` is a gap, over which nothing is integrated.
"""

import math
from enum import IntEnum

from thruster_control.outer_loop.laws import law_wrench
from thruster_model.compilation import compiled, equation

__all__ = ["LONGEST_PERIOD", "OuterStatus", "compiled_outer_loop", "note_achieved", "outer_loop_step"]

LONGEST_PERIOD = 0.5  # s


class OuterStatus(IntEnum):
    """What a step did."""

    FOLLOWING = 0
    ATTITUDE_ONLY = 1
    BEYOND = 2
    NO_SET_POINT = 3
    NO_STATE = 4
    BAD_PERIOD = 5


_FOLLOWING, _ATTITUDE_ONLY, _BEYOND, _NO_SET_POINT, _NO_STATE, _BAD_PERIOD = map(int, OuterStatus)


@equation
def _finite(a):  # type: ignore[no-untyped-def]
    return math.isfinite(a[0]) and math.isfinite(a[1]) and math.isfinite(a[2])


@equation
def _none(memory, wrench, status):  # type: ignore[no-untyped-def]
    wrench[:] = 0.0
    memory.integral[:] = 0.0
    memory.shortfall[:] = 0.0
    memory.error[:] = 0.0
    return status


@equation
def outer_loop_step(memory, q, nu, sp, dt, law, c, wrench):  # type: ignore[no-untyped-def]
    """Fill wrench (6,) [N, N m], at the body's origin in body axes; return the `OuterStatus`.

    Args:
        memory: `OuterMemory`, changed in place.
        q: attitude (4,), (w, x, y, z), body to earth (north, east, down), of any length but zero.
        nu: velocity (6,) [m/s, rad/s] over ground, in body axes; a float64 array.
        sp: `VehicleSetPoint`.
        dt: time since the former step [s].
        law: of `settings`; its class chooses the law.
        c: the vehicle's coefficients.
        wrench: (6,), filled.
    """
    if not (dt > 0.0 and dt < math.inf):
        return _none(memory, wrench, _BAD_PERIOD)
    wanted = _finite(sp.attitude) and _finite(sp.attitude_rate) and _finite(sp.attitude_acceleration)
    if not (wanted and _finite(sp.velocity) and _finite(sp.acceleration)):
        return _none(memory, wrench, _NO_SET_POINT)
    size = math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    rates = math.isfinite(nu[3]) and math.isfinite(nu[4]) and math.isfinite(nu[5])
    if not (size > 0.0 and math.isfinite(size) and rates):
        return _none(memory, wrench, _NO_STATE)
    known = memory.known
    status = _FOLLOWING
    for i in range(6):
        known[i] = nu[i]
        if not math.isfinite(nu[i]):
            known[i] = sp.velocity[i]
            status = _ATTITUDE_ONLY
    unit = (q[0] / size, q[1] / size, q[2] / size, q[3] / size)
    within = law_wrench(unit, known, sp, dt if dt <= LONGEST_PERIOD else 0.0, law, c, memory, wrench)
    return status if within or status != _FOLLOWING else _BEYOND


@equation
def note_achieved(memory, wrench, achieved):  # type: ignore[no-untyped-def]
    """Note what the thrusters made of the wrench (6,): an integral does not run against their limits."""
    for i in range(6):
        memory.shortfall[i] = wrench[i] - achieved[i]


@compiled
def compiled_outer_loop(memory, q, nu, sp, dt, law, c, wrench):  # type: ignore[no-untyped-def]
    """Fill wrench and return the status of `outer_loop_step`, compiled; the same arguments."""
    return outer_loop_step(memory, q, nu, sp, dt, law, c, wrench)
