"""The closed loop: repeatable, causal, on time, and what another integrator makes of the same steps."""

import math
import time

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rov_sim.bench_study.controllers import controller
from rov_sim.closed_loop import CALM, Controller, LoopRun, Plant, ProcessNoise, Timing, simulate_loop
from rov_sim.rig_sensors import Rig
from thruster_control.inner_loop import AT_REST, inner_loop_step
from thruster_control.references import REFERENCES
from thruster_estimation.belief import Level, level
from thruster_estimation.observers import observer_step
from thruster_model import flow_tank
from thruster_model.effects.active import ActiveEffects
from thruster_model.equations.thruster import thrust
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import derivative

HL = load_parameter_set("hl_bench").coefficients
TRUTH = HL._replace(c_u1=0.95 * HL.c_u1, c_T1=1.1 * HL.c_T1, k_n=1.05 * HL.k_n)
PERIOD = 0.04
EXACT = Rig(speed_noise=0.0, flow_noise=0.0, turbulence=0.0, spike_share=0.0, load_noise=0.0, quantised=False)
FORMS = ("bench", "proper")


def wanted(periods: int, begin: float = 4.0) -> np.ndarray:
    """Return the step's set point from shortly before its step."""
    return REFERENCES["step"].thrust(begin + PERIOD * np.arange(periods))


def run(form: str = "bench", strategy: str = "hl-ekf", periods: int = 50, **options) -> LoopRun:  # type: ignore[no-untyped-def]
    plant = options.pop("plant", Plant(coefficients=TRUTH))
    T_d = options.pop("T_d", wanted(periods))
    return simulate_loop(T_d, plant, controller(strategy, HL, form=form), **options)


def test_a_run_repeats_bit_for_bit_from_its_seed_and_only_from_its_seed() -> None:
    one, two, other = run(seed=(1, 2)), run(seed=(1, 2)), run(seed=(1, 3))
    for a, b in zip(one, two, strict=True):
        assert a.tobytes() == b.tobytes()
    assert not np.array_equal(one.of("u"), other.of("u"))


def test_process_noise_is_as_large_as_stated_remembers_as_long_and_moves_the_rotor() -> None:
    noise = ProcessNoise(rotor=30.0, flow=0.02, axial_flow=0.05, memory=0.5)
    drawn = noise.drawn(200_000, PERIOD, np.random.default_rng(0))
    assert np.std(drawn, axis=1) == pytest.approx([30.0, 0.02, 0.05], rel=0.03)
    alike = [float(np.corrcoef(row[1:], row[:-1])[0, 1]) for row in drawn]
    assert alike == pytest.approx(3 * [np.exp(-PERIOD / 0.5)], abs=0.01)
    calm, pushed = (run(plant=Plant(coefficients=TRUTH, process_noise=each), seed=4) for each in (CALM, noise))
    assert np.array_equal(calm.of("y_U")[:1], pushed.of("y_U")[:1])
    moved = pushed.true("speed") - calm.true("speed")
    assert moved[0] == 0.0 and 0.05 < np.std(moved) < 10.0
    with pytest.raises(ValueError, match="process noise: expected finite numbers"):
        ProcessNoise(rotor=-1.0)


def integrated(state: np.ndarray, u_0: float, commands: list[tuple[float, float]]) -> tuple[np.ndarray, float]:
    """Return (n, v, U) and the acting throttle after pieces (command [V], duration [s]), by scipy."""
    for command, duration in commands:
        ramp = min(abs(command - u_0) / TRUTH.u_dot_max, duration)
        for start, length, slope in ((0.0, ramp, math.copysign(TRUTH.u_dot_max, command - u_0)), (ramp, duration, 0.0)):
            end = length if slope else duration
            if end <= start:
                continue

            def rate(t, x, u=u_0, slope=slope, start=start):  # type: ignore[no-untyped-def]
                return derivative(*x, u + slope * (t - start), TRUTH)

            solved = solve_ivp(rate, (start, end), state, method="RK45", rtol=1e-8, atol=1e-10, max_step=5e-3)
            state, u_0 = solved.y[:, -1], u_0 + slope * (end - start)
    return state, u_0


