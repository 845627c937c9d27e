"""A depth sensor that tells too much or too little: made for salt water in fresh, or another gauge."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with depths (1 + s) times as large."""
    return c._replace(depth_scale=c.depth_scale * (1.0 + active.size("share")))


EFFECT = VehicleEffect(
    id="depth_scale",
    title="wrong scale of the depth sensor",
    block="sensor",
    equation="y (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="by which depths are too large", lower=-0.3, upper=0.3),
    ),
    sensing=sensing,
    suspected=(Suspected(sizes={"share": (0.05, 0.01)}, read_by="depth", tolerance=0.005),),
)
