"""A drive that is weaker than its input map says (a lower supply voltage, another driver); negative: stronger."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def drive(drive, n, heat, supply, p, e):  # type: ignore[no-untyped-def]
    """Return gamma(u) (1 - s)."""
    return drive * (1.0 - e.throttle_gain_share)


EFFECT = Effect(
    id="throttle_gain",
    title="gain of the throttle",
    block="command",
    equation="gamma(u) (1 - s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="of the drive lost", lower=0.0, upper=0.5, both_signs=True),
    ),
    hooks={"drive": drive},
    suspected=(Suspected(sizes={"share": (0.25, 0.05)}),),
)
