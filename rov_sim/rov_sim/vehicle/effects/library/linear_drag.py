"""Drag in proportion to speed along one axis is more than assumed, or less."""

from rov_sim.vehicle.effects.body_axes import BODY_AXES, axis_index
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with that entry of D_L times (1 + s)."""
    a, matrix = axis_index(active.axis), c.D_L.copy()
    matrix[a, a] *= 1.0 + active.size("share")
    return c._replace(D_L=matrix)


EFFECT = VehicleEffect(
    id="linear_drag",
    title="linear drag of one axis",
    block="body",
    equation="D_L,aa (1 + s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of that entry more", lower=-0.8, upper=0.8),),
    needs=("axis",),
    choices={"axis": BODY_AXES},
    body=body,
    suspected=(Suspected(sizes={"share": (0.5, 0.1)}, only={"axis": BODY_AXES}),),
)
