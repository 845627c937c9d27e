"""Two thrusters whose commands are exchanged: each does what the other is told."""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the wires of thrusters i and j exchanged."""
    i, j, s = active.thruster, active.other, active.size("swapped")
    if i == j or s not in (0.0, 1.0):
        raise ValueError(f"thruster_swap: expected two thrusters and 0 or 1; found {i}, {j} and {s}")
    wiring = c.wiring.copy()
    if s == 1.0:
        wiring[[i, j]] = wiring[[j, i]]
    return c._replace(wiring=wiring)


EFFECT = VehicleEffect(
    id="thruster_swap",
    title="two thrusters exchanged",
    block="thrusters",
    equation="u_i and u_j exchanged",
    parameters=(EffectParameter(name="swapped", unit="1", meaning="1: exchanged, 0: as drawn", lower=0.0, upper=1.0),),
    needs=("thruster", "other"),
    body=body,
    suspected=(Suspected(fixed={"swapped": 1.0}, alike=True),),
)
