"""The inner loops of a case: observer and law of a strategy, with what they believe.

Observers, law and integration in the project's proper forms. The tachometer tells the sign, as (3.12) needs it.

told     r of the speed and of the ambient flow are the noise as it is: U = K_t^T nu has that of the velocity
bench    the densities R = diag(3, 0.005) that the bench ran with, at the loop's period
both     Q, and the gains of NLO and KFNLO, are the bench's
"""

from typing import Any

from rov_sim.closed_loop import Controller
from rov_sim.vehicle_study.assumptions import Assumptions
from rov_sim.vehicle_study.plan import ON_TABLE_3_1
from rov_sim.vehicle_study.refit import refitted_simplified, refitted_table
from thruster_control.settings import TableLaw
from thruster_control.strategies import Strategy, settings_for, strategy
from thruster_estimation.belief import initial_belief
from thruster_estimation.settings import bench_settings, checked

__all__ = ["inner_loop_of"]

_LEAST_SPEED_NOISE, _LEAST_FLOW_NOISE = 1e-3, 1e-3  # rad/s, m/s
_NO_NOISE = 1e-6  # rad/s: the speed is taken as it was measured
_BENCH_k_U = 0.2395923  # 1/s, which k_11 of NLO is made of


def inner_loop_of(name: str, given: Assumptions, believed: Any, truth: Any) -> Controller:
    """Return observer, law and beliefs of a strategy.

    Args:
        name: of the strategy.
        given: the case's assumptions.
        believed: coefficients of the strategy's parameter set.
        truth: nominal coefficients of the true thruster, which the refitted ones are made of.
    """
    chosen, p = strategy(name), believed
    law = chosen.law._replace(limits=chosen.law.limits._replace(u_max=given.largest_throttle))
    if name == "dead-zone":
        law = law._replace(gains=law.gains._replace(k_P=given.speed_gain))
    if given.beliefs == "refitted" and name in ON_TABLE_3_1:
        p = refitted_simplified(truth, given.largest_throttle)
        if isinstance(law, TableLaw):
            law = law._replace(table=refitted_table(truth, given.largest_throttle))
    ready = Strategy(name=name, title=chosen.title, law=law, parameter_set="", observer=chosen.observer)
    belief = initial_belief(deviation_n=3.0**0.5, deviation_v=0.005**0.5, deviation_U=0.005**0.5)
    return Controller(observer=_observer(chosen, given, p), law=settings_for(ready, p), coefficients=p, belief=belief)


def _observer(chosen: Strategy, given: Assumptions, p: Any) -> Any:
    """Return the observer's settings; a table's loop runs a filter of the speed that nothing reads."""
    name = "speed-ekf" if chosen.observer == "none" else chosen.observer
    settings = bench_settings(name, k_U=p.k_U or _BENCH_k_U, dt=given.period)._replace(unsigned=0)
    told = {"r_n": max(given.speed_noise, _LEAST_SPEED_NOISE) ** 2}
    told["r_U"] = max(given.velocity_noise, _LEAST_FLOW_NOISE) ** 2
    if chosen.name == "dead-zone":
        settings = settings._replace(r_n=_NO_NOISE**2)
    elif given.observers == "told":
        settings = settings._replace(**{k: v for k, v in told.items() if k in settings._fields})
    return checked(settings)
