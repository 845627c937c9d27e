"""A heading off by one angle: a filter of the attitude that began anew with a wrong one."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with a yaw s [rad] larger."""
    return c._replace(heading_bias=c.heading_bias + active.size("angle"))


EFFECT = VehicleEffect(
    id="heading_bias",
    title="bias of the heading",
    block="sensor",
    equation="psi + s",
    parameters=(EffectParameter(name="angle", unit="rad", meaning="of yaw", lower=-1.5, upper=1.5),),
    note="no other reading goes with the heading: a diagnosis takes the one that is told, and does not look for this "
    "effect; a watch finds it where it begins",
    sensing=sensing,
    suspected=(Suspected(sizes={"angle": (0.3, 0.3)}, read_by="attitude", sudden=0.3),),
)
