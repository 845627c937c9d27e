"""Commands arrive late: transport on the line, a computing period, a driver that answers at its next turn.

Exact for any delay: `sample` returns the command of whole steps before, and `late` how long into a step the one before
that is still held: steppers split their step there. What else happens to a command
does not depend on time, so the delay may come last.
"""

from thruster_model.compilation import equation
from thruster_model.effects.delay_line import delayed, filled, line_floats, remainder
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def floats(step, e):  # type: ignore[no-untyped-def]
    """Return the size of the memory: the commands on their way."""
    return line_floats(e.command_delay_time, step)


@equation
def begin(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Let the memory be as if the command had been u [V] for long."""
    filled(memory, u)


@equation
def sample(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Return the command [V] of whole steps before."""
    return delayed(memory, u)[0]


@equation
def late(late, step, e):  # type: ignore[no-untyped-def]
    """Return how long into each step [s] the command of the step before is still held."""
    return step * remainder(e.command_delay_time, step)


EFFECT = Effect(
    id="command_delay",
    title="delay of the command",
    block="command",
    equation="u(t) = u_c(t - s)",
    parameters=(EffectParameter(name="time", unit="s", meaning="by which commands are late", lower=0.0, upper=0.25),),
    hooks={"late": late},
    sample=sample,
    floats=floats,
    begin=begin,
    order=5,
    twins=("log_alignment:throttle",),
    suspected=(Suspected(sizes={"time": (0.1, 0.02)}),),
)
