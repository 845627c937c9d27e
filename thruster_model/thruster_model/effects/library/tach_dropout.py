"""A tachometer that sees nothing at low speed."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the rotor speed, 0 where its magnitude is below s [rad/s]."""
    return 0.0 if abs(x) < e.tach_dropout_threshold else x


EFFECT = Effect(
    id="tach_dropout",
    title="tachometer blind at low speed",
    block="sensor",
    equation="y = 0 for |n| < s",
    parameters=(
        EffectParameter(name="threshold", unit="rad/s", meaning="below which it reads 0", lower=0.0, upper=40.0),
    ),
    sample=sample,
    channel="speed",
    order=4,
    search="stairs",
    tries=(16,),
    trace="zeros",
)
