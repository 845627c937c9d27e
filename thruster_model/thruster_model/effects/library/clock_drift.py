"""The sensors' clock runs fast or slow against the commands'."""

from thruster_model.effects.effect import Effect, EffectParameter, Suspected


def logged(signal, time, values, rng, rate):  # type: ignore[no-untyped-def]
    """Return (stamps [s], values) of a clock that gains `rate` seconds a second."""
    return time * (1.0 + rate), values


def taken(signal, stamps, rate):  # type: ignore[no-untyped-def]
    """Return when samples with these stamps were taken [s]."""
    return stamps / (1.0 + rate)


EFFECT = Effect(
    id="clock_drift",
    title="drift of the sensors' clock",
    block="log",
    equation="stamp (1 + s)",
    parameters=(
        EffectParameter(
            name="rate", unit="s/s", meaning="by which the clock gains", lower=0.0, upper=0.01, both_signs=True
        ),
    ),
    note="of all sensors alike, against the log of commands; both clocks agree as a run starts",
    logged=logged,
    taken=taken,
    channel="speed axial ambient thrust torque",
    order=2,
    suspected=(Suspected(sizes={"rate": (0.002, 0.0003)}),),
)
