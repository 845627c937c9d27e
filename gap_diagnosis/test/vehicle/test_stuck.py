"""Sensors that tell nothing new."""

from typing import Any

import numpy as np
import pytest

from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog
from gap_diagnosis.vehicle.stuck import Stuck, longest_unchanged

DEPTH = CHANNELS_OF["depth"].start


def piece(depth: Any, seed: int = 0) -> VehicleLog:
    """Return a second of a vehicle whose gyro is well, with these depths at its 25 instants."""
    rng = np.random.default_rng(seed)
    told = np.full((25, 13), np.nan)
    told[:, CHANNELS_OF["gyro"]] = rng.normal(size=(25, 3))
    told[:, DEPTH] = depth
    return VehicleLog(
        name="dive", period=0.04, commands=np.zeros((25, 4, 1)), attitude=np.full((25, 4), np.nan), told=told,
        speeds=np.full((25, 1), np.nan), signed=True, battery=np.full((25, 2), np.nan), noise=np.ones(13),
        speed_noise=np.ones(1), battery_noise=np.ones(2), lateness=np.zeros((25, 6)),
    )  # fmt: skip


def walked(seed: int, step: float = 0.0) -> Any:
    depths = np.cumsum(0.01 * np.random.default_rng(seed).normal(size=25))
    return np.round(depths / step) * step if step else depths


def test_a_reading_that_stands_still_is_left_out_until_it_moves_again() -> None:
    stuck, kept = Stuck({"depth": 0.1, "gyro": 0.1}), []
    for second in range(16):
        depths = np.full(25, 1.7) if 4 <= second < 12 else walked(second)
        kept.append(bool(np.isfinite(stuck.step(piece(depths, second), float(second)).told[:, DEPTH]).any()))
        if second == 11:
            assert stuck.words(12.0) == {"depth": "depth: nothing new for 8 s; it is left out"}
    assert kept == [not 9 <= second < 12 for second in range(16)]
    assert not stuck.words(16.0)


def test_a_sensor_that_falls_silent_is_said_to() -> None:
    stuck = Stuck({"depth": 0.1})
    for second in range(8):
        stuck.step(piece(walked(second) if second < 2 else np.nan, second), float(second))
    assert stuck.words(8.0) == {"depth": "depth: nothing new for 6 s; it is left out"}


def test_only_a_reading_that_came_again_and_again_misleads() -> None:
    still, silent = Stuck({"depth": 0.1}), Stuck({"depth": 0.1})
    for second in range(8):
        still.step(piece(walked(second) if second < 2 else 1.7, second), float(second))
        silent.step(piece(walked(second) if second < 2 else np.nan, second), float(second))
    assert (still.misleading, silent.misleading) == ({"depth": 2.0}, {})
    assert set(still.since) == set(silent.since) == {"depth"}


@pytest.mark.parametrize(("coarse", "most"), [(0.0, 0.04), (0.5, 1.0)])
def test_what_the_healthy_vehicles_coarse_sensor_repeats_is_not_stuck(coarse: float, most: float) -> None:
    found = longest_unchanged([piece(walked(3, coarse))])
    assert found["depth"] == pytest.approx(most) and found["gyro"] == pytest.approx(0.04)
    assert set(found) == {"depth", "gyro"}
    stuck = Stuck({"depth": 4.0})
    for second in range(14):
        stuck.step(piece(np.full(25, 1.7), second), float(second))
        assert ("depth" in stuck.since) == (second >= 12)
