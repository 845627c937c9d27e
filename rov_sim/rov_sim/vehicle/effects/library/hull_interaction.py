"""A propeller's wake that meets the hull: part of its thrust pushes the hull back, along one axis.

Without an axis it is the one along which the thruster pushes most; kind: for forward thrust, reverse, or both.
"""

import numpy as np

from rov_sim.vehicle.effects.body_axes import BODY_AXES, axis_index, pushed_by
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with that entry of the wrench of forward or reverse thrust, or both, times (1 - s)."""
    i, s = active.thruster, active.size("share")
    a = int(np.argmax(np.abs(c.K_t[:3, i]))) if active.axis is None else axis_index(active.axis)
    forward, reverse = c.K_t.copy(), c.K_t_reverse.copy()
    if active.kind != "reverse":
        forward[a, i] *= 1.0 - s
    if active.kind != "forward":
        reverse[a, i] *= 1.0 - s
    return c._replace(K_t=forward, K_t_reverse=reverse)


def places(vehicle):  # type: ignore[no-untyped-def]
    """Yield each thruster with the axes along which its wake may meet the hull."""
    for i in range(vehicle.configuration.shape[1]):
        for axis in pushed_by(vehicle.configuration, i):
            yield {"thruster": i, "axis": axis, "kind": "both"}


EFFECT = VehicleEffect(
    id="hull_interaction",
    title="wake of a thruster on the hull",
    block="thrusters",
    equation="K_t,ai T_i (1 - s) on one axis a",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of that force lost on the hull", lower=0.0, upper=0.6),
    ),
    note="kind: of thrust forward, in reverse or, as without a kind, both. Without an axis it is that of surge, sway "
    "and heave along which the thruster pushes most",
    needs=("thruster",),
    may_take=("axis", "kind"),
    choices={"axis": BODY_AXES, "kind": ("forward", "reverse", "both")},
    order=1,
    body=body,
    suspected=(Suspected(sizes={"share": (0.3, 0.05)}, places=places),),
)
