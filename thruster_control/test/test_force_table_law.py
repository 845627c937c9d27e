"""The inverse of a maker's table as a law: the thrust asked for at rest, whatever the battery's voltage."""

import math

import numpy as np
import pytest

from thruster_control.inner_loop import AT_REST, Status, compiled_step, inner_loop_step
from thruster_control.settings import ForceTableLaw, Limits
from thruster_control.strategies_io import load_strategy
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set

SET = load_parameter_set("force_table")
P = SET.coefficients
LIMITS = ForceTableLaw().limits
assert SET.force_table is not None


def throttle(T_d: float, supply: float, p=P, limits: Limits = LIMITS) -> float:  # type: ignore[no-untyped-def]
    """The law's throttle [V] a second after it was asked."""
    law, none = ForceTableLaw(limits), math.nan
    return float(inner_loop_step(AT_REST, T_d, none, none, none, False, 1.0, law, p, none, 0.0, supply)[1].u)


@pytest.mark.parametrize("volts", [12.0, 13.1, 14.0, 16.0])
@pytest.mark.parametrize("T_d", [-20.0, -3.0, -0.3, 0.3, 5.0, 27.0])
def test_the_plant_gives_the_thrust_that_is_asked_for_at_every_supply(T_d: float, volts: float) -> None:
    u = throttle(T_d, volts / 14.0)
    run = simulate(P, np.full(60, u), 0.05, supply=np.full(60, volts / 14.0))
    assert run.thrust[-1] == pytest.approx(T_d, abs=1e-4)


@pytest.mark.parametrize("T_d", [-20.0, 0.5, 12.0])
def test_the_command_is_the_table_s_own_inverse(T_d: float) -> None:
    assert SET.force_table is not None
    found = SET.command.command(throttle(T_d, 12.6 / 14.0))
    assert float(found) == pytest.approx(float(SET.force_table.command_for(T_d, 12.6)), abs=1e-4)


def test_as_if_at_the_nominal_voltage_a_low_battery_costs_a_sixth_of_the_thrust() -> None:
    blind = np.full(60, throttle(20.0, 1.0))
    run = simulate(P, blind, 0.05, supply=np.full(60, 12.6 / 14.0))
    assert 0.78 * 20.0 < run.thrust[-1] < 0.88 * 20.0


def test_a_thruster_weaker_than_its_table_is_asked_for_more() -> None:
    weak = P._replace(thrust_scale=0.8)
    run = simulate(weak, np.full(60, throttle(20.0, 1.0, weak)), 0.05)
    assert run.thrust[-1] == pytest.approx(20.0, abs=1e-4)


def test_more_than_the_thruster_has_ends_at_full_throttle_and_no_thrust_idles() -> None:
    assert throttle(80.0, 1.0) == pytest.approx(5.0)
    assert throttle(-80.0, 1.0) == pytest.approx(-5.0)
    assert throttle(80.0, 1.0, limits=Limits(u_max=3.0)) == 3.0
    assert throttle(0.0, 1.0) == 0.0


def test_kernel_and_python_agree_and_no_estimate_is_needed() -> None:
    ready = load_strategy("force-table")
    given = (
        7.0,
        math.nan,
        math.nan,
        math.nan,
        False,
        0.5,
        ready.settings,
        ready.coefficients,
        math.nan,
        math.inf,
        0.95,
    )
    memory, out = compiled_step(AT_REST, *given)
    assert Status(out.status) is Status.RUNNING
    assert out == inner_loop_step(AT_REST, *given)[1]
    assert memory.side == 1.0
