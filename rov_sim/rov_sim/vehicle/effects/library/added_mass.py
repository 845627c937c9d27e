"""Water that moves with the body along one axis is more than assumed, or less."""

from rov_sim.vehicle.effects.body_axes import BODY_AXES, axis_index
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with that entry of M_A times (1 + s)."""
    a, matrix = axis_index(active.axis), c.M_A.copy()
    matrix[a, a] *= 1.0 + active.size("share")
    return c._replace(M_A=matrix)


EFFECT = VehicleEffect(
    id="added_mass",
    title="added mass of one axis",
    block="body",
    equation="M_A,aa (1 + s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of that entry more", lower=-0.8, upper=0.8),),
    needs=("axis",),
    choices={"axis": BODY_AXES},
    body=body,
    suspected=(Suspected(sizes={"share": (0.4, 0.05)}, only={"axis": BODY_AXES}),),
)
