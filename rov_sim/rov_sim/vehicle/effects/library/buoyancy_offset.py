"""Foam or flooded space: buoyancy is more than assumed, or less, at the same centre."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with s more buoyancy."""
    return c._replace(buoyancy=c.buoyancy + active.size("force"))


EFFECT = VehicleEffect(
    id="buoyancy_offset",
    title="buoyancy more or less",
    block="body",
    equation="B + s",
    parameters=(EffectParameter(name="force", unit="N", meaning="of buoyancy more", lower=-30.0, upper=30.0),),
    body=body,
    suspected=(Suspected(sizes={"force": (5.0, 0.3)}, watched=(5.0, -5.0)),),
)
