"""Wrong scale of the load cell: an old calibration, another cable."""

from thruster_model.effects.effect import Effect, EffectParameter


def read(values, outputs, dt, rng, share):  # type: ignore[no-untyped-def]
    """Return readings (N,) too large by `share`."""
    return values * (1.0 + share)


EFFECT = Effect(
    id="load_cell_scale",
    title="wrong scale of the load cell",
    block="sensor",
    equation="y (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="by which readings are too large", lower=-0.3, upper=0.3),
    ),
    samples=read,
    channel="thrust torque",
    order=2,
)
