"""A load cell whose force reading picks up torque."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the thrust reading with s times the torque added."""
    return x + e.load_cell_crosstalk_gain * outputs.torque


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
    note="Q is that of the propeller, with all effects on it",
    sample=sample,
    channel="thrust",
    reads="torque",
    order=2,
)
