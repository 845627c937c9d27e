"""Offset of the velocimeter that taring does not find."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the reading moved by s."""
    return x + e.flow_bias_offset


EFFECT = Effect(
    id="flow_bias",
    title="offset of the velocimeter",
    block="sensor",
    equation="y + s",
    parameters=(
        EffectParameter(name="offset", unit="m/s", meaning="of the readings", lower=0.0, upper=0.2, both_signs=True),
    ),
    sample=sample,
    channel="axial ambient",
    order=3,
)
