"""A gyro that tells too much or too little of every turn."""

from rov_sim.vehicle.effects.axes import AXES, scaled
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with angular velocities (1 + s) times as large, on one axis of the IMU or on all."""
    return c._replace(gyro_scale=scaled(c.gyro_scale, active.axis, active.size("share")))


EFFECT = VehicleEffect(
    id="gyro_scale",
    title="wrong scale of the gyro",
    block="sensor",
    equation="y (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="by which readings are too large", lower=-0.3, upper=0.3),
    ),
    may_take=("axis",),
    choices={"axis": AXES},
    sensing=sensing,
    suspected=(
        Suspected(sizes={"share": (0.1, 0.02)}, only={"axis": AXES}, read_by="gyro", tolerance=0.005),
        Suspected(sizes={"share": (0.1, 0.02)}, only={"axis": (None,)}, read_by="gyro"),
    ),
)
