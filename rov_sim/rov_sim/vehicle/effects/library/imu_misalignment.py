"""An IMU mounted askew: all it tells belongs to other axes than those that are believed."""

from rov_sim.vehicle.effects.axes import AXES, turned
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the IMU turned by s about one of its axes."""
    return c._replace(imu_rotation=turned(c.imu_rotation, active.axis, active.size("angle")))


EFFECT = VehicleEffect(
    id="imu_misalignment",
    title="IMU mounted askew",
    block="sensor",
    equation="R_s turned by s about one axis",
    parameters=(EffectParameter(name="angle", unit="rad", meaning="of the turn", lower=-0.3, upper=0.3),),
    note="the IMU's axes are turned by +s from where the sensors' file has them, about one of them; gyro, "
    "accelerometer and attitude all tell of these axes. A diagnosis supposes this turn of `rov/odometry`, too, though "
    "not the `rotation` of the file",
    needs=("axis",),
    choices={"axis": AXES},
    sensing=sensing,
    suspected=(Suspected(sizes={"angle": (0.1, 0.01)}, tolerance=0.0075),),
)
