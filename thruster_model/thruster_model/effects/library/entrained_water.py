"""Water that is accelerated with the rotor: thrust lags behind while the rotor speeds up, leads while it slows down.

Its reaction on the shaft is part of the rotor's inertia. A rotor without inertia has no dn/dt, so nothing is entrained.
"""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def thrust_dynamics(force, n_dot, p, e):  # type: ignore[no-untyped-def]
    """Return T - s dn/dt."""
    return force - e.entrained_water_impulse * n_dot


EFFECT = Effect(
    id="entrained_water",
    title="water set in motion with the rotor",
    block="thrust",
    equation="T - s dn/dt",
    parameters=(
        EffectParameter(name="impulse", unit="N s^2", meaning="per unit of rotor speed", lower=0.0, upper=0.02),
    ),
    note="dn/dt is what all effects of the rotor leave of it, 0 while dry friction holds it",
    hooks={"thrust_dynamics": thrust_dynamics},
    suspected=(Suspected(sizes={"impulse": (0.01, 0.003)}),),
)
