r"""The lookup table of open-loop control: throttle over thrust in steady state (thesis, (3.6) and Fig. 3.6).

From measured steady states a `ForceTable` is made first, whose commands are throttles, with the edges of the dead
zone as nodes without thrust; from a parameter set the states are simulated. Either becomes the (3, K) array that
`settings.TableLaw` looks up: throttle [V], thrust [N], rotor speed [rad/s], strictly ascending but for the two edges,
at which the throttle jumps from one to the other while thrust and speed are zero.

Beyond the dead zone the steady speed is almost straight over the throttle (Fig. 3.6). An edge that is not given is
where the line through a direction's two states nearest to zero reaches n = 0.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_control.errors import SteadyStatesError
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.force_table import ForceTable
from thruster_model.force_table_quality import monotone
from thruster_model.identification.steady_state import predicted_steady_states

__all__ = ["dead_zone_edges", "force_table", "lookup_of_set", "lookup_table"]

Array = NDArray[np.float64]


def dead_zone_edges(throttle: ArrayLike, speed: ArrayLike) -> tuple[float, float]:
    """Return the dead zone's edges [V] found from steady speeds [rad/s] over the throttle [V], shape (K,) each."""
    u, n = _sorted(throttle, speed)
    edges = []
    for sign, word in ((-1.0, "reverse"), (1.0, "forward")):
        turning = np.flatnonzero((sign * u > 0.0) & (sign * n > 0.0))
        nearest = turning[np.argsort(np.abs(u[turning]))[:2]]
        if nearest.size < 2:
            problem = f"expected two or more steady states in {word} to find the dead zone's edge; found {nearest.size}"
            raise SteadyStatesError("steady states", [problem])
        (u_a, u_b), (n_a, n_b) = u[nearest], n[nearest]
        edge = u_a - n_a * (u_b - u_a) / (n_b - n_a) if n_b != n_a else np.nan
        if not 0.0 <= sign * edge < sign * u_a:
            problem = f"expected the dead zone's edge in {word} between 0 and {u_a:g} V; the speeds lead to {edge:g} V"
            raise SteadyStatesError("steady states", [problem])
        edges.append(float(edge))
    return edges[0], edges[1]


def force_table(
    throttle: ArrayLike,
    thrust: ArrayLike,
    speed: ArrayLike,
    *,
    supply: float,
    source: str,
    edges: tuple[float, float] | None = None,
) -> ForceTable:
    """Return measured steady states as a table over the throttle.

    Args:
        throttle: [V], shape (K,), in any order; several states at one throttle are averaged.
        thrust: [N], shape (K,).
        speed: rotor speed [rad/s], signed, shape (K,).
        supply: supply voltage at which they were measured [V].
        source: where the numbers come from.
        edges: of the dead zone [V]; None: `dead_zone_edges`.

    Raises:
        SteadyStatesError, ForceTableError: they give no table.
    """
    u, T, n = _sorted(throttle, thrust, speed)
    low, high = dead_zone_edges(u, n) if edges is None else edges
    if not low <= 0.0 <= high:
        raise SteadyStatesError(source, [f"edges: expected one on either side of 0 V; found {low:g} and {high:g} V"])
    outside = (u < low) | (u > high)
    levels, where = np.unique(u[outside], return_inverse=True)
    counts = np.bincount(where, minlength=levels.size)
    means = [np.bincount(where, weights=x[outside], minlength=levels.size) / counts for x in (T, n)]
    nodes = np.unique([low, 0.0, high])
    command = np.concatenate((levels, nodes))
    order = np.argsort(command)
    force, turning = (np.concatenate((x, np.zeros(nodes.size)))[order] for x in means)
    return ForceTable(
        command=command[order],
        command_unit="V",
        stop=0.0,
        supply=np.array([supply]),
        force=force[None],
        speed=turning[None],
        name="steady states",
        source=source,
        origin=source,
    )


def lookup_table(table: ForceTable, supply: float) -> Array:
    """Return (3, K) for `settings.TableLaw` from a table over the throttle at a supply voltage [V].

    Thrust that falls though the throttle rises is made monotone; a node that adds no thrust or no speed is left out:
    of several throttles for one thrust the one nearest to zero is kept.
    """
    if table.command_unit != "V" or table.speed is None:
        found = f"commands in {table.command_unit} and {', '.join(table.quantities)}"
        raise SteadyStatesError(table.origin, [f"expected commands in V with force and speed; found {found}"])
    one = monotone(table.at_supply(supply))
    assert one.speed is not None
    low, high = (float(edge) for edge in one.zero_band(supply))
    sides = []
    for sign, edge in ((-1.0, low), (1.0, high)):
        beyond = np.flatnonzero(sign * one.command > sign * edge)
        beyond = beyond[np.argsort(np.abs(one.command[beyond]))]
        kept = [np.array([edge, 0.0, 0.0])]
        for i in beyond:
            node = np.array([one.command[i], one.force[0, i], one.speed[0, i]])
            if np.all(sign * node > sign * kept[-1]):
                kept.append(node)
        sides.append(np.array(kept))
    return np.ascontiguousarray(np.concatenate((sides[0][::-1], sides[1])).T)


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


def _sorted(throttle: ArrayLike, *values: ArrayLike) -> tuple[Array, ...]:
    """Return the throttle ascending and the values in its order."""
    arrays = [np.asarray(x, dtype=np.float64) for x in (throttle, *values)]
    shapes = {x.shape for x in arrays}
    if len(shapes) != 1 or arrays[0].ndim != 1 or not all(np.all(np.isfinite(x)) for x in arrays):
        problem = f"expected finite numbers in rows of one length; found shapes {[x.shape for x in arrays]}"
        raise SteadyStatesError("steady states", [problem])
    order = np.argsort(arrays[0], kind="stable")
    return tuple(x[order] for x in arrays)
