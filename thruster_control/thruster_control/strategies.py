"""The control strategies by name: law, parameter set and observer of each.

Those that the thesis compares (section 5.1): an open-loop table, the simplified model, and HL or HQ with each of three
observers; in addition section 3.3's own law on the measured speed (its `speed-ekf` is to be told a tachometer without
noise), Kim and Chung's steady flow and a PI loop on thrust. An observer is named only: it lives in another package.
`speed-ekf` estimates n alone; `ekf`, `nlo` and `kfnlo` estimate n, v and U.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Literal, get_args

from thruster_control.settings import (
    NO_TABLE,
    FlowLaw,
    ForceTableLaw,
    Gains,
    SimplifiedLaw,
    SteadyFlowLaw,
    TableLaw,
    ThrustLaw,
    checked,
)
from thruster_control.steady_table import lookup_of_set
from thruster_model.equations.classes import ForceTableCoefficients, SteadyFlowCoefficients
from thruster_model.equations.thruster import ThrusterCoefficients

__all__ = ["STRATEGIES", "Observer", "Strategy", "settings_for", "strategy"]

Observer = Literal["none", "speed-ekf", "ekf", "nlo", "kfnlo"]


@dataclass(frozen=True, kw_only=True)
class Strategy:
    """A named strategy.

    Attributes:
        name: identifier.
        title: in words.
        law: settings of the law (`thruster_control.settings`); a `TableLaw` without a table gets the parameter set's.
        parameter_set: name or path of the set that law and observer believe in.
        observer: name of the observer.
    """

    name: str
    title: str
    law: Any
    parameter_set: str
    observer: Observer

    def __post_init__(self) -> None:
        if self.observer not in get_args(Observer):
            known = ", ".join(get_args(Observer))
            raise ValueError(f"{self.name}: observer: expected one of {known}; found {self.observer!r}")


def _hydrodynamic(model: Literal["hl", "hq"], observer: Observer) -> Strategy:
    title = f"Output feedback with the {model.upper()} model and the {observer.upper()}"
    return Strategy(name=f"{model}-{observer}", title=title, law=FlowLaw(), parameter_set=model, observer=observer)


_ALL = (
    Strategy(
        name="lookup",
        title="Lookup table of steady states, open loop",
        law=TableLaw(NO_TABLE),
        parameter_set="simplified",
        observer="none",
    ),
    Strategy(
        name="simplified",
        title="Speed loop with the simplified model",
        law=SimplifiedLaw(),
        parameter_set="simplified",
        observer="speed-ekf",
    ),
    Strategy(
        name="dead-zone",
        title="Dead-zone compensation (3.12), (3.13) with the measured speed",
        law=SimplifiedLaw(gains=Gains(k_I=0.0, on_estimate=1)),
        parameter_set="simplified",
        observer="speed-ekf",
    ),
    Strategy(
        name="steady-flow",
        title="Speed loop with Kim and Chung's steady flow, from the measured ambient flow",
        law=SteadyFlowLaw(),
        parameter_set="kim_chung",
        observer="speed-ekf",
    ),
    *(_hydrodynamic(model, observer) for model in ("hl", "hq") for observer in ("ekf", "nlo", "kfnlo")),  # type: ignore[arg-type]
    Strategy(
        name="pi-thrust",
        title="PI loop on thrust, the load cell's where there is one, else the simplified map's",
        law=ThrustLaw(),
        parameter_set="simplified",
        observer="speed-ekf",
    ),
    Strategy(
        name="force-table",
        title="Maker's table of force, looked up at the supply voltage of the moment, open loop",
        law=ForceTableLaw(),
        parameter_set="force_table",
        observer="none",
    ),
)
STRATEGIES: Mapping[str, Strategy] = MappingProxyType({each.name: each for each in _ALL})


def strategy(name: str, **changes: Any) -> Strategy:
    """Return the strategy of that name with some of its attributes changed; ValueError for a name that none has."""
    if name not in STRATEGIES:
        raise ValueError(f"expected one of {', '.join(STRATEGIES)}; found {name!r}")
    return replace(STRATEGIES[name], **changes)


def settings_for(chosen: Strategy, p: ThrusterCoefficients) -> Any:
    """Return the checked settings of the strategy's law for the coefficients of its parameter set.

    Raises:
        ValueError: settings that cannot be used, or a law that these coefficients do not fit.
        SteadyStatesError: coefficients whose steady states give no table.
    """
    law = chosen.law
    steady = isinstance(p, SteadyFlowCoefficients)
    if isinstance(law, SteadyFlowLaw) and not steady:
        raise ValueError(f"{chosen.name}: expected a parameter set with steady flow; found {type(p).__name__}")
    flow_free = isinstance(law, SimplifiedLaw | FlowLaw) and type(p) is not ThrusterCoefficients
    if flow_free:
        raise ValueError(f"{chosen.name}: expected a set of the thesis' common form; found {type(p).__name__}")
    if isinstance(law, ThrustLaw) and not (steady or type(p) is ThrusterCoefficients):
        raise ValueError(f"{chosen.name}: expected a set with a thrust map; found {type(p).__name__}")
    if isinstance(law, ForceTableLaw) and not isinstance(p, ForceTableCoefficients):
        raise ValueError(f"{chosen.name}: expected a set with a table of force; found {type(p).__name__}")
    if isinstance(law, TableLaw) and law.table.size == 0:
        law = law._replace(table=lookup_of_set(p, u_max=law.limits.u_max))
    return checked(law)
