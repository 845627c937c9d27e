"""The converter behind the command has few steps."""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def sample(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Return the command [V] rounded to a multiple of s."""
    s = e.command_quantization_step
    return s * np.round(u / s)


EFFECT = Effect(
    id="command_quantization",
    title="coarse steps of the command",
    block="command",
    equation="u = s round(u_c / s)",
    parameters=(EffectParameter(name="step", unit="V", meaning="of the converter", lower=0.0, upper=0.5),),
    note="a command that goes on straight lines is rounded every few milliseconds along them",
    sample=sample,
    order=2,
    search="command_lattice",
    tries=(16,),
)
