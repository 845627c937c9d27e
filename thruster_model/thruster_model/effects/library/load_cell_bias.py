"""Offset of the load cell that taring does not find."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the reading moved by s."""
    return x + e.load_cell_bias_offset


EFFECT = Effect(
    id="load_cell_bias",
    title="offset of the load cell",
    block="sensor",
    equation="y + s",
    parameters=(
        EffectParameter(name="offset", unit="N", meaning="of the readings", lower=0.0, upper=5.0, both_signs=True),
    ),
    sample=sample,
    channel="thrust",
    order=3,
)