def in_plain_python(T_d: np.ndarray, given: Controller, bench: bool, delay: float) -> dict[str, np.ndarray]:
    """Return what happens, by the public step functions in Python and scipy's integrator, with perfect sensors."""
    state, acting, before = np.zeros(3), 0.0, 0.0
    memory, belief, last = AT_REST, given.belief, 0.0
    rows = []
    for k, T in enumerate(map(float, T_d)):
        if not bench:
            dt = PERIOD if k else 0.0
            belief, _ = observer_step(belief, abs(state[0]), state[2], dt, last, given.observer, given.coefficients)
        usable = bench or level(belief.status) != Level.INVALID
        estimate = belief
        memory, out = inner_loop_step(
            memory, T, belief.n, belief.v, belief.U, usable, PERIOD, given.law, given.coefficients
        )
        rows.append((out.u, estimate.n, estimate.v, state[0], float(thrust(state[0], state[1], TRUTH))))
        if bench:
            belief, _ = observer_step(
                belief, abs(state[0]), state[2], PERIOD, out.u, given.observer, given.coefficients
            )
        state, acting = integrated(state, acting, [(before, delay), (out.u, PERIOD - delay)])
        before = last = out.u
    return dict(zip(("u", "n_hat", "v_hat", "n", "T"), np.transpose(rows), strict=True))


@pytest.mark.parametrize("form", FORMS)
def test_the_compiled_loop_is_what_plain_steps_and_another_integrator_make(form: str) -> None:
    T_d, delay = wanted(40), 0.01
    found = run(form, T_d=T_d, rig=EXACT, timing=Timing(computation=delay))
    expected = in_plain_python(T_d, controller("hl-ekf", HL, form=form), form == "bench", delay)
    assert np.ptp(expected["u"]) > 5.0
    np.testing.assert_allclose(found.of("u"), expected["u"], atol=2e-4)
    np.testing.assert_allclose(found.of("n"), expected["n_hat"], atol=5e-3)
    np.testing.assert_allclose(found.of("v"), expected["v_hat"], atol=1e-5)
    np.testing.assert_allclose(found.true("speed"), expected["n"], atol=5e-3)
    np.testing.assert_allclose(found.true("thrust"), expected["T"], atol=2e-3)


@pytest.mark.parametrize(("form", "first_changed"), [("bench", 21), ("proper", 20)])
def test_a_reading_changes_no_throttle_before_it_can(form: str, first_changed: int) -> None:
    flow = np.full(50, np.nan)
    flow[20] = 0.5
    usual, changed = run(form), run(form, flow=flow)
    assert np.array_equal(usual.of("u")[:first_changed], changed.of("u")[:first_changed])
    assert usual.of("u")[first_changed] != changed.of("u")[first_changed]


@pytest.mark.parametrize("form", FORMS)
def test_a_set_point_changes_nothing_before_its_period(form: str) -> None:
    later = wanted(50)
    later[30:] = -3.0
    usual, changed = run(form), run(form, T_d=later)
    steps = 40 * 30
    assert np.array_equal(usual.control[:, :30], changed.control[:, :30])
    assert np.array_equal(usual.plant[:, : steps + 1], changed.plant[:, : steps + 1])
    assert usual.of("u")[30] != changed.of("u")[30]


@pytest.mark.parametrize("delay", [0.0, 0.013, 0.04])
def test_a_throttle_acts_after_the_computation_delay_and_not_before(delay: float) -> None:
    """Open loop, against the open-loop simulator under the same throttle, shifted."""
    found = run(strategy="lookup", periods=30, timing=Timing(computation=delay))
    late = round(delay / 1e-3)
    sent = np.concatenate((np.zeros(late), np.repeat(found.of("acting"), 40)))[: 30 * 40]
    expected = flow_tank.simulate(TRUTH, sent, 1e-3)
    np.testing.assert_allclose(found.plant[3], expected.thrust, atol=1e-9)
    np.testing.assert_allclose(found.plant[2], expected.ambient, atol=1e-12)


