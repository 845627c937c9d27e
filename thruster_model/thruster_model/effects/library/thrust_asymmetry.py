"""A propeller that pushes less backwards than forwards, as its shape tells; negative sizes push more backwards."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s) for n < 0, torque as it is."""
    force, moment = loads
    return force * (1.0 - e.thrust_asymmetry_share * (n < 0.0)), moment


EFFECT = Effect(
    id="thrust_asymmetry",
    title="asymmetry of the thrust",
    block="thrust",
    equation="T (1 - s) for n < 0",
    parameters=(
        EffectParameter(
            name="share", unit="1", meaning="of the thrust lost in reverse", lower=0.0, upper=0.5, both_signs=True
        ),
    ),
    hooks={"loads": loads},
    suspected=(Suspected(sizes={"share": (0.25, 0.05)}),),
)
