"""Water heavier or lighter than assumed: salt, cold, silt."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients in water (1 + s) times as dense."""
    f = 1.0 + active.size("share")
    return c._replace(
        M_A=c.M_A * f, D_L=c.D_L * f, D_Q=c.D_Q * f, buoyancy=c.buoyancy * f, thrust_scale=c.thrust_scale * f,
        density=c.density * f,
    )  # fmt: skip


EFFECT = VehicleEffect(
    id="water_density",
    title="density of the water",
    block="water",
    equation="drag, added mass, buoyancy and thrust times (1 + s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of the density more", lower=-0.05, upper=0.05),),
    body=body,
    suspected=(Suspected(sizes={"share": (0.03, 0.01)}),),
)
