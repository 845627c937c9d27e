"""Outer loop and allocation as one step: from a set point and the vehicle's state to a thrust for each thruster.

For kernels: all settings are in one tuple, all that is remembered is in another, and nothing is made on the way.

    controller = Controller(quaternion_law(2.0, 1.0), coefficients, limits_of_sets(sets, 3.0), allocation(...))
    memory = controller_memory(6)                                              # of each loop its own
    outer, allocated, share = controller_step(memory, q, nu, set_point, U, dt, controller, T)     # fills T (N,)
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_control.allocation.allocate import AllocationStatus, allocate
from thruster_control.allocation.limits import ThrustLimits, limits_at
from thruster_control.allocation.settings import Allocation, AllocationMemory, allocation_memory
from thruster_control.outer_loop.settings import OuterMemory, outer_memory
from thruster_control.outer_loop.step import OuterStatus, note_achieved, outer_loop_step
from thruster_model.compilation import compiled, equation
from thruster_model.equations.attitude import normalised
from thruster_model.equations.hydrodynamics import current_in_body

__all__ = ["Controller", "ControllerMemory", "compiled_controller", "controller_memory", "controller_step"]

Array = NDArray[np.float64]
_NO_SET_POINT = int(OuterStatus.NO_SET_POINT)
_EXACT = int(AllocationStatus.EXACT)


class Controller(NamedTuple):
    """What is chosen: law of `settings`, coefficients of the vehicle as it is believed to be, limits, allocation."""

    law: Any
    coefficients: Any
    limits: ThrustLimits
    allocation: Allocation


class ControllerMemory(NamedTuple):
    """What a loop remembers, changed in place; wrench (6,): what the law asked for last [N, N m]."""

    outer: OuterMemory
    allocation: AllocationMemory
    wrench: Array
    U: Array
    lower: Array
    upper: Array


def controller_memory(thrusters: int) -> ControllerMemory:
    """Return the memory before the first step, for so many thrusters; each loop needs its own."""
    rooms = (np.zeros(size) for size in (6, thrusters, thrusters, thrusters))
    return ControllerMemory(outer_memory(), allocation_memory(thrusters), *rooms)


@equation
def controller_step(memory, q, nu, sp, U, dt, controller, T):  # type: ignore[no-untyped-def]
    """Fill T (N,) [N] with what to ask of each thruster; return (`OuterStatus`, `AllocationStatus`, share).

    Args:
        memory: `ControllerMemory`, changed in place.
        q, nu: attitude (4,) and velocity (6,), as `outer_loop_step` takes them.
        sp: `VehicleSetPoint`.
        U: inflow of each thruster (N,) [m/s]; NaN: that of the vehicle's motion through the current it believes in.
        dt: time since the former step [s].
        controller: `Controller`.
        T: (N,), filled; zeros where the outer loop has nothing to ask.
    """
    outer = outer_loop_step(memory.outer, q, nu, sp, dt, controller.law, controller.coefficients, memory.wrench)
    if outer >= _NO_SET_POINT:
        T[:] = 0.0
        memory.allocation.side[:] = 0.0
        memory.allocation.along[:] = 0.0
        return outer, _EXACT, 1.0
    c = controller.coefficients
    nu_c = current_in_body(normalised((q[0], q[1], q[2], q[3])), c.current)
    for i in range(T.shape[0]):
        memory.U[i] = U[i]
        if not math.isfinite(U[i]):
            total = 0.0
            for j in range(6):
                total += c.inflow[j, i] * (memory.outer.known[j] - (nu_c[j] if j < 3 else 0.0))
            memory.U[i] = total
    limits_at(controller.limits, memory.U, memory.lower, memory.upper)
    share, status = allocate(memory.wrench, memory.lower, memory.upper, controller.allocation, memory.allocation, T)
    note_achieved(memory.outer, memory.wrench, memory.allocation.achieved)
    return outer, status, share


@compiled
def compiled_controller(memory, q, nu, sp, U, dt, controller, T):  # type: ignore[no-untyped-def]
    """Fill T and return the statuses of `controller_step`, compiled; the same arguments."""
    return controller_step(memory, q, nu, sp, U, dt, controller, T)
