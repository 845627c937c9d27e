"""A tachometer behind a smoothing filter."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: whether there was a sample, the true speed then, the reading."""
    return 3


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the rotor speed behind the lag, exactly for a speed that goes in straight lines from sample to sample."""
    last, read = (memory[1], memory[2]) if memory[0] else (x, x)
    s = e.tach_lag_time
    keep = np.exp(-step / s)
    ahead = 1.0 - (1.0 - keep) * s / step
    memory[0], memory[1], memory[2] = 1.0, x, ahead * x + (1.0 - keep - ahead) * last + keep * read
    return memory[2]


EFFECT = Effect(
    id="tach_lag",
    title="lag of the tachometer",
    block="sensor",
    equation="dy/dt = (n - y) / s",
    parameters=(EffectParameter(name="time", unit="s", meaning="constant of the lag", lower=0.0, upper=0.4),),
    sample=sample,
    floats=floats,
    channel="speed",
    order=1,
    suspected=(Suspected(sizes={"time": (0.2, 0.05)}, read_by="tachometer"),),
)
