"""Stamps of the device on the host's clock: delay, drift, wrap, restart; truth is made here."""

import numpy as np
import pytest

from bench_driver.device_clock import DeviceClock

WRAP = 1 << 32


def arrivals(count: int, *, drift: float, start: float, seed: int = 1) -> list[tuple[float, float, int]]:
    """Return (instant, arrival, stamp) of 100 measurements a second: at least 1 ms late, 2 ms more on average."""
    late = 1e-3 + np.random.default_rng(seed).exponential(2e-3, size=count)
    made = []
    for k in range(count):
        instant = 1000.0 + 0.01 * k
        stamp = round(1e6 * (start + 0.01 * k * (1 + drift))) % WRAP
        made.append((instant, instant + float(late[k]), stamp))
    return made


@pytest.mark.parametrize("drift", [0.0, 1e-4, -1e-4])
@pytest.mark.parametrize("start", [0.0, 4294.0])  # the second wraps after one second
def test_stamps_are_right_to_a_millisecond_in_spite_of_delay_drift_and_wrap(drift: float, start: float) -> None:
    clock = DeviceClock()
    errors = [
        clock.stamp(arrival, stamp, on_line=1e-3) - instant
        for instant, arrival, stamp in arrivals(6000, drift=drift, start=start)
    ]
    assert clock.restarts == 0
    assert np.max(np.abs(errors[500:])) < 1.2e-3


def test_a_stamp_is_never_later_than_the_arrival() -> None:
    clock = DeviceClock()
    assert all(
        clock.stamp(arrival, stamp) <= arrival + 1e-9 for _, arrival, stamp in arrivals(3000, drift=1e-4, start=0.0)
    )


@pytest.mark.parametrize("before", [5.0, 3000.0, 4290.0])
def test_a_restarted_clock_is_noticed_however_long_it_ran(before: float) -> None:
    clock = DeviceClock()
    clock.stamp(10.0, round(1e6 * before))
    clock.stamp(10.01, round(1e6 * (before + 0.01)))
    again = 10.0 + (30.0 if before > 4200 else 1.0)
    assert clock.stamp(again, 20_000) == pytest.approx(again)
    assert clock.restarts == 1


def test_a_pause_is_no_restart() -> None:
    clock = DeviceClock()
    clock.stamp(10.0, 0)
    assert clock.stamp(10.0 + 7200.0, 7_200_000_000 % WRAP) == pytest.approx(7210.0)
    assert clock.restarts == 0
