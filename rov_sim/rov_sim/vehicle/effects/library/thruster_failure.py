"""A thruster that fails: it turns and gives no thrust, or its rotor has stopped.

`no_thrust` is `thrust_loss` of 1. A stopped rotor does not turn; what flows through it drags.
"""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with thruster i without thrust by that share, or with its rotor stopped."""
    i, s = active.thruster, active.size("failed")
    if active.kind == "no_thrust":
        scale = c.thrust_scale.copy()
        scale[i] *= 1.0 - s
        return c._replace(thrust_scale=scale)
    if s not in (0.0, 1.0):
        raise ValueError(f"key 'effects.thruster_failure.failed': a rotor is stopped, 1, or not, 0; found {s}")
    turning = c.turning.copy()
    turning[i] *= 1.0 - s
    return c._replace(turning=turning)


EFFECT = VehicleEffect(
    id="thruster_failure",
    title="failure",
    block="thrusters",
    equation="T = 0, or n = 0",
    parameters=(EffectParameter(name="failed", unit="1", meaning="1: failed, 0: well", lower=0.0, upper=1.0),),
    note="with `no_thrust` the rotor keeps turning and T drives v as before; with `stopped` n = 0, and what flows "
    "through drags",
    needs=("thruster", "kind"),
    choices={"kind": ("no_thrust", "stopped")},
    twins=("thrust_loss",),
    body=body,
    suspected=(Suspected(fixed={"failed": 1.0}, only={"kind": ("stopped",)}, begins=True),),
)
