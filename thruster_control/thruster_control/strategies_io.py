"""A named strategy made ready: its parameter set read, its table made."""

from typing import Any, NamedTuple

from thruster_control.strategies import Strategy, settings_for, strategy
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["Ready", "load_strategy"]


class Ready(NamedTuple):
    """What `inner_loop_step` takes: settings of the law and coefficients; and the strategy they belong to."""

    settings: Any
    coefficients: ThrusterCoefficients
    strategy: Strategy


def load_strategy(name: str, **changes: Any) -> Ready:
    """Return the strategy of that name with some of its attributes changed, such as `parameter_set` or `law`.

    Raises:
        ValueError: no such strategy, or settings that cannot be used.
        ParameterSetError: a parameter set that cannot be read.
    """
    chosen = strategy(name, **changes)
    p = load_parameter_set(chosen.parameter_set).coefficients
    return Ready(settings_for(chosen, p), p, chosen)
