"""Spikes of an acoustic velocimeter: bubbles, too few echoes, velocities that wrap."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter
from thruster_model.effects.scatter import normal, uniform

SIZE = 0.3  # m/s


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: the seed, and how many samples there have been."""
    return 2


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the flow reading, with a spike of 0.3 m/s standard deviation in a share s of the samples."""
    count = memory[1]
    memory[1] += 1.0
    if memory[0] == 0.0 or uniform(memory[0], 3.0 * count) >= e.flow_spikes_share:
        return x
    return x + SIZE * normal(uniform(memory[0], 3.0 * count + 1.0), uniform(memory[0], 3.0 * count + 2.0))


EFFECT = Effect(
    id="flow_spikes",
    title="spikes of the velocimeter",
    block="sensor",
    equation="y + spikes of std 0.3 m/s in a share s of the samples",
    parameters=(EffectParameter(name="share", unit="1", meaning="of samples with a spike", lower=0.0, upper=0.3),),
    sample=sample,
    floats=floats,
    draws=True,
    channel="axial ambient",
    order=5,
    search="log",
    trace="spikes",
)
