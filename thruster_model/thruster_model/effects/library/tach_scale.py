"""Wrong scale of the tachometer: an old calibration, another cable."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the reading too large by the share s."""
    return x * (1.0 + e.tach_scale_share)


EFFECT = Effect(
    id="tach_scale",
    title="wrong scale of the tachometer",
    block="sensor",
    equation="y (1 + s)",
    parameters=(
        EffectParameter(name="share", unit="1", meaning="by which readings are too large", lower=-0.3, upper=0.3),
    ),
    sample=sample,
    channel="speed",
    order=2,
    suspected=(Suspected(sizes={"share": (0.15, 0.03)}, read_by="tachometer", watched=(-0.3, 0.3)),),
)
