"""An IMU off its zero: the gyro, the accelerometer, or both, along one axis."""

from rov_sim.vehicle.effects.axes import AXES, moved
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with biases s larger along one axis of the IMU."""
    return c._replace(
        gyro_bias=moved(c.gyro_bias, active.axis, active.size("rate")),
        force_bias=moved(c.force_bias, active.axis, active.size("force")),
    )


EFFECT = VehicleEffect(
    id="imu_bias",
    title="bias of the IMU",
    block="sensor",
    equation="y + s",
    parameters=(
        EffectParameter(name="rate", unit="rad/s", meaning="of the gyro", lower=-0.1, upper=0.1),
        EffectParameter(name="force", unit="m/s^2", meaning="of the specific force", lower=-1.0, upper=1.0),
    ),
    needs=("axis",),
    choices={"axis": AXES},
    sensing=sensing,
    suspected=(
        Suspected(sizes={"rate": (0.02, 0.002)}, read_by="gyro", watched=(0.02, -0.02)),
        Suspected(sizes={"force": (0.3, 0.03)}, read_by="accelerometer", watched=(0.3, -0.3)),
    ),
)
