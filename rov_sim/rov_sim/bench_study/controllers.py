r"""The control strategies of section 5.1, ready for a closed loop, as the bench ran them or as this project would.

Forms of the observers and the law:

bench    Euler observers, law on the prediction, dn_d/dt = (n_d - n)/0.04 s, n_d as (4.22), (4.23) print it, no idling
proper   the project's defaults: RK4 and matrix exponential, filtered dn_d/dt, exact n_d with hysteresis
gated    as proper, with the flow's noise as it is (0.03 m/s instead of the 0.35 m/s of the bench's R), and measurements
         with a NIS above 16 (NLO: more than 0.1 m/s from the estimate) are refused

What controllers believe in (`BELIEFS`): "bench": the sets `hl_bench` and `hq_bench`; table and simplified model
with T = 9.734848e-4 n|n|, the map used there, over HL's rotor. "published": the sets of the strategies (Table 3.1 for
the table and the simplified model, which describes the thruster a year earlier).
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.closed_loop import Controller
from thruster_control.settings import BENCH_GAINS, FlowLaw, Limits, TableLaw, ThrustLaw
from thruster_control.steady_table import lookup_of_set
from thruster_control.strategies import STRATEGIES, Strategy, settings_for, strategy
from thruster_estimation.belief import initial_belief
from thruster_estimation.settings import BENCH, PROPER, bench_settings, checked

__all__ = ["BELIEFS", "EXTRA", "FORMS", "THESIS", "InputMap", "controller", "reads_load_cell", "simplified_as_run"]

THESIS = ("lookup", "simplified", "hl-ekf", "hl-nlo", "hl-kfnlo", "hq-ekf", "hq-nlo", "hq-kfnlo")
"""The thesis' eight strategies."""
EXTRA = ("steady-flow", "pi-thrust")
FORMS = ("bench", "proper", "gated")
BELIEFS = ("bench", "published")
_SIMPLIFIED_THRUST = 9.734848e-4  # N s^2, the map used on the bench by the table and the simplified model
_GATE, _LARGEST_INNOVATION, _FLOW_NOISE = 16.0, 0.1, 0.03  # 1, m/s, m/s


class InputMap(NamedTuple):
    """gamma of (3.9): slopes [1/(V s^2)] and edges [V]."""

    c_u1: float
    delta_u1: float
    c_u2: float
    delta_u2: float


def simplified_as_run(bench: Any) -> Any:
    """Return what the bench's simplified model believed: HL's coefficients with a thrust map of n alone."""
    return bench._replace(c_T1=_SIMPLIFIED_THRUST, c_T2=_SIMPLIFIED_THRUST, c_nv_T=0.0)


def parameter_sets(beliefs: str) -> dict[str, str]:
    """Return the parameter set of each strategy's controller by name of the strategy."""
    sets = {name: each.parameter_set for name, each in STRATEGIES.items() if name in (*THESIS, *EXTRA)}
    if beliefs == "bench":
        for name in sets:
            if name in ("lookup", "simplified", "pi-thrust") or name.startswith("hl-"):
                sets[name] = "hl_bench"
            elif name.startswith("hq-"):
                sets[name] = "hq_bench"
    return sets


def controller(
    name: str,
    coefficients: Any,
    *,
    form: str = "bench",
    beliefs: str = "bench",
    input_map: InputMap | None = None,
    table: NDArray[np.float64] | None = None,
) -> Controller:
    """Return a strategy's controller.

    Args:
        name: of the strategy.
        coefficients: of the parameter set that `parameter_sets` names for it.
        form: one of `FORMS`; beliefs: one of `BELIEFS`.
        input_map: gamma in the place of the set's.
        table: of the open-loop strategy (throttle, thrust, speed), in the place of the set's steady states.

    Raises:
        ValueError: an unknown name, form or belief.
    """
    for word, value, known in (("form", form, FORMS), ("beliefs", beliefs, BELIEFS)):
        if value not in known:
            raise ValueError(f"{word}: expected one of {', '.join(known)}; found {value!r}")
    chosen, p = strategy(name), coefficients
    if input_map is not None:
        p = p._replace(**input_map._asdict())
    law = _law(chosen, p, form, table if table is not None else _steady_states(chosen, p))
    if beliefs == "bench" and name in ("lookup", "simplified", "pi-thrust"):
        p = simplified_as_run(p)
    belief = initial_belief(deviation_n=3.0**0.5, deviation_v=0.005**0.5, deviation_U=0.005**0.5)
    return Controller(observer=_observer(chosen, p, form), law=law, coefficients=p, belief=belief)


def reads_load_cell(control: Controller) -> bool:
    """Return whether the law feeds the load cell back, which the bench's laws did not."""
    return isinstance(control.law, ThrustLaw)


def _steady_states(chosen: Strategy, p: Any) -> NDArray[np.float64] | None:
    return lookup_of_set(p) if isinstance(chosen.law, TableLaw) else None


def _law(chosen: Strategy, p: Any, form: str, table: NDArray[np.float64] | None) -> Any:
    law = chosen.law
    if isinstance(law, TableLaw):
        assert table is not None
        law = TableLaw(np.ascontiguousarray(table), by_thrust=0)
    if form == "bench":
        law = law._replace(limits=Limits(idle_thrust=-1.0, longest_hold=1e9))
        if hasattr(law, "gains"):
            law = law._replace(gains=BENCH_GAINS)
        if isinstance(law, FlowLaw):
            law = law._replace(as_printed=1)
    return settings_for(Strategy(**{**_fields(chosen), "law": law}), p)


def _fields(chosen: Strategy) -> dict[str, Any]:
    return {name: getattr(chosen, name) for name in ("name", "title", "law", "parameter_set", "observer")}


def _observer(chosen: Strategy, p: Any, form: str) -> Any:
    """Return the observer's settings; the table's loop runs a filter of the speed that nothing reads."""
    name = "speed-ekf" if chosen.observer == "none" else chosen.observer
    settings = bench_settings(name, form=BENCH if form == "bench" else PROPER, k_U=p.k_U or 0.2395923)
    if form == "gated":
        changes = {"gate": _GATE, "largest_innovation": _LARGEST_INNOVATION, "r_U": _FLOW_NOISE**2}
        settings = settings._replace(**{k: v for k, v in changes.items() if k in settings._fields})
    return checked(settings)
