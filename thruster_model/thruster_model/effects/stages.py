"""The library of effects, composed: for each stage of the plant one function that calls every effect's hook there.

`EffectValues` holds a number for each parameter of each effect; its neutral values change nothing, bit for bit. With
`NO_EFFECTS` in its place the hooks are not even compiled in.
"""

import importlib
import pkgutil
from collections import namedtuple
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from numba.extending import overload

from thruster_model.compilation import BARE, equation
from thruster_model.effects import library
from thruster_model.effects.effect import STAGES, Effect

__all__ = [
    "LIBRARY",
    "NEUTRAL",
    "NO_EFFECTS",
    "EffectValues",
    "NoEffects",
    "defined",
    "effect_values",
    "in_stage",
    "is_on",
    "stage",
    "switched",
]


def _discovered() -> dict[str, Effect]:
    names = sorted(module.name for module in pkgutil.iter_modules(library.__path__))
    found = [importlib.import_module(f"{library.__name__}.{name}").EFFECT for name in names]
    return {effect.id: effect for effect in found}


LIBRARY: dict[str, Effect] = _discovered()
"""All effects of the thruster by identifier."""

_IN_TIME = [effect for effect in LIBRARY.values() if effect.logged is None]
_FIELDS = {effect.field_of(p.name): p.neutral for effect in _IN_TIME for p in effect.parameters}
EffectValues: Any = namedtuple("EffectValues", tuple(_FIELDS), defaults=list(_FIELDS.values()), module=__name__)  # type: ignore[misc]
NoEffects: Any = namedtuple("NoEffects", ("nothing",), module=__name__)
NEUTRAL = EffectValues()
NO_EFFECTS = NoEffects(0.0)


def effect_values(sizes: Mapping[str, Mapping[str, float]]) -> Any:
    """Return the values for effects, by identifier and parameter; what is not named is neutral.

    Effects of the log are passed over: they act on what has been recorded, see `effects.active`.

    Raises:
        KeyError: an effect or a parameter that the library does not have.
    """
    given = {}
    for name, parameters in sizes.items():
        effect = LIBRARY[name]
        known = {p.name for p in effect.parameters}
        for parameter, value in parameters.items():
            if parameter not in known:
                raise KeyError(f"{name}.{parameter}")
            if effect.logged is None:
                given[effect.field_of(parameter)] = float(value)
    return EffectValues(**given)


def in_stage(name: str) -> list[Effect]:
    """Return the effects that act in a stage, in their order."""
    return [effect for effect in sorted(_IN_TIME, key=lambda effect: effect.order) if name in effect.hooks]


def stage(name: str) -> Callable[..., Any]:
    """Return the function of a stage, for Python and for kernels, as `STAGES` declares it.

    A kernel asks once whether any effect of the stage is on, then of each, so that those which are not cost nothing;
    in Python, where a field may be an array, all hooks are called.
    """
    arguments = STAGES[name]
    first = arguments[0]
    here = in_stage(name)
    hooks = {f"hook_{effect.id}": effect.hooks[name] for effect in here}
    calls = [f"{first} = hook_{effect.id}({', '.join(arguments)})" for effect in here]
    on = [is_on(effect) for effect in here]
    guarded = [f"    if {each}: {call}" for each, call in zip(on, calls, strict=True)]
    chained = defined("chained", arguments, calls, first, hooks)
    chosen = equation(defined("chosen", arguments, [f"if {' | '.join(on)}:", *guarded] if on else [], first, hooks))
    return switched(name, arguments, first, chained, chosen)


def is_on(effect: Effect) -> str:
    """Return the expression that tells in a kernel whether an effect is on."""
    d = effect.parameters[0]
    return f"(e.{effect.field_of(d.name)} != {'inf' if d.neutral == float('inf') else repr(d.neutral)})"


def defined(
    name: str, arguments: Iterable[str], lines: Iterable[str], result: str, names: Mapping[str, Any]
) -> Callable[..., Any]:
    """Return a function of these lines; `names`: what stands in them."""
    namespace = {"inf": float("inf"), **names}
    exec("\n    ".join([f"def {name}({', '.join(arguments)}):", *lines, f"return {result}"]), namespace)
    return namespace[name]  # type: ignore[no-any-return]


def switched(
    name: str, arguments: Iterable[str], result: str, python: Callable[..., Any], kernel: Callable[..., Any]
) -> Callable[..., Any]:
    """Return a function of effects `e` that is `python` or `kernel`; with `NO_EFFECTS` neither, but `result` alone."""
    told = ", ".join(arguments)
    plain = equation(defined("plain", arguments, [], result, {}))
    names = {"NoEffects": NoEffects, "python": python}
    function = defined(name, arguments, [f"if type(e) is NoEffects: return {result}"], f"python({told})", names)
    kernels = {"equations": lambda kind: plain if kind is NoEffects else kernel}
    lines = ["function = equations(e.instance_class)", f"implementation = lambda {told}: function({told})"]
    overload(function, jit_options=BARE)(defined("compiled", arguments, lines, "implementation", kernels))
    return function
