"""Propellers turn the vehicle the other way: the moment -h s Q e of each, h = +1 for a right-handed one.

Q = q n|n| with q from the vehicle's set: the thesis' tables hold no propeller's torque (Table 4.2 a tenth of one,
Table 3.1 three times too much). A set without hands knows no such moment, and says so.
"""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with the moment of all propellers, or of one."""
    s = active.size("share")
    if s == 0.0:
        return c
    chosen = range(c.thrusters) if active.thruster is None else (active.thruster,)
    if unknown := [i for i in chosen if c.hands[i] == 0.0]:
        keys = ", ".join(f"'thrusters.{i}.hand'" for i in unknown)
        needs = "needs the hand, left or right, of each propeller that it acts on"
        raise ValueError(f"key {keys}: missing; the effect reaction_torque {needs}")
    if not c.propeller_torque > 0.0:
        needs = "needs the torque of a propeller per n|n|, above 0"
        raise ValueError(
            f"key 'parameters.reaction_torque': the effect of this name {needs}; found {c.propeller_torque:g}"
        )
    reaction = c.reaction.copy()
    for i in chosen:
        reaction[:, i] -= c.hands[i] * s * c.propeller_torque * c.K_t[:3, i]
    return c._replace(reaction=reaction)


def places(vehicle):  # type: ignore[no-untyped-def]
    """Yield each thruster whose hand is known, and all together where all are, of propellers with a torque."""
    if vehicle.values.get("reaction_torque", 0.0) > 0.0:
        known = [i for i, thruster in enumerate(vehicle.layout) if thruster.turn]
        yield from ({"thruster": i} for i in known)
        if len(known) == len(vehicle.layout):
            yield {}


EFFECT = VehicleEffect(
    id="reaction_torque",
    title="torque of the propellers on the vehicle",
    block="thrusters",
    equation="-h_i s q n|n| e_i",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the propellers' torque that acts", lower=0.0, upper=1.0),
    ),
    note="q is the vehicle's `reaction_torque`: numbers of the torque in a thrusters' set, and the flow, have no part "
    "in it; each propeller that it acts on needs a `hand`",
    may_take=("thruster",),
    body=body,
    suspected=(Suspected(sizes={"share": (0.5, 0.1)}, places=places),),
)
