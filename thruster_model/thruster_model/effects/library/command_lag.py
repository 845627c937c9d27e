"""A first-order lag between command and motor: a filter in the driver."""

import numpy as np

from thruster_model.effects.effect import Effect, EffectParameter


def lagged(commands, dt, time):  # type: ignore[no-untyped-def]
    """Return commands (N,) behind a first-order lag of `time` [s], exactly for commands held for `dt` [s]; means."""
    from scipy.signal import lfilter  # a quarter of a second to import

    if time == 0.0:
        return commands
    keep = np.exp(-dt / time)
    # The mean over a period of the lag's answer: it starts it at y and ends it at keep y + (1 - keep) u.
    ends = lfilter([1.0 - keep], [1.0, -keep], commands)
    starts = np.concatenate(([0.0], ends[:-1]))
    return commands + (starts - commands) * (1.0 - keep) * time / dt


EFFECT = Effect(
    id="command_lag",
    title="lag of the command",
    block="command",
    equation="du/dt = (u_c - u) / s",
    parameters=(EffectParameter(name="time", unit="s", meaning="constant of the lag", lower=0.0, upper=0.4),),
    samples=lagged,
    order=5,
)
