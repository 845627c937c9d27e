"""Real recordings: what is read off them is right where the answer is known, and right on the bench's own."""

from pathlib import Path

import numpy as np
import pytest
from scipy.stats import spearmanr

from rov_sim.bench_study.claims import judged
from rov_sim.bench_study.controllers import THESIS, InputMap, controller
from rov_sim.bench_study.experiment import SCORES
from rov_sim.bench_study.fitted_map import fitted_map
from rov_sim.bench_study.prediction import compared
from rov_sim.bench_study.real_runs import (
    RealRun,
    load_means,
    lookup_lines,
    measured_disturbances,
    model_followed,
    real_score,
    recovered_map,
)
from rov_sim.bench_study.real_runs_io import controllers_told, read_real_runs
from rov_sim.closed_loop import LoopRun, Plant, Timing, simulate_loop
from rov_sim.rig_sensors import Rig
from rov_sim.study.results import Results
from rov_sim.study.statistics import mean_interval, rank_correlation, ratio_interval
from thruster_control.references import REFERENCES
from thruster_model.effects.active import NOTHING
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl_bench").coefficients
TIME = 0.04 * np.arange(251)
MAP = InputMap(760.0, -0.8, 720.0, 0.9)


def recorded(run: LoopRun, strategy: str, reference: str) -> RealRun:
    """Return a simulated run in the form of a recording, its load cell at 1 kHz from 0.4 s before the run on."""
    before = np.zeros(400)
    load = np.concatenate((before, run.plant[3, :-1]))
    return RealRun(
        name="simulated", strategy=strategy, reference=reference, period=0.04, T_d=run.T_d, u=run.of("u"),
        y_n=run.of("y_n"), y_U=run.of("y_U"), n_d=run.of("n_d"), n_hat=run.of("n"), v_hat=run.of("v"),
        U_hat=run.of("U"), load_time=1e-3 * np.arange(load.size), load=load, start=0.4, matched_start=0.4,
    )  # fmt: skip


@pytest.fixture(scope="module")
def ramp() -> RealRun:
    plant = Plant(coefficients=HL._replace(**MAP._asdict()))
    timing = Timing(sample=0.012)
    run = simulate_loop(REFERENCES["ramp"].thrust(TIME), plant, controller("hl-ekf", HL), timing=timing, seed=2)
    return recorded(run, "hl-ekf", "triangle")


def test_the_plant_s_input_map_and_the_instant_of_sampling_are_found_from_a_wrong_start(ramp: RealRun) -> None:
    found = fitted_map([ramp], HL, NOTHING)
    assert found.tau == pytest.approx(0.012, abs=2e-3)
    np.testing.assert_allclose(found.input_map, MAP, rtol=0.02)
    assert found.left < 1.1 < found.before


def test_the_controllers_input_map_is_read_off_the_law_that_was_run(ramp: RealRun) -> None:
    """u by (4.24)-(4.26) in the rig's order, written out here, from estimates that are noise."""
    n_d, v, rng = ramp.n_d.copy(), ramp.v_hat, np.random.default_rng(1)
    n_hat = n_d + 2.0 * rng.standard_normal(n_d.size)
    u, sigma = np.zeros(n_d.size), 0.0
    for k in range(n_d.size):
        e = n_hat[k] - n_d[k]
        sigma += 0.04 * e
        Q = HL.c_Q1 * n_d[k] * abs(n_d[k]) - HL.c_nv_Q * abs(n_d[k]) * v[k]
        alpha = -e / 0.04 + HL.k_n * n_d[k] + HL.k_Q * Q - 5.0 * e - 10.0 * sigma
        u[k] = alpha / MAP.c_u1 + MAP.delta_u1 if alpha < 0 else alpha / MAP.c_u2 + MAP.delta_u2
    found = recovered_map([RealRun(**{**vars(ramp), "n_hat": n_hat, "u": np.clip(u, -3.0, 3.0)})], HL)
    np.testing.assert_allclose(found.input_map, MAP, rtol=1e-6)
    assert found.largest_remainder < 1e-9
    with pytest.raises(ValueError, match="expected at least 10 samples in reverse; found 0"):
        recovered_map([RealRun(**{**vars(ramp), "n_hat": n_hat, "u": np.full(251, 1.0)})], HL)