@pytest.mark.parametrize(("form", "sample"), [("bench", -0.01), ("bench", 0.02), ("proper", -0.01)])
def test_a_reading_is_taken_at_its_instant(form: str, sample: float) -> None:
    found = run(form, rig=EXACT, timing=Timing(sample=sample))
    at = np.maximum(40 * np.arange(50) + round(sample / 1e-3), 0)
    np.testing.assert_array_equal(found.of("y_n"), np.abs(found.plant[0, at]))
    np.testing.assert_array_equal(found.of("y_U"), found.plant[2, at])


@pytest.mark.parametrize("form", FORMS)
def test_a_delay_of_the_command_as_an_effect_is_the_computation_delay(form: str) -> None:
    """The effect goes another way through the code: through the memory of the command's effects."""
    delayed = Plant(coefficients=TRUTH, effects=ActiveEffects(sizes={"command_delay": {"time": 0.02}}))
    one, other = run(form, plant=delayed, seed=4), run(form, timing=Timing(computation=0.02), seed=4)
    np.testing.assert_allclose(one.control, other.control, atol=1e-9)
    np.testing.assert_allclose(one.plant, other.plant, atol=1e-9)


def test_a_period_costs_the_same_however_many_came_before_it() -> None:
    """Ten times as many periods would take a hundred times as long if each went through all of the past."""
    sizes = {"tach_lag": {"time": 0.05}, "flow_delay": {"time": 0.3}, "command_delay": {"time": 0.02}}
    plant = Plant(coefficients=TRUTH, effects=ActiveEffects(sizes=sizes))
    run(plant=plant, periods=10)

    def cost(periods: int) -> float:
        costs = []
        for _ in range(5):
            begin = time.process_time()
            run(plant=plant, T_d=np.resize(wanted(100), periods))
            costs.append(time.process_time() - begin)
        return min(costs)

    assert cost(5000) < 40.0 * cost(500)


def test_an_effect_on_a_sensor_reaches_the_controller() -> None:
    scaled = Plant(coefficients=TRUTH, effects=ActiveEffects(sizes={"tach_scale": {"share": 0.1}}))
    found = run(plant=scaled, rig=EXACT)
    np.testing.assert_allclose(found.of("y_n"), 1.1 * np.abs(found.true("speed")), rtol=1e-12)


def test_the_load_cell_tells_the_mean_of_a_period_and_rings_if_it_is_asked_to() -> None:
    stiff, springy = run(rig=EXACT), run(rig=Rig(**{**vars(EXACT), "resonance": 15.0}))
    middle = 0.5 * (stiff.plant[3, 1:] + stiff.plant[3, :-1])
    np.testing.assert_allclose(stiff.force, middle.reshape(50, 40).mean(axis=1), rtol=1e-12)
    np.testing.assert_array_equal(stiff.load, stiff.force)
    np.testing.assert_array_equal(springy.force, stiff.force)
    assert 0.3 < np.max(np.abs(springy.load - springy.force)) < 10.0


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: Timing(computation=0.05), r"computation: expected 0 to 0.04 s; found 0.05 s"),
        (lambda: Timing(sample=0.0004), r"sample: expected a multiple of the step 0.001 s"),
        (lambda: Timing(step=0.01), r"step: expected above 0 and at most 0.001 s; found 0.01 s"),
        (lambda: run("proper", timing=Timing(sample=0.01)), r"expected a sample at or before .* found 0.01 s after"),
        (lambda: run(T_d=np.zeros((2, 2))), r"T_d: expected values of shape \(N,\)"),
        (lambda: run(flow=np.zeros(3)), r"flow: expected a reading for each of 50 periods; found shape \(3,\)"),
        (lambda: controller("hl-ekf", HL, form="euler"), r"form: expected one of bench, proper, gated; found 'euler'"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(make, text: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=text):
        make()
