"""Motion along one axis drags along another: the first axis is pushed by motion along the second."""

from rov_sim.vehicle.effects.body_axes import AXIS_PAIRS, axis_pair
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with s more in that entry of D_L."""
    (a, b), matrix = axis_pair(active.axis), c.D_L.copy()
    matrix[a, b] += active.size("size")
    return c._replace(D_L=matrix)


EFFECT = VehicleEffect(
    id="drag_coupling",
    title="coupling of two axes by drag",
    block="body",
    equation="D_ab = s (linear)",
    parameters=(
        EffectParameter(name="size", unit="N s/m, N s or N m s", meaning="entry more", lower=-100.0, upper=100.0),
    ),
    needs=("axis",),
    choices={"axis": AXIS_PAIRS},
    body=body,
)
