"""A compass beside the thrusters' cables: the heading is off by what they draw."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with a yaw s [rad] larger at the current of all thrusters at full, in proportion."""
    return c._replace(magnetic_yaw=c.magnetic_yaw + active.size("angle"))


EFFECT = VehicleEffect(
    id="magnetic_disturbance",
    title="heading disturbed by the thrusters' current",
    block="sensor",
    equation="psi + s sum i_k / (sum i_k with all thrusters at full), i_k as of the supply",
    parameters=(
        EffectParameter(name="angle", unit="rad", meaning="of yaw, all thrusters at full", lower=-0.5, upper=0.5),
    ),
    sensing=sensing,
    suspected=(Suspected(sizes={"angle": (0.2, 0.02)}, read_by="attitude"),),
)
