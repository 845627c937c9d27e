"""One supply for all thrusters: its voltage falls with the current of them all.

V = V_0 (1 - s sum i_k / N), i_k in proportion to |gamma||n| at the nominal supply, 1 at full throttle and speed: s is
the share lost with all thrusters at full.
"""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with that share of the supply lost under full load."""
    return c._replace(sag=c.sag + active.size("share"))


EFFECT = VehicleEffect(
    id="supply_sag",
    title="sag of the shared supply",
    block="thrusters",
    equation="V = V_0 - R sum i_k, gamma V / V_0",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the voltage lost, all at full", lower=0.0, upper=0.5),
    ),
    note="R = s V_0 / N for N thrusters; V_0 and i_k: [supply](#supply). It takes the place of the effect of this "
    "name that a single thruster has",
    body=body,
    suspected=(Suspected(sizes={"share": (0.25, 0.05)}),),
)
