"""Stamps of one channel are late: another clock, another sample convention, a buffer on the way."""

from thruster_model.effects.effect import Effect, EffectParameter


def logged(signal, time, values, rng, throttle, speed, flow, load):  # type: ignore[no-untyped-def]
    """Return (stamps [s], values), stamps too late by the shift [s] of the signal's channel."""
    late = {"throttle": throttle, "speed": speed, "axial": flow, "ambient": flow, "thrust": load, "torque": load}
    return time + late[signal], values


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
    samples=logged,
    order=1,
    twins=("command_delay", "flow_delay"),
)
