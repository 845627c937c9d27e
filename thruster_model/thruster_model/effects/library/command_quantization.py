"""The converter behind the command has few steps."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def quantized(commands, dt, step):  # type: ignore[no-untyped-def]
    """Return commands (N,) rounded to multiples of `step` [V]."""
    return commands if step == 0.0 else step * np.round(commands / step)


EFFECT = Effect(
    id="command_quantization",
    title="coarse steps of the command",
    block="command",
    equation="u = s round(u_c / s)",
    parameters=(EffectParameter(name="step", unit="V", meaning="of the converter", lower=0.0, upper=0.5),),
    samples=quantized,
    order=2,
)
