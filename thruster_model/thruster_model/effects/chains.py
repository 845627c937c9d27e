"""What effects do to a command on its way to the plant and to what a sensor reads, sample by sample.

Between a command and the plant effects follow each other as in the device: its wiring, the converter's steps, its
limits, the line's delay. Behind the plant each sensor has a chain: its dynamics, then scale and offset, then its
converter. A chain is called once every `step` seconds from the beginning of a run on. What it remembers lies in a slice
of floats, all zero at the beginning; with `NO_EFFECTS` it needs none, and nothing is compiled in.

    memory = np.zeros(command_memory(step, e))        u, late, then = command_split(memory, u_commanded, step, e)
    memory = np.zeros(sensor_memory("speed", step, e))        y = speed_sample(memory, n, outputs, step, e)
"""

from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from thruster_model.compilation import equation, inlined
from thruster_model.effects.effect import ON_COMMAND, ON_SENSOR, Effect
from thruster_model.effects.stages import LIBRARY, defined, is_on, stage, switched

__all__ = [
    "SENSED",
    "Outputs",
    "ambient_alters",
    "ambient_sample",
    "axial_alters",
    "axial_sample",
    "command_begin",
    "command_memory",
    "command_split",
    "in_chain",
    "sensor_memory",
    "sensor_seed",
    "speed_alters",
    "speed_sample",
    "thrust_alters",
    "thrust_sample",
    "torque_alters",
    "torque_sample",
]


class Outputs(NamedTuple):
    """What there is to be sensed: n [rad/s], v, U [m/s], T [N], Q [N m]; as in `identification.experiment.SIGNALS`."""

    speed: float
    axial: float
    ambient: float
    thrust: float
    torque: float


SENSED = Outputs._fields


def _chain(name: str, arguments: tuple[str, ...], first: str, effects: Iterable[Effect], calls: str) -> Any:
    """Return a function of (memory, ..., step, e) that calls each effect that is on with its own slice of memory.

    `calls`: with `{id}` for the effect's identifier and `own` for its memory.
    """
    lines, names = ["at = 0"], {}
    for effect in effects:
        names[f"sample_{effect.id}"] = effect.sample
        names[f"begin_{effect.id}"] = effect.begin or _nothing
        size = "0"
        if effect.floats is not None:
            names[f"floats_{effect.id}"] = effect.floats
            size = f"floats_{effect.id}(step, e)"
        call = calls.format(id=effect.id)
        lines += [f"if {is_on(effect)}:", f"    size = {size}", "    own = memory[at : at + size]", f"    {call}"]
        lines += ["    at = at + size"]
    chosen = inlined(defined("chosen", arguments, lines, first, names))
    return switched(name, arguments, first, chosen, chosen)


def _sizes(name: str, effects: Iterable[Effect], more: int) -> Callable[..., int]:
    """Return the function of (step, e) that tells how many floats a chain remembers: none where all effects are off.

    `more`: floats that the chain wants beside those of its effects.
    """
    effects = list(effects)
    names = {f"floats_{effect.id}": effect.floats for effect in effects if effect.floats is not None}
    lines = [f"size = {more} if {_any_on(effects)} else 0"]
    for effect in effects:
        if effect.floats is not None:
            lines.append(f"if {is_on(effect)}: size = size + floats_{effect.id}(step, e)")
    chosen = equation(defined("chosen", ("step", "e"), lines, "size", names))
    return switched(name, ("step", "e"), "0", chosen, chosen)  # type: ignore[no-any-return]


def _any_on(effects: Iterable[Effect]) -> str:
    """Return the expression that tells in a kernel whether any of the effects is on."""
    return " | ".join(map(is_on, effects)) or "False"


@equation
def _nothing(memory, u, step, e):  # type: ignore[no-untyped-def]
    pass


def in_chain(block: str, signal: str = "") -> list[Effect]:
    """Return the effects of the chain of the "command", or of a "sensor" of a signal, in their order."""
    effects = [
        e for e in LIBRARY.values() if e.sample and e.block == block and (not signal or signal in e.channel.split())
    ]
    return sorted(effects, key=lambda effect: effect.order)


_wired = _chain("wired", ON_COMMAND, "u", in_chain("command"), "u = sample_{id}(own, u, step, e)")
_begin = _chain("begin", ON_COMMAND, "u", in_chain("command"), "begin_{id}(own, u, step, e)")
_late = stage("late")
command_memory = _sizes("command_memory", in_chain("command"), 1)


@inlined
def command_split(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Return (throttle [V], for how long from the beginning of the step [s], throttle then) that reaches the plant."""
    if memory.size == 0:
        return u, 0.0, u
    before = memory[0]
    memory[0] = _wired(memory[1:], u, step, e)
    return before, _late(0.0, step, e), memory[0]


@equation
def command_begin(memory, u, step, e):  # type: ignore[no-untyped-def]
    """Set the memory as it is where the throttle u [V] has reached the plant for long."""
    if memory.size > 0:
        memory[:] = 0.0
        memory[0] = u
        _begin(memory[1:], u, step, e)


def _sensor(signal: str) -> Any:
    return _chain(
        f"{signal}_sample", ON_SENSOR, "x", in_chain("sensor", signal), "x = sample_{id}(own, x, outputs, step, e)"
    )


def _alters(signal: str) -> Any:
    """Return the function of `e` that tells whether an effect of a sensor's chain is on."""
    chosen = equation(defined("chosen", ("e",), [], _any_on(in_chain("sensor", signal)), {}))
    return switched(f"{signal}_alters", ("e",), "False", chosen, chosen)


speed_sample, axial_sample, ambient_sample = _sensor("speed"), _sensor("axial"), _sensor("ambient")
thrust_sample, torque_sample = _sensor("thrust"), _sensor("torque")
speed_alters, axial_alters, ambient_alters = _alters("speed"), _alters("axial"), _alters("ambient")
thrust_alters, torque_alters = _alters("thrust"), _alters("torque")
_SENSOR_SIZES = {signal: _sizes(f"{signal}_memory", in_chain("sensor", signal), 0) for signal in SENSED}


def sensor_memory(signal: str, step: float, e: Any) -> int:
    """Return how many floats the sensor of a signal remembers."""
    return int(_SENSOR_SIZES[signal](step, e))


def sensor_seed(memory: Any, signal: str, seed: int, step: float, e: Any) -> None:
    """Set the seed, 1 or more, of effects that scatter; without one they do nothing."""
    at = 0
    for effect in in_chain("sensor", signal):
        size = effect.parameters[0]
        if memory.size and effect.floats is not None and getattr(e, effect.field_of(size.name)) != size.neutral:
            if effect.draws:
                memory[at] = float(seed)
            at += effect.floats(step, e)