@pytest.mark.parametrize("model", ["hl", "hq"])
def test_the_model_that_a_controller_followed_is_read_off_its_wanted_speed(model: str) -> None:
    models = {name: load_parameter_set(f"{name}_bench").coefficients for name in ("hl", "hq")}
    T_d = REFERENCES["sine"].thrust(TIME)
    run = simulate_loop(T_d, Plant(coefficients=HL), controller(f"{model}-ekf", models[model]), seed=3)
    n_d = run.of("n_d")
    assert model_followed(T_d, n_d, run.of("v"), models) == model
    assert model_followed(T_d, 1.1 * n_d, run.of("v"), models) is None
    assert model_followed(T_d, n_d, np.full(T_d.size, np.nan), models) is None


def test_a_controller_is_told_as_hl_or_hq() -> None:
    assert controllers_told(["CLx=hq"]) == {"CLx": "hq"}
    with pytest.raises(ValueError, match="--controller: expected RUN=hl or RUN=hq; found 'CLx=ekf'"):
        controllers_told(["CLx=ekf"])


def test_a_recording_is_scored_as_a_simulation_is(ramp: RealRun) -> None:
    means = load_means(ramp)
    assert means[100] == pytest.approx(np.mean(ramp.load[400 + 4000 : 400 + 4040]))
    assert real_score(ramp).samples == 206
    shifted = RealRun(**{**vars(ramp), "matched_start": 0.3})
    assert real_score(shifted, matched=True).rmse > real_score(shifted).rmse


def test_noise_and_spikes_are_measured_as_they_were_put_in() -> None:
    rig = Rig(spike_share=0.05, spike_size=0.4, speed_noise=1.5, turbulence=0.0)
    runs = []
    for seed in range(12):
        T_d = REFERENCES["step"].thrust(TIME)
        run = simulate_loop(T_d, Plant(coefficients=HL), controller("hl-ekf", HL), rig=rig, seed=seed)
        runs.append(recorded(run, "hl-ekf", "step"))
    found = measured_disturbances(runs)
    assert found.speed_noise == pytest.approx(1.5, rel=0.15)
    # 15 % of the second differences hold a spike: the median is then that of 59 % of the others, 1.2 times as large
    assert found.flow_noise == pytest.approx(1.2 * 0.0035, rel=0.12)
    assert found.spike_share == pytest.approx(0.05 * 0.80, abs=0.015)  # a fifth of the spikes is below 0.1 m/s
    assert 0.2 < found.spike_size < 0.3  # of 0.4 m/s, the converter ends at 0.3 m/s


def test_the_table_of_an_open_loop_recording_is_its_two_lines() -> None:
    n_d = np.linspace(-100.0, 100.0, 251)
    u = np.where(n_d < 0, -0.77 + 0.02 * n_d, 0.81 + 0.021 * n_d)
    nothing = np.full(251, np.nan)
    run = RealRun(
        name="x", strategy="lookup", reference="sine", period=0.04, T_d=n_d / 10, u=u, y_n=abs(n_d), y_U=nothing,
        n_d=n_d, n_hat=nothing, v_hat=nothing, U_hat=nothing, load_time=TIME, load=TIME, start=0.0, matched_start=0.0,
    )  # fmt: skip
    table = lookup_lines([run])
    assert table is not None
    np.testing.assert_allclose(table[0], [-3.0, -0.77, 0.81, 3.0])
    np.testing.assert_allclose(table[2], [-2.23 / 0.02, 0.0, 0.0, 2.19 / 0.021])
    assert lookup_lines([]) is None


def test_the_bench_s_own_recordings_give_the_known_scores_and_one_input_map(thruster_bench_data: Path) -> None:
    runs = read_real_runs(thruster_bench_data / "closed_loop")
    assert {run.strategy for run in runs} == {"lookup", "simplified", "hl-ekf", "hl-nlo", "hl-kfnlo"}
    alone = [recovered_map([run], HL) for run in runs if run.strategy in ("simplified", "hl-nlo", "hl-kfnlo")]
    for each in alone:
        np.testing.assert_allclose(each.input_map, alone[0].input_map, rtol=1e-4)
        assert each.largest_remainder < 1e-4  # V
    rmse = {run.name: real_score(run).rmse for run in runs}
    assert 2.0 < rmse["CL2stateKFNLO1Step"] < 3.0 and 0.6 < rmse["CL2stateKF1Sine"] < 1.0
    assert abs(runs[0].start - runs[0].matched_start) < 0.01


