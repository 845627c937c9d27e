"""A centre of buoyancy elsewhere than assumed: foam moved, a housing added or flooded."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from rov_sim.vehicle.effects.shifts import PARAMETERS, SUSPECTED, shift


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with r_B moved."""
    return c._replace(r_B=c.r_B + shift(active))


EFFECT = VehicleEffect(
    id="cb_shift",
    title="centre of buoyancy moved",
    block="body",
    equation="r_B + s",
    parameters=PARAMETERS,
    body=body,
    suspected=(SUSPECTED,),
)
