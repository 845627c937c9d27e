"""The library of effects, composed: for each stage of the plant one function that calls every effect's hook there.

`EffectValues` holds a number for each parameter of each effect; its neutral values change nothing, bit for bit. With
`NO_EFFECTS` in its place the hooks are not even compiled in.
"""

import importlib
import pkgutil
from collections import namedtuple
from collections.abc import Callable, Mapping
from typing import Any

from numba.extending import overload

from thruster_model.compilation import equation
from thruster_model.effects import library
from thruster_model.effects.effect import STAGES, Effect

__all__ = ["LIBRARY", "NEUTRAL", "NO_EFFECTS", "EffectValues", "NoEffects", "effect_values", "stage"]


def _discovered() -> dict[str, Effect]:
    names = sorted(module.name for module in pkgutil.iter_modules(library.__path__))
    found = [importlib.import_module(f"{library.__name__}.{name}").EFFECT for name in names]
    return {effect.id: effect for effect in found}


LIBRARY: dict[str, Effect] = _discovered()
"""All effects of the thruster by identifier."""

_IN_PLANT = [effect for effect in LIBRARY.values() if effect.hooks]
_FIELDS = {effect.field_of(p.name): p.neutral for effect in _IN_PLANT for p in effect.parameters}
EffectValues: Any = namedtuple("EffectValues", tuple(_FIELDS), defaults=list(_FIELDS.values()), module=__name__)  # type: ignore[misc]
NoEffects: Any = namedtuple("NoEffects", ("nothing",), module=__name__)
NEUTRAL = EffectValues()
NO_EFFECTS = NoEffects(0.0)


def effect_values(sizes: Mapping[str, Mapping[str, float]]) -> Any:
    """Return the values for effects in the plant, by identifier and parameter; what is not named is neutral.

    Effects that act on samples are passed over: see `effects.active`.

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
            if effect.hooks:
                given[effect.field_of(parameter)] = float(value)
    return EffectValues(**given)


def stage(name: str) -> Callable[..., Any]:
    """Return the function of a stage, for Python and for kernels, as `STAGES` declares it.

    A kernel asks once whether any effect of the stage is on, then of each, so that those which are not cost nothing;
    in Python, where a field may be an array, all hooks are called.
    """
    arguments = ", ".join(STAGES[name])
    first = STAGES[name][0]
    here = [effect for effect in sorted(_IN_PLANT, key=lambda effect: effect.order) if name in effect.hooks]
    hooks = {f"hook_{effect.id}": effect.hooks[name] for effect in here}
    calls = [f"{first} = hook_{effect.id}({arguments})" for effect in here]
    on = [f"(e.{effect.field_of(d.name)} != {d.neutral!r})" for effect in here for d in effect.parameters[:1]]
    guarded = [f"    if {each}: {call}" for each, call in zip(on, calls, strict=True)]
    plain = _define(f"def plain({arguments}):", [], first, {})
    chained = _define(f"def chained({arguments}):", calls, first, hooks)
    chosen = _define(f"def chosen({arguments}):", [f"if {' | '.join(on)}:", *guarded] if on else [], first, hooks)
    python = _define(
        f"def {name}({arguments}):",
        [f"if type(e) is NoEffects: return {first}"],
        f"chained({arguments})",
        {"NoEffects": NoEffects, "chained": chained},
    )
    kernels = {"equations": lambda kind: plain if kind is NoEffects else chosen}
    compiled = ["function = equations(e.instance_class)", f"implementation = lambda {arguments}: function({arguments})"]
    overload(python)(_define(f"def compiled({arguments}):", compiled, "implementation", kernels))
    return python


def _define(head: str, lines: list[str], result: str, names: Mapping[str, Any]) -> Callable[..., Any]:
    namespace = dict(names)
    exec("\n    ".join([head, *lines, f"return {result}"]), namespace)
    function = namespace[head.split()[1].split("(")[0]]
    return equation(function) if head.startswith(("def plain", "def chosen")) else function
