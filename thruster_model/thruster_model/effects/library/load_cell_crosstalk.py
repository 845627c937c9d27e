"""A load cell whose force reading picks up torque."""

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, gain):  # type: ignore[no-untyped-def]
    """Return thrust readings (N,) with `gain` [1/m] times the torque added."""
    return values + gain * outputs["torque"]


EFFECT = Effect(
    id="load_cell_crosstalk",
    title="cross-talk of the load cell",
    block="sensor",
    equation="T + s Q",
    parameters=(
        EffectParameter(
            name="gain", unit="1/m", meaning="from torque to force", lower=0.0, upper=30.0, both_signs=True
        ),
    ),
    samples=read,
    channel="thrust",
    order=2,
)
