"""More friction in proportion to speed than the parameters say: stiff grease, a cold motor; negative sizes are less.

Only k_n n grows, not a load in n|n|. A set with k_n = 0 knows no such friction, so nothing happens to it.
"""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt - s k_n n."""
    return n_dot - e.viscous_friction_share * p.k_n * n


EFFECT = Effect(
    id="viscous_friction",
    title="viscous friction of the rotor",
    block="rotor",
    equation="k_n (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of k_n in addition", lower=0.0, upper=0.8, both_signs=True),
    ),
    hooks={"rotor": rotor},
    suspected=(Suspected(sizes={"share": (0.4, 0.05)}),),
)
