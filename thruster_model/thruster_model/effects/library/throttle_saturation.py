"""The device cuts commands off earlier than it is said to."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def sample(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Return the command [V] limited to +- s."""
    s = e.throttle_saturation_limit
    return min(max(u, -s), s)


EFFECT = Effect(
    id="throttle_saturation",
    title="limit of the throttle",
    block="command",
    equation="|u| <= s",
    parameters=(
        EffectParameter(name="limit", unit="V", meaning="of the throttle", lower=1.0, upper=5.0, neutral=float("inf")),
    ),
    sample=sample,
    order=3,
    search="limit",
    suspected=(Suspected(sizes={"limit": (1.0, 2.0)}, grid=(4.0, 3.0, 2.5, 2.0, 1.5, 1.0)),),
)