def test_a_prediction_is_held_against_the_mean_of_the_other_runs(ramp: RealRun) -> None:
    names = ("step", "step", "sine")
    runs = [RealRun(**{**vars(ramp), "reference": name, "load": k * ramp.load}) for k, name in enumerate(names, 1)]
    real = np.array([real_score(run).rmse for run in runs])
    found = compared(runs, np.tile(real[:, None], (1, 3)), np.random.default_rng(0))
    a, b, c = real
    assert found.rmse == pytest.approx(0.0, abs=1e-12) and found.inside == 3
    alike = np.sqrt(((b - a) ** 2 + (a - b) ** 2 + (0.5 * (a + b) - c) ** 2) / 3.0)
    others = np.sqrt(((0.5 * (b + c) - a) ** 2 + (0.5 * (a + c) - b) ** 2 + (0.5 * (a + b) - c) ** 2) / 3.0)
    assert found.constants == pytest.approx((others, alike))


def test_the_rank_correlation_is_scipy_s_and_its_p_value_that_of_all_orders() -> None:
    rng = np.random.default_rng(2)
    x, y = rng.normal(size=7), rng.normal(size=7)
    assert rank_correlation(x, y, rng).rho == pytest.approx(spearmanr(x, y).statistic)
    perfect = rank_correlation([1.0, 2.0, 3.0], [5.0, 6.0, 9.0], rng)
    assert perfect.rho == pytest.approx(1.0) and perfect.p_value == pytest.approx(1 / 6)
    with pytest.raises(ValueError, match="at least 3 finite pairs"):
        rank_correlation([1.0, 2.0], [1.0, 2.0], rng)


def test_intervals_cover_the_mean_as_often_as_they_say() -> None:
    rng = np.random.default_rng(7)
    inside = [i.low <= 3.0 <= i.high for i in (mean_interval(3.0 + rng.normal(size=40), rng) for _ in range(300))]
    assert np.mean(inside) == pytest.approx(0.9, abs=4 * (0.09 / 300) ** 0.5 + 0.02)
    pairs = 1.0 + rng.random(50)
    exact = ratio_interval(0.7 * pairs, pairs, rng)
    assert exact.low == pytest.approx(0.7) == exact.high


def made_up(rmse: dict[str, float], **others: dict[str, float]) -> Results:
    rng = np.random.default_rng(1)
    scatter = 0.01 * rng.standard_normal(50)
    scores = {}
    for s in THESIS:
        values = {name: others.get(name, {}).get(s, 1.0) + scatter for name in SCORES}
        scores[s, "step"] = {**values, "rmse": rmse[s] + 0.01 * rng.standard_normal(50)}
    return Results(scores=scores)


def test_a_score_that_a_study_lacks_is_refused_with_those_that_it_has() -> None:
    study = Results(scores={("hl-ekf", "step"): {"rmse": np.ones(3)}})
    with pytest.raises(ValueError, match="expected scores of lookup on step; found those of hl-ekf on step"):
        study.normalised("hl-ekf", "step")


def test_statements_are_confirmed_where_the_numbers_say_so_and_not_where_they_do_not() -> None:
    base = dict.fromkeys(THESIS, 0.9)
    good = {**base, "lookup": 1.0, "simplified": 1.0, "hl-ekf": 0.8, "hq-ekf": 0.75, "hq-nlo": 0.85, "hq-kfnlo": 0.85}
    swing = {"lookup": 0.3, "simplified": 0.3, **dict.fromkeys(THESIS[2:], 0.05)}
    wide = dict.fromkeys(THESIS, 0.5)
    v_hat = {"hl-nlo": 1.2, "hl-kfnlo": 1.2, "hq-nlo": 1.2, "hq-kfnlo": 1.2}
    quiet = made_up(good)
    verdicts = [c.verdict for c in judged(made_up(good, overshoot=swing, largest=wide, v_hat=v_hat), quiet)]
    assert verdicts == ["confirmed"] * 7
    bad = {**base, "lookup": 0.5, "hl-ekf": 1.1, "hq-ekf": 1.2, "hl-kfnlo": 0.7, "hq-kfnlo": 0.75, "hq-nlo": 1.0}
    flat = made_up(bad, overshoot=dict.fromkeys(THESIS, 0.1), largest=dict.fromkeys(THESIS, 4.0))
    assert [c.verdict for c in judged(flat, quiet)] == ["not confirmed"] * 7
    assert judged(flat)[3].verdict == "not tested"
