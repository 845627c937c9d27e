"""The device ramps its output more slowly than it is said to."""

from thruster_model.compilation import compiled
from thruster_model.effects.effect import Effect, EffectParameter


@compiled
def _limited(commands, largest):  # type: ignore[no-untyped-def]
    followed = commands.copy()
    u = 0.0
    for k in range(commands.size):
        u += min(max(commands[k] - u, -largest), largest)
        followed[k] = u
    return followed


def rate_limited(commands, dt, rate):  # type: ignore[no-untyped-def]
    """Return commands (N,) followed at most at `rate` [V/s], starting from 0 V."""
    return commands if rate == float("inf") else _limited(commands, rate * dt)


EFFECT = Effect(
    id="throttle_rate_limit",
    title="slow ramps of the throttle",
    block="command",
    equation="|du/dt| <= s",
    parameters=(
        EffectParameter(name="rate", unit="V/s", meaning="largest one", lower=2.0, upper=100.0, neutral=float("inf")),
    ),
    samples=rate_limited,
    order=4,
)
