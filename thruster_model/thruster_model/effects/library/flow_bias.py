"""Offset of the velocimeter that taring does not find."""

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, offset):  # type: ignore[no-untyped-def]
    """Return readings (N,) moved by `offset`."""
    return values + offset


EFFECT = Effect(
    id="flow_bias",
    title="offset of the velocimeter",
    block="sensor",
    equation="y + s",
    parameters=(
        EffectParameter(name="offset", unit="m/s", meaning="of the readings", lower=0.0, upper=0.2, both_signs=True),
    ),
    samples=read,
    channel="axial ambient",
    order=3,
)
