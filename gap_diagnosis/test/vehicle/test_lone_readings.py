"""Outliers of sensors: what stands alone goes, what a vehicle does stays."""

import numpy as np
import pytest

from gap_diagnosis.vehicle.lone_readings import lone_readings


def test_a_reading_that_stands_alone_is_told_from_a_step_a_peak_and_noise() -> None:
    rng = np.random.default_rng(3)
    t = 0.05 * np.arange(400)
    speed = np.where(t > 5.0, 60.0 * (1.0 - np.exp(-8.0 * np.maximum(t - 5.0, 0.0))), 0.0)  # a rotor starts
    speed[300:] *= np.exp(-8.0 * (t[300:] - t[300]))  # and stops
    values = np.column_stack((speed, 0.4 * np.sin(t))) + rng.normal(size=(400, 2)) * [1.0, 0.005]
    assert not lone_readings(values, np.array([1.0, 0.005])).any()
    values[[50, 200], 0] += 90.0
    values[[120, 350], 1] -= 0.5
    assert np.flatnonzero(lone_readings(values, np.array([1.0, 0.005]))).tolist() == [50, 120, 200, 350]


@pytest.mark.parametrize("count", [0, 4])
def test_of_few_readings_none_stands_alone(count: int) -> None:
    assert not lone_readings(np.arange(float(count))[:, None] ** 4, np.array([1e-3])).any()


def test_what_stands_alone_all_the_time_is_what_the_sensor_tells() -> None:
    values = np.zeros((60, 1))
    values[::5] = 1.0
    assert not lone_readings(values, np.array([0.01])).any()
