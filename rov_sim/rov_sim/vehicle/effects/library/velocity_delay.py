"""A velocity log whose readings bear the instant at which they arrive, not that of the ping."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with stamps s [s] later: a reading stamped t tells the velocity at t - s."""
    return c._replace(velocity_late=c.velocity_late + active.size("time"))


EFFECT = VehicleEffect(
    id="velocity_delay",
    title="late readings of the velocity log",
    block="sensor",
    equation="y(t) = v(t - s)",
    parameters=(EffectParameter(name="time", unit="s", meaning="by which stamps are late", lower=0.0, upper=1.0),),
    sensing=sensing,
    twins=("log_alignment",),
    suspected=(Suspected(sizes={"time": (0.3, 0.05)}, read_by="velocity"),),
)
