"""Offset of the load cell that taring does not find."""

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, offset):  # type: ignore[no-untyped-def]
    """Return readings (N,) moved by `offset`."""
    return values + offset


EFFECT = Effect(
    id="load_cell_bias",
    title="offset of the load cell",
    block="sensor",
    equation="y + s",
    parameters=(
        EffectParameter(name="offset", unit="N", meaning="of the readings", lower=0.0, upper=5.0, both_signs=True),
    ),
    samples=read,
    channel="thrust",
    order=3,
)
