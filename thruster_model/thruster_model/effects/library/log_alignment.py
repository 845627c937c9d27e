"""Stamps of one channel are late: another clock, another sample convention, a buffer on the way."""

from thruster_model.effects.effect import Effect, EffectParameter, Suspected


def logged(signal, time, values, rng, throttle, speed, flow, load):  # type: ignore[no-untyped-def]
    """Return (stamps [s], values), stamps too late by the shift [s] of the signal's channel."""
    return time + _late(signal, throttle, speed, flow, load), values


def taken(signal, stamps, throttle, speed, flow, load):  # type: ignore[no-untyped-def]
    """Return when samples with these stamps were taken [s]."""
    return stamps - _late(signal, throttle, speed, flow, load)


def _late(signal, throttle, speed, flow, load):  # type: ignore[no-untyped-def]
    own = {"throttle": throttle, "speed": speed, "axial": flow, "ambient": flow, "thrust": load, "torque": load}
    return own[signal]


def _shift(name: str, of: str) -> EffectParameter:
    return EffectParameter(
        name=name, unit="s", meaning=f"of the stamps of {of}", lower=0.0, upper=0.12, both_signs=True
    )


EFFECT = Effect(
    id="log_alignment",
    title="late stamps of one channel",
    block="log",
    equation="stamp + s",
    parameters=(
        _shift("throttle", "the throttle"),
        _shift("speed", "the tachometer"),
        _shift("flow", "the velocimeter"),
        _shift("load", "the load cell"),
    ),
    logged=logged,
    taken=taken,
    order=1,
    apart=True,
    suspected=(Suspected(sizes={"throttle": (0.05, 0.001)}, lower={"throttle": 0.0}),),
)
