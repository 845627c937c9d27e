"""A velocity log mounted askew."""

from rov_sim.vehicle.effects.axes import AXES, turned
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the velocity log turned by s about one of its axes."""
    return c._replace(velocity_rotation=turned(c.velocity_rotation, active.axis, active.size("angle")))


EFFECT = VehicleEffect(
    id="velocity_misalignment",
    title="velocity log mounted askew",
    block="sensor",
    equation="R_s turned by s about one axis",
    parameters=(EffectParameter(name="angle", unit="rad", meaning="of the turn", lower=-0.3, upper=0.3),),
    note="axes as of `imu_misalignment`",
    needs=("axis",),
    choices={"axis": AXES},
    sensing=sensing,
    suspected=(Suspected(sizes={"angle": (0.1, 0.01)}, read_by="velocity", tolerance=0.0075),),
)
