"""Table and simplified model refitted to a true thruster, as if they had been identified on it at rest in the water.

On a vehicle at rest U = 0, whatever the thruster does to a tank: (4.5) is left out. Table 3.1 describes another
thruster than Table 4.1: with it a command of 10 N gives other thrusts on the HQ model, and what that costs cannot be
told from what it costs to leave the flow out.
"""

from typing import Any

import numpy as np

from thruster_control.steady_table import lookup_of_set
from thruster_model.identification.steady_state import predicted_steady_states

__all__ = ["at_rest_in_water", "refitted_simplified", "refitted_table"]

_NODES = 12


def at_rest_in_water(p: Any) -> Any:
    """Return the coefficients with an ambient flow that stays zero."""
    return p._replace(k_TU=0.0)


def refitted_table(p: Any, u_max: float) -> Any:
    """Return the table (3, K) of the thruster's steady states up to `u_max` [V]."""
    return lookup_of_set(at_rest_in_water(p), u_max=u_max, nodes=_NODES)


def refitted_simplified(p: Any, u_max: float) -> Any:
    """Return the simplified model of the thruster: its rotor, and T = c_T n|n| fitted to the steady states.

    Each direction has a c_T of its own, least squares over the thrusts up to `u_max` [V]; a thruster whose thrust and
    torque depend on n alone is its own simplified model.
    """
    if p.c_nv_T == p.c_v_T == p.c_nv_Q == p.c_v_Q == 0.0:
        return p
    share = np.arange(1, _NODES + 1) / _NODES
    found = {}
    for name, edge, end in (("c_T1", p.delta_u1, -u_max), ("c_T2", p.delta_u2, u_max)):
        states = predicted_steady_states(at_rest_in_water(p), edge + (end - edge) * share)
        square = states["speed"] * np.abs(states["speed"])
        found[name] = float(square @ states["thrust"] / (square @ square))
    flow = dict.fromkeys(
        ("c_nv_T", "c_v_T", "c_nv_Q", "c_v_Q", "k_v", "k_Uv", "k_w", "k_Tv", "k_U", "k_UU", "k_TU"), 0.0
    )
    return p._replace(**found, delta_T1=0.0, delta_T2=0.0, **flow)
