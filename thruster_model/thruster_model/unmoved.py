"""Which effects change nothing in which model: asked of the equations themselves, at states drawn at random.

A state whose rate is zero in a model stays where it begins, at zero.
"""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import LIBRARY, NEUTRAL, effect_values
from thruster_model.parameter_set import ParameterSet
from thruster_model.pipeline import pipeline

__all__ = ["unmoved"]

_STATES = 400
_RATES = 3


def unmoved(sets: Iterable[ParameterSet]) -> dict[str, tuple[str, ...]]:
    """Return by effect that acts in the plant the models in which it changes neither rates nor signals, if any.

    Args:
        sets: parameter sets, one or more of each model; an effect moves a model where it moves one of its sets.
    """
    moved: dict[str, set[str]] = {}
    for each in sets:
        moved.setdefault(each.model_name, set()).update(_moved(each))
    found = {name: tuple(m for m in moved if name not in moved[m]) for name in _of_the_plant()}
    return {name: models for name, models in found.items() if models}


def _of_the_plant() -> list[str]:
    """Return the effects with a hook in `pipeline`; others act on any throttle, reading or stamp."""
    aside = {"ramp", "lag", "heat", "memory", "step", "late"}
    return [name for name, effect in LIBRARY.items() if set(effect.hooks) - aside]


def _moved(of: ParameterSet) -> set[str]:
    rng = np.random.default_rng(1)
    n, v, ambient, u = (rng.uniform(-most, most, _STATES) for most in (200.0, 0.3, 0.3, 4.5))
    beside = (rng.uniform(0.0, 1.0, _STATES), rng.uniform(-0.3, 0.3, _STATES), rng.integers(0, 2, _STATES), 1.0)

    def happens(states: Any, effects: Any) -> Mapping[str, NDArray[np.float64]]:
        (n, v, ambient), (heat, past, gate, supply) = states, beside
        told = pipeline(n, v, ambient, u, heat, past, gate, supply, of.coefficients, effects)
        signals = dict(zip(SENSED, told[_RATES:], strict=True))
        rates = dict(zip(("n_dot", "v_dot", "u_dot"), told, strict=False))
        return rates | {name: signals[name] for name in of.model.signals}

    states: tuple[NDArray[np.float64], ...] = (n, v, ambient)
    rates = list(happens(states, NEUTRAL).values())[:_RATES]
    states = tuple(state * np.any(rate != 0.0) for state, rate in zip(states, rates, strict=True))
    plain = happens(states, NEUTRAL)
    moved = set()
    for name in _of_the_plant():
        size = LIBRARY[name].parameters[0]
        there = happens(states, effect_values({name: {size.name: size.upper}}))
        if any(np.any(there[signal] != plain[signal]) for signal in plain):
            moved.add(name)
    return moved
