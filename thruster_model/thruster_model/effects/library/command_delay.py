"""Commands arrive late: transport on the line, a computing period, a driver that answers at its next turn."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def delayed(commands, dt, time):  # type: ignore[no-untyped-def]
    """Return commands (N,), held for `dt` [s] each, `time` [s] later; the mean where one changes within a period."""
    whole = int(np.floor(time / dt))
    share = time / dt - whole
    padded = np.concatenate((np.full(whole + 1, 0.0), commands))[: commands.size + 1]
    return (1.0 - share) * padded[1:] + share * padded[:-1] if share > 0.0 else padded[1:]


EFFECT = Effect(
    id="command_delay",
    title="delay of the command",
    block="command",
    equation="u(t) = u_c(t - s)",
    parameters=(EffectParameter(name="time", unit="s", meaning="by which commands are late", lower=0.0, upper=0.25),),
    samples=delayed,
    order=1,
    twins=("log_alignment",),
)
