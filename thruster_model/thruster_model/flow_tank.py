"""The thruster in a flow tank over a whole run: (4.3) to (4.5) with the ramp limit, integrated by RK4.

The throttle is held between commands (zero-order hold); the acting throttle moves towards the command at u_dot_max.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.stepper import AT_REST, NO_GATES, NOMINAL_SUPPLY, PlantState
from thruster_model.whole_run import simulated_rows

__all__ = ["AT_REST", "PlantState", "Trajectory", "simulate"]


class Trajectory(NamedTuple):
    """A simulated run at N + 1 instants, `dt` apart, the first at time 0: arrays of shape (N + 1,), SI units."""

    n: NDArray[np.float64]
    v: NDArray[np.float64]
    ambient: NDArray[np.float64]
    u: NDArray[np.float64]
    thrust: NDArray[np.float64]
    torque: NDArray[np.float64]


def simulate(
    coefficients: ThrusterCoefficients,
    u_commanded: ArrayLike,
    dt: float,
    *,
    initial: PlantState = AT_REST,
    largest_step: float = 1e-3,
    effects: Any = NO_EFFECTS,
    gates: ArrayLike = NO_GATES,
    supply: ArrayLike = NOMINAL_SUPPLY,
) -> Trajectory:
    """Simulate the thruster under a commanded throttle.

    Args:
        coefficients: of the common form, `ParameterSet.coefficients`.
        u_commanded: throttle commands [V], shape (N,), each held for `dt`.
        dt: period of the commands [s].
        initial: state at the first command.
        largest_step: upper bound of the integration step [s]; effects that act more abruptly take shorter ones.
        effects: `EffectValues` of unmodelled effects on the command and in the plant, or none.
        gates: 0 in periods in which the propeller may draw air, else 1, shape (N,); empty: never.
        supply: voltage of the supply over the nominal one in each period, shape (N,); empty: 1.

    Returns:
        Trajectory at the N + 1 instants 0, dt, ..., N dt.
    """
    speed, axial, ambient, thrust, torque, throttle = simulated_rows(
        coefficients,
        u_commanded,
        dt,
        start=initial,
        largest_step=largest_step,
        effects=effects,
        gates=gates,
        supply=supply,
    )
    return Trajectory(speed, axial, ambient, throttle, thrust, torque)
