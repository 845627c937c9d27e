"""Reference observers: the smoother against dense least squares, both against truth, beside the EKF; refusals."""

from pathlib import Path

import numpy as np
import pytest
from thruster_truth import DT, HL, Array, rate, truth

from run_bag import Topic, write_run
from thruster_estimation.belief import initial_belief
from thruster_estimation.cli_replay import main
from thruster_estimation.errors import EstimationError
from thruster_estimation.offline import observe
from thruster_estimation.reference import look_back
from thruster_estimation.replay import Job, problem_with
from thruster_estimation.settings import BENCH, EkfSettings, bench_settings

COUNT = 250
THROTTLES = 2.5 * np.sin(0.08 * np.arange(COUNT) + 0.4)
SETTINGS = EkfSettings(q_n=300.0, q_v=2e-4, q_U=2e-4, r_n=4.0, r_U=4e-4, unsigned=0)
START = initial_belief(deviation_n=5.0, deviation_v=0.05, deviation_U=0.05)


def measured(seed: int) -> tuple[Array, Array, Array]:
    """Return states of a thruster that is pushed as the settings say, and readings of n and U with their noise."""
    rng, fine = np.random.default_rng(seed), 40
    x, h, found = np.zeros(3), DT / fine, []
    push = np.sqrt([SETTINGS.q_n * h, SETTINGS.q_v * h, SETTINGS.q_U * h])
    for u in THROTTLES:
        for _ in range(fine):
            x = x + h * rate(x, u, HL) + push * rng.standard_normal(3)
        found.append(x)
    states = np.array(found)
    noise = rng.standard_normal((2, COUNT))
    return states, states[:, 0] + SETTINGS.r_n**0.5 * noise[0], states[:, 2] + SETTINGS.r_U**0.5 * noise[1]


def looked_back(name: str, y_n: Array, y_U: Array):  # type: ignore[no-untyped-def]
    return look_back(name, y_n, y_U, THROTTLES, np.full(y_n.size, DT), START, SETTINGS, HL)


def test_where_a_state_stands_alone_and_is_linear_the_smoother_is_dense_least_squares() -> None:
    # dU/dt = -k_U U + w: no thrust, no square; v takes no U in
    p = HL._replace(k_UU=0.0, k_TU=0.0, k_w=0.0)
    y = 0.1 + 0.02 * np.random.default_rng(3).standard_normal(40)
    y[[7, 8, 20]] = np.nan
    dt = np.where(np.arange(40) == 15, 0.2, DT)
    found = look_back("rts", np.zeros(40), y, np.zeros(40), dt, START, SETTINGS, p)
    a = np.exp(-p.k_U * dt)
    q = SETTINGS.q_U * (1.0 - a**2) / (2.0 * p.k_U)
    information, weighted = np.zeros((41, 41)), np.zeros(41)
    information[0, 0] = 1.0 / START.P_UU
    for k in range(40):
        step = np.zeros(41)
        step[k : k + 2] = -a[k], 1.0
        information += np.outer(step, step) / q[k]
        if np.isfinite(y[k]):
            information[k + 1, k + 1] += 1.0 / SETTINGS.r_U
            weighted[k + 1] += y[k] / SETTINGS.r_U
    covariance = np.linalg.inv(information)
    np.testing.assert_allclose(found.U, (covariance @ weighted)[1:], atol=1e-7)
    np.testing.assert_allclose(found.P_UU, np.diag(covariance)[1:], rtol=1e-5)


@pytest.mark.parametrize("name", ["ukf", "rts"])
def test_errors_are_as_large_as_the_deviations_say(name: str) -> None:
    ratios = []
    for seed in range(4):
        states, y_n, y_U = measured(seed)
        found = looked_back(name, y_n, y_U)
        errors = np.stack([found.n, found.v, found.U], axis=1) - states
        ratios.append(
            np.mean(errors[20:] ** 2, axis=0) / np.stack([found.P_nn, found.P_vv, found.P_UU])[:, 20:].mean(1)
        )
    assert np.mean(ratios, axis=0) == pytest.approx(1.0, abs=0.35)


def test_the_smoother_is_nearer_than_the_filters_and_these_are_alike() -> None:
    errors: dict[str, list[Array]] = {"ekf": [], "ukf": [], "rts": []}
    for seed in range(4):
        states, y_n, y_U = measured(10 + seed)
        histories = {name: looked_back(name, y_n, y_U) for name in ("ukf", "rts")}
        histories["ekf"] = observe(y_n, y_U, THROTTLES, DT, START, SETTINGS, HL)
        for name, found in histories.items():
            errors[name].append(np.stack([found.n, found.v, found.U], axis=1) - states)
    rms = {name: np.sqrt(np.mean(np.square(found), axis=(0, 1))) for name, found in errors.items()}
    assert rms["ukf"] == pytest.approx(rms["ekf"], rel=0.1)
    assert np.all(rms["rts"] < [0.97, 1.0, 0.85] * rms["ukf"])


def test_an_unsigned_speed_takes_the_sign_of_the_belief_and_what_is_missing_is_predicted() -> None:
    states, y_n, y_U = measured(5)
    unsigned = SETTINGS._replace(unsigned=1)
    magnitude = np.where(np.arange(COUNT) % 5 == 0, np.nan, abs(y_n))
    found = look_back("ukf", magnitude, y_U, THROTTLES, np.full(COUNT, DT), START, unsigned, HL)
    fast = abs(states[:, 0]) > 20.0
    assert np.all(np.sign(found.n[fast]) == np.sign(states[fast, 0]))
    assert np.isnan(found.y_n[::5]).all() and np.all(found.used_n[::5] == 0.0) and np.all(found.used_n[1::5] == 1.0)


def test_they_are_scored_beside_the_observers_of_a_recording(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    states = truth(THROTTLES, (0.0, 0.0, 0.0), HL)

    def topic(name: str, kind: str, stamps: Array, **fields: Array) -> Topic:
        ticks = np.round(1e9 * (1.0 + stamps)).astype(np.int64)
        return Topic(name=f"thruster_0/{name}", type=f"thruster_msgs/{kind}", stamps=ticks, fields=fields)

    at = DT * np.arange(COUNT)
    write_run(tmp_path / "run", [
        topic("throttle", "Throttle", at, commanded=THROTTLES),
        topic("state", "ThrusterState", at + DT, n=states[:, 0], sign_source=np.ones(COUNT, dtype=np.uint8)),
        topic("flow", "FlowVelocity", at + DT, ambient=states[:, 2], axial=states[:, 1]),
        topic("truth", "ThrusterTruth", at + DT, n=states[:, 0], axial=states[:, 1], ambient=states[:, 2]),
    ])  # fmt: skip
    assert main([str(tmp_path / "run"), "--observer", "ekf", "ukf", "rts", "--out", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    assert "ukf, hl" in told and "rts, hl: RMS difference to truth" in told
    assert "rts, hl" in (tmp_path / "out/report.html").read_text("utf-8")


def test_what_references_do_not_have_is_a_sentence_and_a_lost_covariance_too() -> None:
    for changed in ({"form": BENCH}, {"gate": 16.0}):
        settings = bench_settings("ekf")._replace(**changed)
        assert "expected the proper form without a gate" in problem_with(Job("ukf", "hl", settings, HL))
    wrong = START._replace(P_vv=-1.0)
    with pytest.raises(EstimationError, match="ukf: expected a covariance at sample 0; found"):
        look_back("ukf", np.zeros(3), np.zeros(3), np.zeros(3), np.full(3, DT), wrong, SETTINGS, HL)
