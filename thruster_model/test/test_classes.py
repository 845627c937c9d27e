"""The classes of thrusters: each equation by hand and by a second way."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from thruster_model.equations.airfoil import airfoil_loads
from thruster_model.equations.four_quadrant import four_quadrant_load
from thruster_model.equations.inflow import relative_axial_acceleration, steady_axial_flow
from thruster_model.equations.vehicle_inflow import inflow_at_thrusters, thruster_configuration
from thruster_model.flow_tank import simulate
from thruster_model.models import MODELS, TABLE_KNOTS
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import derivative, outputs

BLADE = {"radius": 0.05, "pitch": 0.3, "lift": 0.8, "drag": 0.25, "density": 1000.0}


def test_3_7_by_hand():
    p = MODELS["bessa"].coefficients({**load_parameter_set("bessa").values, "k_1": 6.0, "k_2": 0.05, "k_3": 500.0})
    assert derivative(-80.0, 0.0, 0.0, -2.0, p)[0] == pytest.approx(6.0 * 80.0 + 0.05 * 6400.0 - 1000.0)


def test_4_1_and_4_2_by_hand():
    start = load_parameter_set("two_state").values
    values = {**start, "k_1": 10.0, "k_Q": 1000.0, "k_3": 500.0, "k_4": 20.0, "k_5": 0.01, "c_nv_Q": 1e-3}
    p = MODELS["two_state"].coefficients(values)
    force = 1.467e-3 * 1e4 - 0.4146 * 100.0 * 0.1
    moment = 2.804e-6 * 1e4 - 1e-3 * 100.0 * 0.1
    n_dot, v_dot, _ = derivative(100.0, 0.1, 0.15, 3.0, p)
    assert n_dot == pytest.approx(-10.0 * 100.0 - 1000.0 * moment + 1500.0)
    assert v_dot == pytest.approx(-20.0 * (-0.05) * 0.05 + 0.01 * force)


def test_4_2_is_at_rest_where_the_slip_is_what_the_thrust_sustains():
    slip = math.sqrt(0.01 * 12.0 / 20.0)
    assert relative_axial_acceleration(0.3 + slip, 0.3, 12.0, 20.0, 0.01) == pytest.approx(0.0, abs=1e-15)


def test_4_6_to_4_11_by_hand():
    """At v = 0 the inflow angle is zero: L and D are those of the pitch itself."""
    pressure = 0.5 * 1000.0 * math.pi * 0.05**2 * (0.7 * 0.05 * 100.0) ** 2
    thrust, torque = airfoil_loads(100.0, 0.0, **BLADE)
    assert thrust == pytest.approx(pressure * 0.8 * math.sin(0.6))
    assert torque == pytest.approx(0.7 * 0.05 * pressure * 0.25 * (1.0 - math.cos(0.6)))


@given(n=st.floats(-200, 200), v=st.floats(-2, 2))
def test_the_airfoil_by_vectors_in_the_complex_plane_is_the_same(n, v):
    """Lift across, drag along the relative flow w = 0.7 R n + i v, angles by the argument of complex numbers."""
    w = complex(0.7 * BLADE["radius"] * n, v)
    if abs(w) < 1e-9:
        return
    towards = w / abs(w)
    double = (complex(math.cos(BLADE["pitch"]), math.sin(BLADE["pitch"])) / towards) ** 2
    pressure = 0.5 * BLADE["density"] * math.pi * BLADE["radius"] ** 2 * abs(w) ** 2
    lift, drag = pressure * BLADE["lift"] * double.imag, pressure * BLADE["drag"] * (1.0 - double.real)
    force = (lift + 1j * drag) * towards
    thrust, torque = airfoil_loads(n, v, **BLADE)
    assert thrust == pytest.approx(force.real, rel=1e-9, abs=1e-9)
    assert torque == pytest.approx(0.7 * BLADE["radius"] * force.imag, rel=1e-9, abs=1e-9)


def test_steady_axial_flow_by_hand():
    assert steady_axial_flow(100.0, 0.2, 0.5, 6e-4, 0.0) == pytest.approx(0.16)
    assert steady_axial_flow(100.0, 0.2, 0.5, 6e-4, math.pi / 3) == pytest.approx(0.11)


@given(n=st.floats(5, 200), ambient=st.floats(-0.5, 0.5))
def test_kim_and_chungs_thrust_is_quadratic_in_the_advance_ratio_and_smooth_at_standstill(n, ambient):
    """K_T = T / n^2 over J = U / n, worked out from the coefficients, is the same without dividing by n = 0."""
    values = load_parameter_set("kim_chung").values
    p = MODELS["kim_chung"].coefficients(values)
    j = ambient / n
    share = values["k_s"] * j + values["k_r"]
    k_t = values["c_n_T"] - values["c_nv_T"] * share - values["c_v_T"] * share * abs(share)
    assert outputs(n, 0.0, ambient, 0.0, p)[2] == pytest.approx(n * n * k_t, rel=1e-9, abs=1e-9)
    assert math.isfinite(outputs(0.0, 0.0, ambient, 0.0, p)[2])


def test_oblique_inflow_takes_its_loss_with_the_cosine_and_turns_it_round_from_behind():
    values = load_parameter_set("kim_chung").values

    def thrust(angle, ambient=0.3):
        p = MODELS["kim_chung"].coefficients({**values, "inflow_angle": angle})
        return outputs(100.0, 0.0, ambient, 0.0, p)[2]

    still = thrust(0.0, ambient=0.0)
    assert thrust(math.pi / 2) == pytest.approx(still)
    assert thrust(0.0) < thrust(1.0) < still < thrust(math.pi)


@given(n=st.floats(-200, 200), v=st.floats(-2, 2))
def test_the_four_quadrant_series_is_one_of_the_angle_of_the_inflow(n, v):
    radius, a1, b1, a3, b3 = 0.05, 0.9, -4.0, 0.1, 0.7
    w = 0.7 * radius * n
    beta = math.atan2(v, w)
    series = a1 * math.cos(beta) + b1 * math.sin(beta) + a3 * math.cos(3.0 * beta) + b3 * math.sin(3.0 * beta)
    by_hand = (v * v + w * w) * series
    assert four_quadrant_load(n, v, radius, a1, b1, a3, b3) == pytest.approx(by_hand, rel=1e-9, abs=1e-9)
    turned = four_quadrant_load(-n, -v, radius, a1, b1, a3, b3)
    assert turned == pytest.approx(-by_hand, rel=1e-9, abs=1e-9)


def test_the_table_interpolates_between_its_nodes_and_holds_beyond_them():
    values = load_parameter_set("table").values
    run = simulate(MODELS["table"].coefficients(values), [1.75, 5.0, -2.75, 0.1], 1.0)
    middle = 0.5 * (values["thrust_at_p1.5"] + values["thrust_at_p2"])
    assert run.thrust[1:3] == pytest.approx([middle, values["thrust_at_p3"]])
    assert run.n[3] == pytest.approx(0.5 * (values["speed_at_m2.5"] + values["speed_at_m3"]))
    assert run.torque[4] == pytest.approx(values["torque_at_p0.75"] * 0.1 / 0.75, abs=1e-9)


@pytest.mark.parametrize("name", [n for n in MODELS if n not in ("static_dead_band", "static_quadratic", "table")])
def test_every_class_with_dynamics_is_integrated_as_scipy_does(name):
    p = load_parameter_set(name).coefficients
    dt = 0.5
    commands = [2.0, 3.0, -1.5, 0.0, -2.5]
    run = simulate(p, commands, dt)
    state, u = np.zeros(3), 0.0
    for k, command in enumerate(commands):
        end = abs(command - u) / p.u_dot_max
        slope = np.sign(command - u) * p.u_dot_max

        def rhs(t, x, u=u, slope=slope):
            return derivative(*x, u + slope * t, p)

        def held(t, x, u=command):
            return derivative(*x, u, p)

        if end > 0:
            state = solve_ivp(rhs, (0.0, end), state, rtol=1e-9, atol=1e-11).y[:, -1]
        state = solve_ivp(held, (end, dt), state, rtol=1e-9, atol=1e-11).y[:, -1]
        u = command
        n, v, force, moment = outputs(*state, u, p)
        assert [run.n[k + 1], run.v[k + 1]] == pytest.approx([n, v], rel=1e-4, abs=1e-4)
        assert [run.thrust[k + 1], run.torque[k + 1]] == pytest.approx([force, moment], rel=1e-3, abs=1e-5)


@pytest.mark.parametrize("name", ["static_dead_band", "static_quadratic", "table"])
def test_static_classes_are_where_the_throttle_tells_them_at_once(name):
    p = load_parameter_set(name).coefficients
    there = simulate(p, [2.5, 2.5], 0.1)
    back = simulate(p, [-3.0, 1.0, 2.5], 0.1)
    assert there.n[1] == there.n[2] == back.n[3] > 50
    assert there.thrust[1] == back.thrust[3] > 2


def test_every_class_has_a_set_to_start_from_and_says_what_it_cannot_do():
    for name, model in MODELS.items():
        assert load_parameter_set(name).model_name == name
        assert model.cannot.endswith(".")
    assert tuple(sorted(TABLE_KNOTS)) == TABLE_KNOTS


FRAME = thruster_configuration([[0.2, 0.1, 0.0], [-0.1, 0.0, 0.3]], [[1, 0, 0], [0, 3, 4]])


def test_4_20_and_4_21_by_hand():
    assert FRAME[:, 0] == pytest.approx([1, 0, 0, 0, 0, -0.1])
    assert FRAME[:, 1] == pytest.approx([0, 0.6, 0.8, -0.18, 0.08, -0.06])
    velocity = [1.0, 0.5, -0.2, 0.1, 0.2, 0.3]
    assert inflow_at_thrusters(FRAME, velocity) == pytest.approx([0.97, 0.3 - 0.16 - 0.018 + 0.016 - 0.018])


@given(st.lists(st.floats(-2, 2), min_size=12, max_size=12))
def test_the_inflow_is_the_velocity_of_the_thruster_through_the_water_along_its_axis(numbers):
    nu, current = np.array(numbers[:6]), np.concatenate((numbers[6:9], [0, 0, 0]))
    relative = nu - current
    for k, (r, e) in enumerate((([0.2, 0.1, 0.0], [1, 0, 0]), ([-0.1, 0.0, 0.3], [0, 0.6, 0.8]))):
        point = relative[:3] + np.cross(relative[3:], r)
        assert inflow_at_thrusters(FRAME, nu, current)[k] == pytest.approx(point @ np.array(e), abs=1e-12)


def test_power_of_thrusts_on_the_body_is_that_along_the_inflows():
    rng = np.random.default_rng(2)
    thrusts, nu = rng.normal(size=2), rng.normal(size=6)
    assert (FRAME @ thrusts) @ nu == pytest.approx(thrusts @ inflow_at_thrusters(FRAME, nu))


@pytest.mark.parametrize(
    ("positions", "axes", "sentence"),
    [([[0, 0, 0]], [[0, 0, 0]], "non-zero length"), ([[0, 0]], [[1, 0]], r"one shape \(N, 3\); got")],
)
def test_a_configuration_that_is_none_is_refused(positions, axes, sentence):
    with pytest.raises(ValueError, match=sentence):
        thruster_configuration(positions, axes)
