"""A velocimeter whose samples come late: averaging, serial line, another clock.

Between two samples the flow is taken to go in a straight line.
"""

from thruster_model.compilation import equation
from thruster_model.effects.delay_line import delayed, filled, line_floats, remainder
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: whether there was a sample, and those on their way."""
    return 1 + line_floats(e.flow_delay_time, step)


@equation
def sample(memory, x, outputs, step, e):  # type: ignore[no-untyped-def]
    """Return the flow of s before; before the first sample it is taken to be that one."""
    line = memory[1:]
    if memory[0] == 0.0:
        memory[0] = 1.0
        filled(line, x)
    after, before = delayed(line, x)
    return after + remainder(e.flow_delay_time, step) * (before - after)


EFFECT = Effect(
    id="flow_delay",
    title="late readings of the velocimeter",
    block="sensor",
    equation="y(t) = U(t - s), or v(t - s) where that is measured",
    parameters=(EffectParameter(name="time", unit="s", meaning="by which readings are late", lower=0.0, upper=1.5),),
    sample=sample,
    floats=floats,
    channel="axial ambient",
    order=1,
    twins=("log_alignment:flow",),
)
