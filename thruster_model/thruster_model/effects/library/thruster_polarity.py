"""A thruster wired the wrong way round: a positive command drives it backwards."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def sample(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Return the command [V], the other way round at `reversed` 1, as it is at 0."""
    return u * (1.0 - 2.0 * e.thruster_polarity_reversed)


EFFECT = Effect(
    id="thruster_polarity",
    title="thruster wired the wrong way round",
    block="command",
    equation="u = -u_c",
    parameters=(
        EffectParameter(name="reversed", unit="1", meaning="1: reversed, 0: as it should be", lower=1.0, upper=1.0),
    ),
    note="a sensor that is turned round reads the same, and is no effect: with one sensor alone look which it is; "
    "where all of them run backwards it is the thruster",
    sample=sample,
    order=0,
    suspected=(Suspected(fixed={"reversed": 1.0}),),
)
