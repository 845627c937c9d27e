"""An IMU whose readings bear the instant at which they arrive, not that at which it was read."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with readings s [s] older: one stamped t tells attitude, rates and force at t - s."""
    return c._replace(imu_late=c.imu_late + active.size("time"))


EFFECT = VehicleEffect(
    id="imu_delay",
    title="late readings of the IMU",
    block="sensor",
    equation="y(t) = x(t - s)",
    note="attitude, rates and force are old; a diagnosis supposes it of an attitude in `rov/odometry`, too",
    parameters=(
        EffectParameter(
            name="time", unit="s", meaning="by which readings are old; simulated to the nearest one", lower=0.0,
            upper=0.5,
        ),
    ),
    sensing=sensing,
    twins=("log_alignment",),
    suspected=(Suspected(sizes={"time": (0.1, 0.02)}, read_by="gyro"),),
)  # fmt: skip
