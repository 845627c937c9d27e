"""Throttle programmes: levels, times and spectra as stated."""

import numpy as np
import pytest

from rov_sim.throttle_programmes import multisine, ramp_and_hold, staircase, with_rest

PERIOD = 0.04


@pytest.mark.parametrize("level", [3.0, -2.5])
def test_the_thesis_input_ramps_for_two_seconds_and_holds_for_eight(level):
    commands = ramp_and_hold(level, PERIOD)
    assert commands.size * PERIOD == pytest.approx(10.0)
    time = PERIOD * np.arange(commands.size)
    np.testing.assert_allclose(commands, level * np.minimum(time / 2.0, 1.0), atol=1e-12)
    assert np.all(commands[time >= 2.0] == level)


def test_the_multisine_peaks_at_its_amplitude():
    for seed in range(5):
        sines = multisine(2.8, PERIOD, duration=12.0, lowest=0.1, highest=0.8, rng=np.random.default_rng(seed))
        assert sines.size == 300
        assert np.max(np.abs(sines)) == pytest.approx(2.8, rel=1e-12)


def test_the_multisine_has_equal_lines_at_whole_cycles_and_nothing_between():
    sines = multisine(2.8, PERIOD, duration=60.0, lowest=0.1, highest=0.8, rng=np.random.default_rng(2))
    spectrum = np.abs(np.fft.rfft(sines))
    lines = np.flatnonzero(spectrum > 1e-6 * spectrum.max())
    expected = np.unique(np.round(60.0 * 0.1 * 8.0 ** (np.arange(12) / 11.0)))
    np.testing.assert_array_equal(lines, expected)
    np.testing.assert_allclose(spectrum[lines], spectrum[lines[0]], rtol=1e-9)
    assert lines.size == 12
    assert lines[0] / 60.0 == pytest.approx(0.1)
    assert lines[-1] / 60.0 == pytest.approx(0.8)


def test_lines_that_fall_together_count_once():
    sines = multisine(1.0, PERIOD, duration=10.0, lowest=0.1, highest=0.3, rng=np.random.default_rng(3))
    spectrum = np.abs(np.fft.rfft(sines))
    assert np.flatnonzero(spectrum > 1e-6 * spectrum.max()).tolist() == [1, 2, 3]


def test_phases_follow_the_generator():
    given = {"duration": 12.0, "lowest": 0.1, "highest": 0.8}
    first, again, other = (multisine(1.0, PERIOD, rng=np.random.default_rng(k), **given) for k in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.max(np.abs(first - other)) > 0.1


def test_a_staircase_holds_each_level_for_its_time():
    commands = staircase([1.5, -1.5, 2.0], PERIOD, hold=1.6)
    np.testing.assert_array_equal(commands, [1.5] * 40 + [-1.5] * 40 + [2.0] * 40)


def test_rest_surrounds_the_commands():
    commands = with_rest(np.ones(10), PERIOD, before=2.0, after=1.0)
    np.testing.assert_array_equal(commands, [0.0] * 50 + [1.0] * 10 + [0.0] * 25)
