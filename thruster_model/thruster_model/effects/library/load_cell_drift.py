"""A load cell that creeps or warms up."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: how many samples there have been."""
    return 1


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the thrust reading, which has wandered off at s [N/s] since the start of the run."""
    time = step * memory[0]
    memory[0] += 1.0
    return x + e.load_cell_drift_rate * time


EFFECT = Effect(
    id="load_cell_drift",
    title="drift of the load cell",
    block="sensor",
    equation="y + s t",
    parameters=(
        EffectParameter(name="rate", unit="N/s", meaning="of the reading", lower=0.0, upper=0.1, both_signs=True),
    ),
    note="t is the time since the run's first command",
    sample=sample,
    floats=floats,
    channel="thrust",
    order=3,
    steady=False,
)
