"""A depth sensor off its zero: tared at another pressure of the air, or in the water."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with a depth s [m] larger; it shows only against an absolute reference."""
    return c._replace(depth_bias=c.depth_bias + active.size("offset"))


EFFECT = VehicleEffect(
    id="depth_bias",
    title="bias of the depth sensor",
    block="sensor",
    equation="y + s",
    parameters=(EffectParameter(name="offset", unit="m", meaning="added to the depth", lower=-2.0, upper=2.0),),
    note="the water is alike at all depths, so that no other reading goes with it: a diagnosis begins at the depth "
    "that is read first, and does not look for this effect; a watch finds it where it begins",
    sensing=sensing,
    suspected=(Suspected(sizes={"offset": (0.3, 0.3)}, read_by="depth", sudden=0.3),),
)
