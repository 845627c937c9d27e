"""The plant behind the emulated device: against an independent integration, its means, its noise, its refusals."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from bench_driver.device import Outputs
from bench_driver.text_protocol import flow_from_count, speed_from_count
from rov_sim.emulated_bench import QUIET, BenchPlant, BenchSettings
from rov_sim.rig_sensors import Rig
from thruster_model.effects.active import ActiveEffects
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import derivative, outputs
from thruster_model.whole_run import readings, simulated_rows

P = load_parameter_set("hl_bench").coefficients
PLAIN = BenchSettings(coefficients=P, rig=QUIET)


def throttles(u: float) -> Outputs:
    return Outputs(throttles=(u,), enabled=(True,), data=b"")


def run(plant: BenchPlant, u: float, duration: float) -> None:
    for _ in range(round(duration / 0.001)):
        plant(0.001, throttles(u))


@pytest.mark.parametrize("u", [2.0, -3.0])
def test_the_plant_follows_an_integration_by_other_code(u: float) -> None:
    plant = BenchPlant(PLAIN)
    run(plant, u, 1.5)

    def rates(t: float, x: np.ndarray) -> tuple[float, float, float]:
        return derivative(*x, np.sign(u) * min(P.u_dot_max * t, abs(u)), P)

    found = solve_ivp(rates, (0.0, 1.5), np.zeros(3), rtol=1e-9, atol=1e-12, max_step=2e-3)
    n, v, U = found.y[:, -1]
    now = plant.truth()
    assert (now.n, now.v, now.U) == pytest.approx((n, v, U), rel=1e-5)
    assert pytest.approx(outputs(n, v, U, u, P)[2:], rel=1e-5) == (now.T, now.Q)
    assert now.u == u


def test_the_pieces_in_which_time_passes_make_no_difference() -> None:
    fine, coarse = BenchPlant(PLAIN), BenchPlant(PLAIN)
    run(fine, 1.7, 0.4)
    for _ in range(10):
        coarse(0.04, throttles(1.7))
    assert fine.truth() == pytest.approx(coarse.truth(), rel=1e-12)
    assert fine.mean_thrust() == pytest.approx(coarse.mean_thrust(), rel=1e-12)


def test_an_effect_with_memory_acts_as_in_the_flow_tank() -> None:
    from thruster_model.flow_tank import simulate

    effects = ActiveEffects(sizes={"tank_recirculation": {"share": 0.6, "delay": 1.0}})
    plant = BenchPlant(replace(PLAIN, effects=effects))
    run(plant, 2.0, 2.0)
    tank = simulate(P, np.full(2000, 2.0), 1e-3, effects=effects.plant)
    assert plant.truth()[:3] == pytest.approx((tank.n[-1], tank.v[-1], tank.ambient[-1]), rel=1e-9)
    assert abs(plant.truth().U / simulate(P, np.full(2000, 2.0), 1e-3).ambient[-1] - 1.0) > 0.01


def test_the_mean_thrust_is_the_integral_over_the_time_since_it_was_asked_for() -> None:
    plant = BenchPlant(PLAIN)
    run(plant, 2.0, 0.3)
    plant.mean_thrust()
    samples = [plant.truth().T]
    for _ in range(40):
        run(plant, 2.0, 0.001)
        samples.append(plant.truth().T)
    mean = np.trapezoid(samples, dx=1.0) / 40
    assert plant.mean_thrust() == pytest.approx((mean, mean), rel=1e-9)
    assert np.isnan(plant.mean_thrust().true), "no time has passed"


def test_counts_are_those_of_the_true_speed_and_flow() -> None:
    plant = BenchPlant(PLAIN)
    run(plant, -2.0, 2.0)
    read, now = plant.read(), plant.truth()
    assert speed_from_count(read.tachometer_counts[0]) == pytest.approx(abs(now.n), abs=0.13)
    assert flow_from_count(read.flow_counts[0]) == pytest.approx(now.U, abs=3.0e-4)
    assert now.U < -0.02
    assert read.load_counts == ()


def test_noise_is_held_over_a_period_has_its_size_and_comes_from_the_seed() -> None:
    rig = replace(QUIET, flow_noise=0.01)

    def readings(seed: int) -> np.ndarray:
        plant = BenchPlant(BenchSettings(coefficients=P, rig=rig, seed=seed))
        found = []
        for _ in range(2 * 400):
            found.append(flow_from_count(plant.read().flow_counts[0]))
            plant(0.02, throttles(0.0))
        return np.array(found).reshape(-1, 2)

    first = readings(1)
    assert np.all(first[:, 0] == first[:, 1])
    assert np.std(first[:, 0]) == pytest.approx(0.01, rel=4 / np.sqrt(800))
    assert np.array_equal(first, readings(1))
    assert not np.array_equal(first, readings(2))


def test_the_load_cells_mean_is_noisy_as_the_rigs() -> None:
    plant = BenchPlant(BenchSettings(coefficients=P, rig=Rig(), seed=4))
    off = []
    for _ in range(500):
        plant(0.04, throttles(0.0))
        told = plant.mean_thrust()
        off.append(told.told - told.true)
    assert np.std(off) == pytest.approx(Rig().load_noise, rel=4 / np.sqrt(1000))


def test_effects_on_commands_and_sensors_act_as_in_a_whole_run() -> None:
    sizes = {
        "command_delay": {"time": 0.0305}, "command_quantization": {"step": 0.4}, "load_cell_scale": {"share": 0.1},
        "tach_lag": {"time": 0.1}, "flow_delay": {"time": 0.2},
        "load_cell_resonance": {"frequency": 6.0, "damping": 0.1},
    }  # fmt: skip
    effects = ActiveEffects(sizes=sizes)
    loads: list[tuple[float, ...]] = []
    plant = BenchPlant(replace(PLAIN, effects=effects), loads=lambda wrench: loads.append(wrench) or ())
    sent = 3.0 * np.sign(np.sin(9.0 * np.arange(1000) * 1e-3))
    rows = simulated_rows(P, sent, 1e-3, effects=effects.plant)
    told = readings(rows, 1e-3, effects.sensors)
    for k, u in enumerate(sent, start=1):
        read = plant(0.001, throttles(u))
        assert (loads[-1][0], loads[-1][3]) == (told[3, k], told[4, k])
        assert speed_from_count(read.tachometer_counts[0]) == pytest.approx(abs(told[0, k]), abs=0.13)
    assert plant.truth()[:5] == tuple(rows[:5, -1])
    mean = plant.mean_thrust()
    assert mean.told == pytest.approx(np.trapezoid(told[3], dx=1e-3) / 1.0, rel=1e-9)
    assert abs(mean.told - mean.true) > 0.01


def test_a_period_costs_the_same_after_an_hour_as_in_the_first_second() -> None:
    sizes = {"flow_delay": {"time": 1.0}, "command_delay": {"time": 0.2}, "tach_lag": {"time": 0.1}}
    plant = BenchPlant(replace(PLAIN, effects=ActiveEffects(sizes=sizes)))
    run(plant, 2.0, 0.1)

    def remembered() -> int:
        return sum(array.size for array in (*plant._memory, *plant._sensors, plant._true, plant._read))

    def cost() -> float:
        costs = []
        for _ in range(20):
            begin = time.process_time()
            run(plant, 2.0, 0.02)
            costs.append(time.process_time() - begin)
        return min(costs)

    first, size = cost(), remembered()
    for _ in range(360):
        plant(10.0, throttles(2.0))
    run(plant, 2.0, 0.001)
    assert plant.time > 3600.0
    assert remembered() == size
    assert cost() < 4.0 * first


def test_the_propeller_draws_air_in_stretches() -> None:
    effects = ActiveEffects(sizes={"ventilation": {"share": 0.6, "onset": 20.0}})
    plant = BenchPlant(replace(PLAIN, effects=effects, seed=3))
    ratios = []
    for _ in range(400):
        plant(0.04, throttles(2.5))
        now = plant.truth()
        ratios.append(now.T / outputs(now.n, now.v, now.U, now.u, P)[2])
    settled = np.array(ratios[50:])
    assert 0.1 < np.mean(settled < 0.5) < 0.8
    assert set(np.round(settled, 6)) == {0.4, 1.0}


@pytest.mark.parametrize("period", [0.0, 0.0005, 0.0015])
def test_a_period_between_the_steps_is_refused(period: float) -> None:
    with pytest.raises(ValueError, match=r"multiple of 0\.001 s"):
        BenchPlant(PLAIN)(period, throttles(0.0))
