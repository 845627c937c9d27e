"""The compiled plant against anchors computed elsewhere and against scipy's integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from thruster_model.flow_tank import PlantState, simulate
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import derivative


@pytest.mark.parametrize(
    ("parameters", "throttle", "expected"),
    [
        ("simplified", 3.0, {"n": 127.02, "thrust": 13.31}),
        ("simplified", -5.0, {"n": -284.01, "thrust": -77.02}),
        ("hq", 3.0, {"n": 110.81, "v": 0.1268, "ambient": 0.1412, "thrust": 12.13}),
        ("hl", -5.0, {"n": -205.40, "v": -0.2768, "ambient": -0.3009, "thrust": -38.32}),
    ],
)
def test_the_plant_comes_to_the_steady_states_computed_independently(parameters, throttle, expected):
    run = simulate(load_parameter_set(parameters).coefficients, np.full(60_000, throttle), 1e-3)
    for name, value in expected.items():
        digits = len(str(value).split(".")[1])
        assert getattr(run, name)[-1] == pytest.approx(value, abs=0.51 * 10.0**-digits), name


@pytest.mark.parametrize("parameters", ["simplified", "hl", "hq", "hl_bench"])
def test_the_plant_follows_scipys_integrator_through_reversals(parameters):
    p = load_parameter_set(parameters).coefficients
    dt = 0.04
    commands = 3.0 * np.sin(1.3 * dt * np.arange(200)) + 0.7
    run = simulate(p, commands, dt)
    state, u = np.zeros(3), 0.0
    for k, command in enumerate(commands[:-1]):
        ramp_end = min(dt, abs(command - u) / p.u_dot_max)
        rate = np.sign(command - u) * p.u_dot_max

        def rhs(t, x, u=u, rate=rate, ramp_end=ramp_end):
            return derivative(*x, u + rate * min(t, ramp_end), p)

        for a, b in ((0.0, ramp_end), (ramp_end, dt)):
            if b > a:
                state = solve_ivp(rhs, (a, b), state, rtol=1e-9, atol=1e-11).y[:, -1]
        u = command
        assert run.n[k + 1] == pytest.approx(state[0], abs=3e-3)
        assert run.v[k + 1] == pytest.approx(state[1], abs=1e-6)
        assert run.ambient[k + 1] == pytest.approx(state[2], abs=1e-6)


def test_the_plant_starts_where_it_is_told_and_reports_before_the_first_command():
    p = load_parameter_set("hl").coefficients
    run = simulate(p, [1.0], 0.01, initial=PlantState(50.0, 0.1, 0.05, 0.5))
    assert (run.n[0], run.v[0], run.ambient[0], run.u[0]) == (50.0, 0.1, 0.05, 0.5)
    assert run.u[1] == 1.0


def test_halving_the_step_changes_nothing_that_matters():
    p = load_parameter_set("hq").coefficients
    commands = np.repeat([2.0, -3.0, 0.0, 1.2], 50)
    coarse = simulate(p, commands, 0.02, largest_step=2e-3)
    fine = simulate(p, commands, 0.02, largest_step=5e-4)
    assert coarse.n == pytest.approx(fine.n, abs=5e-3)
    assert coarse.thrust == pytest.approx(fine.thrust, abs=1e-3)


@pytest.mark.parametrize("commands", [[[[1.0]]], [np.nan]])
def test_unusable_commands_are_refused(commands):
    with pytest.raises(ValueError, match="u_commanded: expected finite values"):
        simulate(load_parameter_set("hl").coefficients, commands, 0.01)
