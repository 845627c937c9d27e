"""Water that moves with the body along one axis pushes it along another: a hull that is not symmetric."""

from rov_sim.vehicle.effects.body_axes import AXIS_PAIRS, coupled
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with s more in both entries of M_A beside the diagonal."""
    return c._replace(M_A=coupled(c.M_A, active.axis, active.size("size")))


EFFECT = VehicleEffect(
    id="added_mass_coupling",
    title="coupling of two axes by added mass",
    block="body",
    equation="M_A,ab + s, M_A,ba + s",
    parameters=(
        EffectParameter(name="size", unit="kg, kg m or kg m^2", meaning="of the entries more", lower=-20.0, upper=20.0),
    ),
    note="the order of the two axes does not matter",
    needs=("axis",),
    choices={"axis": AXIS_PAIRS},
    body=body,
    suspected=(
        Suspected(sizes={"size": (1.5, 0.12)}, only={"axis": ("surge-heave",)}),
        Suspected(
            sizes={"size": (0.375, 0.03)}, only={"axis": ("surge-pitch", "sway-roll", "sway-yaw", "heave-pitch")}
        ),
    ),
)
