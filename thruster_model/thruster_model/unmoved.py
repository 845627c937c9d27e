"""What effects and parameters change in a model: asked of the equations themselves, at states drawn at random.

A state whose rate is zero in a model stays where it begins, at zero.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import LIBRARY, NEUTRAL, effect_values
from thruster_model.parameter_set import ParameterSet
from thruster_model.pipeline import pipeline

__all__ = ["moved_by_effects", "moved_by_parameter", "unmoved"]

Array = NDArray[np.float64]

_RATES = {"n_dot": SENSED, "v_dot": ("axial", "thrust"), "u_dot": ("ambient", "thrust")}
"""Rates, and the signals in which each shows at least."""
_STATES = 400
_STEP = 0.1
"""Of a parameter, over its value, or its usual size where that is larger."""


def unmoved(sets: Iterable[ParameterSet]) -> dict[str, tuple[str, ...]]:
    """Return by effect that acts in the plant the models in which it changes neither rates nor signals, if any.

    Args:
        sets: parameter sets, one or more of each model; an effect moves a model where it moves one of its sets.
    """
    moved: dict[str, set[str]] = {}
    for each in sets:
        moved.setdefault(each.model_name, set()).update(k for k, names in moved_by_effects(each).items() if names)
    found = {name: tuple(m for m in moved if name not in moved[m]) for name in _of_the_plant()}
    return {name: models for name, models in found.items() if models}


def moved_by_effects(of: ParameterSet) -> dict[str, frozenset[str]]:
    """Return by effect that acts in the plant the signals in which it shows in a model; none: it changes nothing."""
    happens, plain, found = *_drawn(of), {}
    for name in _of_the_plant():
        size = LIBRARY[name].parameters[0]
        there = happens(of.coefficients, effect_values({name: {size.name: size.upper}}))
        found[name] = _differ(plain, there)
    return found


def moved_by_parameter(of: ParameterSet, name: str) -> frozenset[str]:
    """Return the signals in which a parameter of a set shows."""
    happens, plain = _drawn(of)
    value, scale = of.values[name], of.model.definition(name).scale
    moved = of.values | {name: value + _STEP * max(abs(value), scale)}
    return _differ(plain, happens(of.model.coefficients(moved), NEUTRAL))


def _of_the_plant() -> list[str]:
    """Return the effects with a hook in `pipeline`; others act on any throttle, reading or stamp."""
    aside = {"ramp", "lag", "heat", "memory", "step", "late"}
    return [name for name, effect in LIBRARY.items() if set(effect.hooks) - aside]


def _differ(one: Mapping[str, Array], other: Mapping[str, Array]) -> frozenset[str]:
    changed = [name for name in one if np.any(one[name] != other[name])]
    return frozenset(signal for name in changed for signal in _RATES.get(name, (name,)))


def _drawn(of: ParameterSet) -> tuple[Callable[[Any, Any], Mapping[str, Array]], Mapping[str, Array]]:
    """Return a function of coefficients and effects that gives rates and signals at some states, and those of a set."""
    rng = np.random.default_rng(1)
    n, v, ambient, u = (rng.uniform(-most, most, _STATES) for most in (200.0, 0.3, 0.3, 4.5))
    beside = (rng.uniform(0.0, 1.0, _STATES), rng.uniform(-0.3, 0.3, _STATES), rng.integers(0, 2, _STATES), 1.0)
    drawn: tuple[Array, ...] = (n, v, ambient)

    def happens(coefficients: Any, effects: Any) -> Mapping[str, Array]:
        (n, v, ambient), (heat, past, gate, supply) = drawn, beside
        told = pipeline(n, v, ambient, u, heat, past, gate, supply, coefficients, effects)
        signals = dict(zip(SENSED, told[len(_RATES) :], strict=True))
        return dict(zip(_RATES, told, strict=False)) | {name: signals[name] for name in of.model.signals}

    rates = happens(of.coefficients, NEUTRAL)
    drawn = tuple(state * np.any(rates[name] != 0.0) for state, name in zip(drawn, _RATES, strict=True))
    return happens, happens(of.coefficients, NEUTRAL)
