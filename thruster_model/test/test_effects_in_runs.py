"""Effects in simulated runs: rest states and decays by hand, transients by scipy's integrator and equations anew."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from thruster_model.effects.stages import NO_EFFECTS, effect_values
from thruster_model.flow_tank import AT_REST, PlantState, simulate
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import load_parameter_set

SETS = {name: load_parameter_set(name).coefficients for name in MODELS}
HQ = SETS["hq"]
DT = 0.01


def run(model, throttle, duration, initial=None, gates=(), **sizes):
    commands = np.full(round(duration / DT), throttle) if np.isscalar(throttle) else throttle
    effects = effect_values(sizes) if sizes else NO_EFFECTS
    start = AT_REST if initial is None else initial
    return simulate(SETS[model], commands, DT, initial=start, effects=effects, gates=gates)


# ---- rotor and drive


@pytest.mark.parametrize(("throttle", "slope"), [(3.0, 737.2), (-3.0, 725.5)])
def test_dry_friction_runs_as_fast_as_a_drive_less_by_its_size(throttle, slope):
    rubbed = run("hq", throttle, 10.0, coulomb_friction={"deceleration": 300.0})
    weaker = run("hq", throttle - np.sign(throttle) * 300.0 / slope, 10.0)
    assert rubbed.n[-1] == pytest.approx(weaker.n[-1], rel=1e-6)


def test_dry_friction_holds_a_rotor_driven_by_less_and_frees_one_driven_by_more():
    below, above = (0.86 + drive / 737.2 for drive in (290.0, 310.0))
    held = run("hq", below, 3.0, coulomb_friction={"deceleration": 300.0})
    assert 0.0 <= np.max(held.n) < 0.3 and np.max(np.abs(held.thrust)) < 1e-3
    freed = run("hq", above, 3.0, coulomb_friction={"deceleration": 300.0})
    assert freed.n[-1] == pytest.approx((310.0 - 300.0) / 13.66, rel=0.01)


def test_dry_friction_stops_a_coasting_rotor_for_good():
    stopped = run("hq", 0.0, 2.0, PlantState(50.0, 0.0, 0.0, 0.0), coulomb_friction={"deceleration": 500.0})
    assert np.all(stopped.n[50:] < 1e-9) and np.all(stopped.n >= 0.0)


def test_more_inertia_stretches_the_rotors_time():
    start = PlantState(0.0, 0.0, 0.0, 3.0)
    heavy = run("simplified", 3.0, 0.6, start, rotor_inertia={"share": 1.0})
    assert heavy.n[::2] == pytest.approx(run("simplified", 3.0, 0.3, start).n, rel=1e-6)


@pytest.mark.parametrize("share", [-0.8, 0.8])
def test_braking_coasts_down_by_its_own_friction_and_speeds_up_without_it(share):
    coast = run("first_order", 0.0, 0.3, PlantState(80.0, 0.0, 0.0, 0.0), brake_asymmetry={"share": share})
    assert coast.n == pytest.approx(80.0 * np.exp(-13.66 * (1.0 + share) * DT * np.arange(31)), rel=1e-6)
    up = run("first_order", 3.0, 1.0, PlantState(0.0, 0.0, 0.0, 3.0), brake_asymmetry={"share": share})
    assert up.n == pytest.approx(run("first_order", 3.0, 1.0, PlantState(0.0, 0.0, 0.0, 3.0)).n, rel=1e-12)


@pytest.mark.parametrize("share", [-0.35, 0.35, 0.8])
def test_a_driver_that_brakes_at_once_slows_by_another_friction_down_to_where_it_settles(share):
    slowed = run(
        "first_order", 2.0, 0.5, PlantState(120.0, 0.0, 0.0, 2.0), brake_asymmetry={"share": share, "onset": 0}
    )
    aim = 52.0 * (2.0 - 0.86)
    braked = aim / (1.0 + share)
    by_hand = braked + (120.0 - braked) * np.exp(-13.66 * (1.0 + share) * DT * np.arange(51))
    assert slowed.n == pytest.approx(np.maximum(by_hand, aim), abs=0.5)


@pytest.mark.parametrize(
    "sizes",
    [
        {"brake_asymmetry": {"share": 0.8, "onset": 0.02}},
        {"coulomb_friction": {"deceleration": 400.0}},
        {"flow_reversal_loss": {"share": 0.8}},
    ],
)
def test_abrupt_effects_shorten_the_steps_that_are_asked_for(sizes):
    commands = 2.0 + 2.0 * np.sin(0.08 * np.arange(300.0))
    runs = [
        simulate(SETS["hl"], commands, DT, largest_step=step, effects=effect_values(sizes)) for step in (DT, 2.5e-4)
    ]
    assert runs[0].n == pytest.approx(runs[1].n, abs=0.2)
    assert runs[0].thrust == pytest.approx(runs[1].thrust, abs=0.05)


def test_a_turning_rotor_goes_on_where_one_at_rest_does_not_start():
    hysteresis = {"voltage": 0.3}
    throttle = 0.8
    turning = run("first_order", throttle, 2.0, PlantState(60.0, 0.0, 0.0, throttle), start_hysteresis=hysteresis)
    assert turning.n[-1] == pytest.approx(52.0 * (0.8 - 0.56), rel=1e-6)
    assert np.all(run("first_order", throttle, 2.0, start_hysteresis=hysteresis).n == 0.0)
    fallen = run("first_order", 0.7, 2.0, PlantState(60.0, 0.0, 0.0, 0.7), start_hysteresis=hysteresis)
    assert fallen.n[-1] == pytest.approx(0.0, abs=1e-3), "52 (0.7 - 0.56) = 7.3 rad/s is too slow to hold the edge"


def test_a_sagging_supply_runs_without_load_at_the_speed_over_one_plus_its_share():
    assert run("first_order", 5.0, 3.0, supply_sag={"share": 0.4}).n[-1] == pytest.approx(52.0 * 4.14 / 1.4, rel=1e-6)
    weaker = 51.0 * 4.17 / (52.0 * 4.14)  # the resistance is one: x of full speed backwards, x + 0.4 x weaker^2 = 1
    slowed = run("first_order", -5.0, 3.0, supply_sag={"share": 0.4})
    assert slowed.n[-1] == pytest.approx(-51.0 * 4.17 / (1.0 + 0.4 * weaker**2), rel=1e-6)


def test_a_sagging_supply_knows_a_rotor_with_quadratic_friction_alone():
    share = 0.5 * (np.sqrt(0.4**2 + 4.0) - 0.4)  # of n_full: x^2 = 1 - 0.4 x
    slowed = run("yoerger", 5.0, 3.0, supply_sag={"share": 0.4})
    assert slowed.n[-1] == pytest.approx(share * np.sqrt(263.0 * 5.0 / 0.064), rel=1e-6)


def test_a_warming_motor_fades_with_its_time_constant():
    faded = run("first_order", 4.0, 30.0, thermal_fade={"share": 0.5, "time_constant": 10.0})
    time = DT * np.arange(faded.n.size)
    quasi_steady = 52.0 * (4.0 - 0.86) * (1.0 - 0.5 * 0.8 * (1.0 - np.exp(-time / 10.0)))
    assert faded.n[200:] == pytest.approx(quasi_steady[200:], rel=5e-3)


@pytest.mark.parametrize(("model", "no_load"), [("hq", 737.2 * 2.14 / 13.66), ("bessa", 500.0 * 3.0 / 6.83)])
def test_in_air_the_rotor_runs_at_its_speed_without_load_and_pushes_nothing(model, no_load):
    air = run(model, 3.0, 5.0, water_unloaded={"share": 1.0})
    assert air.n[-1] == pytest.approx(no_load, rel=1e-6)
    assert np.all(air.thrust == 0.0)


def test_a_fouled_propeller_turns_slower_and_pushes_less():
    n = run("hl", 3.0, 30.0, propeller_fouling={"share": 0.5}).n[-1]
    expected = brentq(lambda n: -13.66 * n - 1856.0 * 1.5 * 2.804e-6 * n * n + 737.2 * 2.14, 0.0, 200.0)
    assert n == pytest.approx(expected, rel=1e-4)


# ---- thrust


def test_air_is_drawn_only_in_the_stretches_where_the_gate_is_shut():
    gates = np.repeat([1.0, 0.0, 1.0], 50)
    settled = PlantState(163.28, 0.0, 0.0, 4.0)
    drawn = run("first_order", 4.0, 1.5, settled, gates=gates, ventilation={"share": 0.6})
    ratio = drawn.thrust / run("first_order", 4.0, 1.5, settled).thrust
    assert ratio[:-1] == pytest.approx(1.0 - 0.6 * (gates == 0.0))


def test_reversal_costs_thrust_only_while_the_water_still_flows_the_old_way():
    commands = np.repeat([3.0, -3.0], 500)
    plain, lossy = (run("hq", commands, 0.0, **e) for e in ({}, {"flow_reversal_loss": {"share": 0.9}}))
    against = lossy.n * lossy.v < 0.0
    assert against.sum() > 3 and np.all(np.flatnonzero(against) > 500)
    assert np.max(np.abs(lossy.thrust[against])) < 0.5 * np.max(np.abs(plain.thrust[against]))
    assert lossy.thrust[:500] == pytest.approx(plain.thrust[:500])


# ---- flow


@pytest.mark.parametrize("share", [-0.5, 3.0])
def test_lag_of_the_axial_flow_leaves_rest_states_and_stretches_a_decay(share):
    lagged, plain = (run("hq", 3.0, 80.0, **e) for e in ({"flow_lag": {"share": share}}, {}))
    for name in ("n", "v", "ambient", "thrust"):
        assert getattr(lagged, name)[-1] == pytest.approx(getattr(plain, name)[-1], abs=1e-9)
    decay = run("hq", 0.0, 2.0, PlantState(0.0, 1e-6, 0.0, 0.0), flow_lag={"share": share}).v
    assert decay[-1] == pytest.approx(1e-6 * np.exp(-1.102 * 2.0 / (1.0 + share)), rel=1e-3)


def test_a_current_turns_into_axial_flow_and_is_measured():
    start = PlantState(0.0, 0.01, 0.0, 0.0)
    through = run("hl", 0.0, 60.0, start, ambient_current={"speed": 0.3})
    assert through.v[-1] == pytest.approx(0.89 * 0.3 - 1.102 / 67.37)
    assert np.all(through.ambient == 0.3)
    oblique = run("hl", 0.0, 60.0, start, ambient_current={"speed": 0.3}, oblique_inflow={"angle": 1.0})
    assert oblique.v[-1] == pytest.approx(0.89 * 0.3 * np.cos(1.0) - 1.102 / 67.37)
    assert np.all(oblique.ambient == 0.3)


def test_oblique_inflow_is_kim_and_chungs_angle():
    commands = 3.0 * np.sin(0.05 * np.arange(400))
    effect = run("kim_chung", commands, 0.0, oblique_inflow={"angle": 0.8})
    angled = simulate(SETS["kim_chung"]._replace(inflow_angle=0.8), commands, DT)
    for name in ("n", "v", "ambient", "thrust"):
        assert getattr(effect, name) == pytest.approx(getattr(angled, name), abs=1e-12)


def test_recirculation_shows_after_its_delay_and_lowers_the_decay_of_the_steady_flow():
    plain, again = (run("hq", 3.0, 120.0, **e) for e in ({}, {"tank_recirculation": {"share": 0.8, "delay": 2.0}}))
    assert np.array_equal(again.ambient[:201], plain.ambient[:201])
    assert again.ambient[260] > plain.ambient[260]
    flow, thrust = again.ambient[-1], again.thrust[-1]
    assert 0.2396 * (1.0 - 0.8) * flow + 1.258 * flow**2 == pytest.approx(0.004855 * thrust, rel=1e-5)


# ---- the same equations written anew, by scipy


def hq_loads(n, v):
    force = 0.001467 * n * abs(n) - 0.3755 * abs(n) * v - 37.71 * v * abs(v)
    return force, 2.804e-6 * n * abs(n) - 9.948e-12 * abs(n) * v - 9.975e-8 * v * abs(v)


def hq_drive(u):
    return 737.2 * max(u - 0.86, 0.0) + 725.5 * min(u + 0.83, 0.0)


def axial(v, flow, force):
    return -1.102 * v - 67.37 * abs(v) * (v - 0.89 * flow) + 0.01232 * force


def ambient(flow, force):
    return -0.2396 * flow - 1.258 * flow * abs(flow) + 0.004855 * force


def scipys(rates, throttles, initial):
    """Return states (N + 1, M) under throttles held for one second each."""
    states = [np.asarray(initial, dtype=float)]
    for u in throttles:
        solution = solve_ivp(rates, (0.0, 1.0), states[-1], args=(u,), rtol=1e-9, atol=1e-11, max_step=0.01)
        states.append(solution.y[:, -1])
    return np.array(states)


THROTTLES = (4.0, -3.0, 0.0, 5.0, -5.0, 1.5)


def ours(**sizes):
    p = HQ._replace(u_dot_max=1e9)
    found = simulate(p, np.repeat(THROTTLES, 100), DT, largest_step=5e-4, effects=effect_values(sizes))
    return np.column_stack((found.n, found.v, found.ambient))[::100]


def test_scipy_agrees_on_sag_and_fading():
    def rates(t, x, u):
        n, v, flow, heat = x
        force, moment = hq_loads(n, v)
        drive = hq_drive(u) * (1.0 - 0.4 * heat)
        full = max(hq_drive(5.0), -hq_drive(-5.0))
        drive *= 1.0 - 0.3 * abs(drive * n) / (full**2 / 13.66)
        turn = -13.66 * n - 1856.0 * moment + drive
        return turn, axial(v, flow, force), ambient(flow, force), (abs(u) / 5.0 - heat) / 5.0

    sizes = {"supply_sag": {"share": 0.3}, "thermal_fade": {"share": 0.4, "time_constant": 5.0}}
    expected = scipys(rates, THROTTLES, np.zeros(4))
    assert ours(**sizes) == pytest.approx(expected[:, :3], rel=2e-4, abs=1e-4)


def test_scipy_agrees_on_inertia_current_and_flow():
    def rates(t, x, u):
        n, v, flow = x
        force, moment = hq_loads(n, v)
        turn = (-13.66 * n - 1856.0 * moment + hq_drive(u)) / 1.8
        force += -100.0 * v * abs(v) - 0.01 * turn
        return turn, axial(v, flow + 0.2, force) / 3.0, ambient(flow, force)

    sizes = {"rotor_inertia": {"share": 0.8}, "quadratic_flow_loss": {"coefficient": 100.0}}
    sizes |= {"entrained_water": {"impulse": 0.01}, "flow_lag": {"share": 2.0}, "ambient_current": {"speed": 0.2}}
    expected = scipys(rates, THROTTLES, np.zeros(3)) + np.array([0.0, 0.0, 0.2])
    assert ours(**sizes) == pytest.approx(expected, rel=2e-4, abs=2e-4)


def test_scipy_agrees_on_recirculation_by_the_method_of_steps():
    pieces = []

    def rates(t, x, u):
        n, v, flow = x
        force, moment = hq_loads(n, v)
        back = pieces[-1](t)[2] if pieces else 0.0
        turn = -13.66 * n - 1856.0 * moment + hq_drive(u)
        return turn, axial(v, flow, force), ambient(flow, force) + 0.9 * 0.2396 * back

    states = [np.zeros(3)]
    for u in THROTTLES:
        solution = solve_ivp(
            rates, (0.0, 1.0), states[-1], args=(u,), rtol=1e-9, atol=1e-11, max_step=0.01, dense_output=True
        )
        states.append(solution.y[:, -1])
        pieces.append(solution.sol)
    sizes = {"share": 0.9, "delay": 1.0}
    assert ours(tank_recirculation=sizes) == pytest.approx(np.array(states), rel=2e-4, abs=2e-4)
