"""One thruster runs in the wake of another: thruster `other` loses thrust while `thruster` pushes, either way."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the share of j = `other` that a newton of i = `thruster` costs."""
    i, j, s = active.thruster, active.other, active.size("share")
    if i == j:
        raise ValueError(f"key 'effects.thruster_interaction.other': expected another thruster; found {j} twice")
    if s == 0.0:
        return c
    if not c.full_thrust[i] > 0.0:
        raise ValueError(f"thruster_interaction: expected the full thrust of thruster {i}; found {c.full_thrust[i]} N")
    matrix = c.interaction.copy()
    matrix[i, j] += s / c.full_thrust[i]
    return c._replace(interaction=matrix)


EFFECT = VehicleEffect(
    id="thruster_interaction",
    title="wake of a thruster on another",
    block="thrusters",
    equation="T_j (1 - s |T_i| / T_max)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of thrust j lost with i at full", lower=0.0, upper=0.6),
    ),
    note="thruster i pushes, thruster j = `other` loses. T_max is the thrust of i at 5 V, settled in still water, by "
    "the set as stated",
    needs=("thruster", "other"),
    body=body,
    suspected=(Suspected(sizes={"share": (0.3, 0.1)}),),
)
