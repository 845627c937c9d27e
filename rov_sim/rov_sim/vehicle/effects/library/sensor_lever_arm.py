"""A sensor that sits elsewhere than is believed."""

from rov_sim.vehicle.effects.axes import AXES, moved
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with one of imu, velocity, depth moved by s [m] along an axis of the body."""
    place = f"{active.sensor}_position"
    return c._replace(**{place: moved(getattr(c, place), active.axis, active.size("offset"))})


EFFECT = VehicleEffect(
    id="sensor_lever_arm",
    title="sensor in another place",
    block="sensor",
    equation="r + s along one axis",
    parameters=(EffectParameter(name="offset", unit="m", meaning="of the place", lower=-0.5, upper=0.5),),
    needs=("sensor", "axis"),
    choices={"axis": AXES, "sensor": ("imu", "velocity", "depth")},
    sensing=sensing,
    suspected=(Suspected(sizes={"offset": (0.2, 0.03)}, tolerance=0.01),),
)
