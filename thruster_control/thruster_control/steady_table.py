"""The lookup table of open-loop control: throttle over thrust in steady state (thesis, (3.6) and Fig. 3.6).

The steady states of a parameter set are simulated. They become the (3, K) array that `settings.TableLaw` looks up:
throttle [V], thrust [N], rotor speed [rad/s], strictly ascending but for the dead zone's two edges, at which the
throttle jumps from one to the other while thrust and speed are zero.
"""

import numpy as np
from numpy.typing import NDArray

from thruster_control.errors import SteadyStatesError
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.identification.steady_state import predicted_steady_states

__all__ = ["lookup_of_set"]

Array = NDArray[np.float64]


def lookup_of_set(p: ThrusterCoefficients, *, u_max: float = 3.0, nodes: int = 12) -> Array:
    """Return (3, K) for `settings.TableLaw` from a parameter set's steady states up to `u_max` [V].

    `nodes` on each side, closer together towards the edge of the dead zone, where thrust grows with the square of
    what lies beyond it. A set with flow answers with the steady state of its flow tank, after 40 s.
    """
    if not (p.delta_u1 > -u_max and p.delta_u2 < u_max):
        problem = f"expected a dead zone within {u_max:g} V; found {p.delta_u1:g} to {p.delta_u2:g} V"
        raise SteadyStatesError("parameter set", [problem])
    share = (np.arange(1, nodes + 1) / nodes) ** 2
    sides = [edge + (end - edge) * share for edge, end in ((p.delta_u1, -u_max), (p.delta_u2, u_max))]
    states = [predicted_steady_states(p, side) for side in sides]
    left, right = (np.column_stack((side, s["thrust"], s["speed"])) for side, s in zip(sides, states, strict=True))
    edges = [[p.delta_u1, 0.0, 0.0], [p.delta_u2, 0.0, 0.0]]
    kept = [side[np.all(side * sign > 0.0, axis=1)] for side, sign in ((left, -1.0), (right, 1.0))]
    return np.ascontiguousarray(np.concatenate((kept[0][::-1], edges, kept[1])).T)
