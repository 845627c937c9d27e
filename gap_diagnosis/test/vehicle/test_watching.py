"""The arithmetic of the watch; what it finds in recordings is counted by its command."""

import pytest

from gap_diagnosis.vehicle.watching import Alarm, _parabola


def test_a_size_is_the_top_of_the_parabola_through_both_sizes() -> None:
    a, b = 40.0, 100.0  # top at 0.4, deviation 0.1

    def l_of(s: float) -> float:
        return a * s - 0.5 * b * s * s

    assert _parabola(0.3, l_of(0.3), 1.0, l_of(1.0)) == pytest.approx((0.4, 0.1))


def test_a_ratio_that_only_grows_with_the_size_keeps_the_larger_size() -> None:
    size, deviation = _parabola(0.3, 5.0, 1.0, 40.0)
    assert size == 1.0 and deviation == pytest.approx(0.7)


def test_an_alarm_says_which_thruster_how_much_and_since_when() -> None:
    alarm = Alarm(effect="thrust_loss", thruster=3, sensor=None, size=0.25, deviation=0.04, log_ratio=20.0, since=12.0)
    assert alarm.words == "thruster 3: loses 25 ± 4 % thrust, since 12 s"
