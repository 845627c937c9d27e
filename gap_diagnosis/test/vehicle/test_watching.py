"""The arithmetic of the watch; what it finds in recordings is counted by its command."""

import numpy as np
import pytest

from gap_diagnosis.vehicle import branch
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.watching import Alarm, _fitted


def test_a_size_is_a_regression_along_the_size_that_was_followed() -> None:
    rng = np.random.default_rng(4)
    change, noise = rng.normal(size=(40, 13)), 0.01 * rng.normal(size=(40, 13))
    for true, followed in ((0.4, 0.3), (0.4, 1.0), (-0.01, 0.02)):
        body, rotor = np.zeros((3, 40, 13)), np.zeros((3, 40, 1))
        body[0] = 30.0 * true * change + noise
        body[1] = body[0] - 30.0 * followed * change
        _, sums, _ = accumulated(body, rotor, np.tile(np.eye(13), (40, 1, 1)), np.ones((40, 1)), np.full(2, 1e6))
        assert _fitted(followed, *sums[:, 0])[0] == pytest.approx(true, abs=1e-4)


def test_a_deviation_is_that_of_readings_worth_a_log_ratio_of_the_tail_and_of_a_bend() -> None:
    theta = 25.0 / np.log(58.0 / 16.0)  # 58 peaks of healthy minutes at 20, 16 at 45
    assert _fitted(0.3, 400.0, 400.0) == pytest.approx((0.3, 0.3 * np.sqrt(theta) / 20.0))
    assert _fitted(0.3, 8e8, 4e8) == pytest.approx((0.6, 0.03), rel=1e-3)


SENSORS = ("attitude", "gyro", "accelerometer", "depth", "velocity", "tachometer", "battery")
FAILURES = {h.place[:4] + h.parameters: h for h in hypotheses(load_model("ngs"), dict.fromkeys(SENSORS, True))}
LOSS, GYRO = FAILURES["thrust_loss", 3, None, None, "share"], FAILURES["imu_bias", None, None, "x", "rate"]


def alarm(size: float, deviation: float, probability: float = 0.98, failure: Hypothesis = LOSS) -> Alarm:
    """Return one of thruster 3, or of another part, found 12 s after it began."""
    return Alarm(
        failure=failure, size=size, deviation=deviation, log_ratio=200.0, probability=probability, since=31.0,
        found=43.0,
    )  # fmt: skip


def test_an_alarm_says_which_thruster_how_much_how_sure_and_how_long_after_it_began() -> None:
    assert alarm(0.25, 0.04).words == "thruster 3: loses 25 ± 4 % thrust, p 0.98; 12 s after it began"
    gyro = alarm(0.02, 0.004, failure=GYRO)
    assert gyro.words == "bias of the IMU (x): 0.020 ± 0.004 rad/s, p 0.98; 12 s after it began"
    assert (gyro.name, alarm(0.25, 0.04).name) == ("imu_bias x rate", "thrust_loss 3 share")


def test_a_loss_of_more_than_all_is_said_to_push_the_other_way() -> None:
    assert alarm(1.88, 0.1).words.startswith("thruster 3: pushes the other way (loses 188 ± 10 % thrust), p 0.98")
    assert alarm(1.1, 0.05).words.startswith("thruster 3: loses 110 ± 5 % thrust")


def test_a_deviation_is_never_said_to_be_nothing_nor_an_alarm_to_be_certain() -> None:
    assert "loses 39.2 ± 0.3 % thrust, p > 0.99" in alarm(0.3921, 0.0031, 0.9999).words
    assert "loses 39.21 ± 0.01 % thrust" in alarm(0.3921, 0.0001).words
    assert "loses 39 ± 10 % thrust" in alarm(0.3921, 0.0996).words


def accumulated(body, rotor, whitener, spread, ratios):  # type: ignore[no-untyped-def]
    """Return ratios, sums and beginnings after innovations: forgetting 0.5 a second, far beyond 4, doubt 0.3."""
    sums, since = np.zeros((2, len(ratios))), np.zeros(len(ratios))
    readings = branch.whitened(body, rotor, whitener, spread)
    branch.accumulated(readings, 4.0, 0.3, 0.5, 0.04, 10.0, ratios, sums, since)
    return ratios, sums, since


def test_log_ratios_are_cusums_of_halves_of_whitened_squares() -> None:
    rng = np.random.default_rng(3)
    B, K, N = 5, 40, 1
    body, rotor = rng.normal(size=(B, K, 13)), rng.normal(size=(B, K, N))
    whitener, spread = rng.normal(size=(K, 13, 13)) * 0.3, rng.uniform(0.5, 2.0, (K, N))
    body[:, rng.random((K, 13)) < 0.3] = np.nan
    ratios, sums, since = accumulated(body, rotor, whitener, spread, np.zeros(B - 1))
    r = np.einsum("kij,bkj->bki", whitener, np.nan_to_num(body)) * np.isfinite(body)
    r = np.concatenate((r, rotor / spread), axis=2)
    gain = (r[:1] ** 2 - r**2 - 0.3 * (r - r[:1]) ** 2) / (1.0 + (r[:1] / 4.0) ** 2)
    for j in range(B - 1):
        g, fitted, changed, begun = 0.0, 0.0, 0.0, 0.0
        for k in range(K):
            g += 0.5 * gain[j + 1, k].sum() - 0.02
            fitted += (r[0, k] * (r[0, k] - r[j + 1, k])).sum()
            changed += ((r[0, k] - r[j + 1, k]) ** 2).sum()
            if g < 0.0:
                g, fitted, changed, begun = 0.0, 0.0, 0.0, 10.0 + 0.04 * (k + 1)
        assert (ratios[j], *sums[:, j], since[j]) == pytest.approx((g, fitted, changed, begun))


def test_a_failure_whose_filter_has_lost_the_vehicle_is_not_believed() -> None:
    body, rotor = np.zeros((3, 5, 13)), np.zeros((3, 5, 1))
    body[1, 2:] = np.nan
    ratios, _, _ = accumulated(body, rotor, np.tile(np.eye(13), (5, 1, 1)), np.ones((5, 1)), np.full(2, 300.0))
    assert ratios[0] == pytest.approx(0.0)


def test_of_two_failures_that_are_both_far_off_the_nearer_one_gains() -> None:
    body, rotor = np.zeros((3, 5, 13)), np.zeros((3, 5, 1))
    body[0], body[1], body[2] = 50.0, 25.0, -60.0
    args = np.tile(np.eye(13), (5, 1, 1)), np.ones((5, 1))
    ratios, _, _ = accumulated(body, rotor, *args, np.zeros(2))
    assert ratios[0] > 100.0 and ratios[1] == 0.0
