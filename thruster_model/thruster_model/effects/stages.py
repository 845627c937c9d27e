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
    """Return the function of a stage, for Python and for kernels, as `STAGES` declares it."""
    arguments = ", ".join(STAGES[name])
    first = STAGES[name][0]
    hooks = {f"hook_{e.id}": e.hooks[name] for e in LIBRARY.values() if name in e.hooks}
    chained = _define(f"def chained({arguments}):", [f"{first} = {h}({arguments})" for h in hooks], first, hooks)
    plain = _define(f"def plain({arguments}):", [], first, {})
    choice = {"chosen": lambda kind: plain if kind is NoEffects else chained}
    python = _define(f"def {name}({arguments}):", [], f"chosen(type(e))({arguments})", choice)
    compiled = ["function = chosen(e.instance_class)", f"implementation = lambda {arguments}: function({arguments})"]
    overload(python)(_define(f"def compiled({arguments}):", compiled, "implementation", choice))
    return python


def _define(head: str, lines: list[str], result: str, names: Mapping[str, Any]) -> Callable[..., Any]:
    namespace = dict(names)
    exec("\n    ".join([head, *lines, f"return {result}"]), namespace)
    function = namespace[head.split()[1].split("(")[0]]
    return equation(function) if not names or head.startswith("def chained") else function
