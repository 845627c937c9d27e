"""What a driver is told: wrong settings are refused with everything that is wrong; the load cell's matrix."""

import numpy as np
import pytest

from bench_driver.device_clock import DeviceClock, SharedClock
from bench_driver.driver_settings import DriverSettings, LoadCell
from bench_driver.errors import SettingsRefused


def test_everything_wrong_is_said_at_once() -> None:
    with pytest.raises(SettingsRefused) as refused:
        DriverSettings(port="", thrusters=2, poll=0.0)
    said = str(refused.value)
    for part in ("port: expected the name", "thrusters: expected 1 to 1 with the protocol text; found 2", "poll: "):
        assert part in said
    assert len(refused.value.problems) == 3


@pytest.mark.parametrize(
    ("matrix", "rest", "said"),
    [
        ([1.0] * 35, [0.0] * 6, "load_matrix: expected no or 36 finite numbers; found 35"),
        ([], [0.0] * 5, "load_rest: expected 6 finite numbers; found 5"),
        ([float("nan")] * 36, [0.0] * 6, "load_matrix"),
    ],
)
def test_a_load_cell_with_other_numbers_is_refused(matrix: list[float], rest: list[float], said: str) -> None:
    with pytest.raises(SettingsRefused, match=said):
        LoadCell.of(matrix, rest)


def test_a_wrench_comes_back_from_its_counts_to_half_a_step_of_the_converter() -> None:
    rng = np.random.default_rng(3)
    matrix = np.diag([20.0, 20.0, 20.0, 2.0, 2.0, 2.0]) + 0.1 * rng.standard_normal((6, 6))
    cell = LoadCell.of(matrix.ravel(), [2.5] * 6)
    wrench = np.array([9.0, -3.0, 1.0, 0.2, -0.5, 0.1])
    told = cell.wrench(cell.volts(cell.counts(wrench)))
    step = 0.5 * 5.0 / 1024 * np.abs(matrix).sum(axis=1)
    assert np.all(np.abs(told - wrench) <= step + 1e-12)
    assert np.any(told != wrench)


def test_channels_that_the_device_has_not_are_not_measured() -> None:
    volts = LoadCell().volts((512, 0))
    assert volts[:2].tolist() == [2.5, 0.0]
    assert np.all(np.isnan(volts[2:]))


def test_a_shared_clock_takes_the_devices_stamps_and_survives_wrap_and_reset() -> None:
    clock = SharedClock()
    assert clock.stamp(2.02, 2_010_000, on_line=0.004) == pytest.approx(2.01)
    wrapped = 2**32 / 1e6
    assert clock.stamp(wrapped + 0.02, 10_000) == pytest.approx(wrapped + 0.01)
    assert clock.restarts == 0
    assert clock.stamp(5000.0, 3_000, on_line=0.004) == pytest.approx(4999.996), "it began anew: its arrival counts"
    assert clock.restarts == 1
    assert clock.stamp(5000.01, 13_000, on_line=0.004) == pytest.approx(5000.006)


def test_lockstep_shares_the_clock_and_real_time_maps_it() -> None:
    for lockstep, kind in ((True, SharedClock), (False, DeviceClock)):
        dialect = DriverSettings(port="p", protocol="frames", lockstep=lockstep).dialect()
        assert isinstance(dialect._clock, kind)  # type: ignore[attr-defined]
