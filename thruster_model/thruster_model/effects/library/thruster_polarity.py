"""A thruster wired the wrong way round: a positive command drives it backwards."""

from thruster_model.effects.effect import Effect, EffectParameter


def wired(commands, dt, reversed):  # type: ignore[no-untyped-def]
    """Return commands (N,), the other way round at `reversed` 1, as they are at 0."""
    return commands * (1.0 - 2.0 * reversed)


EFFECT = Effect(
    id="thruster_polarity",
    title="thruster wired the wrong way round",
    block="command",
    equation="u = -u_c",
    parameters=(
        EffectParameter(name="reversed", unit="1", meaning="1: reversed, 0: as it should be", lower=1.0, upper=1.0),
    ),
    samples=wired,
    order=0,
)
