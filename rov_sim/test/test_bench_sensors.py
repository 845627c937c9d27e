"""Sensors of the synthetic bench: what their documentation says of them, measured from their readings."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from rov_sim.bench_sensors import LoadCell, Tachometer, Velocimeter

DT = 0.001


@pytest.mark.parametrize(("frequency", "damping"), [(7.0, 0.04), (8.5, 0.02), (3.0, 0.1)])
def test_the_load_cells_mode_has_the_stated_frequency_and_damping(frequency, damping):
    """Overshoots of a step response: spacing gives the damped frequency, their decay the damping."""
    cell = LoadCell(frequency=frequency, damping=damping, noise=0.0)
    response = cell.read(np.where(np.arange(4000) >= 10, 1.0, 0.0), DT, np.random.default_rng(1))
    peaks, _ = find_peaks(response, height=1.005)
    peaks = peaks[:6]
    natural = 1.0 / (np.mean(np.diff(peaks)) * DT * np.sqrt(1.0 - damping**2))
    assert natural == pytest.approx(frequency, rel=0.01)
    decrement = np.mean(-np.diff(np.log(response[peaks] - 1.0)))
    assert decrement / np.sqrt(4.0 * np.pi**2 + decrement**2) == pytest.approx(damping, rel=0.03)


def test_a_load_that_lasts_is_read_as_it_is():
    response = LoadCell(noise=0.0).read(np.full(20_000, 12.13), DT, np.random.default_rng(1))
    assert response[-1] == pytest.approx(12.13, rel=1e-6)


def test_a_load_cell_rests_drifts_and_scatters_as_stated():
    cell = LoadCell(noise=0.5, rest=0.8, drift=0.02)
    reading = cell.read(np.zeros(60_000), DT, np.random.default_rng(2))
    time = DT * np.arange(60_000)
    slope, rest = np.polyfit(time, reading, 1)
    error = 0.5 / np.sqrt(60_000)
    assert rest == pytest.approx(0.8, abs=2 * 4 * error)
    assert slope == pytest.approx(0.02, abs=4 * error / np.std(time))
    assert np.std(reading - rest - slope * time) == pytest.approx(0.5, rel=0.02)


def test_the_tachometer_tells_magnitudes_only_and_adds_its_offset():
    tachometer = Tachometer(noise=0.0, resolution=1e-9)
    read = tachometer.read(np.array([-100.0, 0.0, 100.0]), np.random.default_rng(1))
    np.testing.assert_allclose(read, np.array([100.0, 0.0, 100.0]) + 0.023 * 49.9723, rtol=1e-6)


def test_the_tachometer_reads_whole_steps_of_its_converter():
    tachometer = Tachometer()
    read = tachometer.read(np.linspace(-110.0, 110.0, 5001), np.random.default_rng(1))
    steps = read / (tachometer.scale * tachometer.resolution)
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)
    quiet = Tachometer(noise=0.0).read(np.linspace(0.0, 110.0, 5001), np.random.default_rng(1))
    error = quiet - np.linspace(0.0, 110.0, 5001) - 0.023 * tachometer.scale
    assert np.max(np.abs(error)) <= 0.5 * tachometer.scale * tachometer.resolution * (1.0 + 1e-9)
    assert np.std(error) == pytest.approx(tachometer.scale * tachometer.resolution / np.sqrt(12.0), rel=0.05)


def test_the_tachometers_noise_is_as_stated():
    read = Tachometer().read(np.full(50_000, 80.0), np.random.default_rng(3))
    assert np.std(read) == pytest.approx(0.02 * 49.9723, rel=0.02)


def test_the_velocimeter_samples_at_its_rate_from_time_zero():
    velocity = np.linspace(0.0, 0.3, 10_001)
    meter = Velocimeter(noise=0.0, turbulence=0.0, spike_share=0.0, rate=20.0)
    time, read = meter.read(velocity, DT, np.random.default_rng(1))
    np.testing.assert_allclose(time, 0.05 * np.arange(200), atol=1e-12)
    np.testing.assert_allclose(read, 0.03 * time, atol=1e-12)


def test_the_stated_share_of_samples_are_spikes():
    meter = Velocimeter(noise=0.0, turbulence=0.0)
    _, read = meter.read(np.zeros(1_000_001), DT, np.random.default_rng(4))
    spikes = read != 0.0
    assert spikes.mean() == pytest.approx(0.05, abs=4.0 * np.sqrt(0.05 * 0.95 / read.size))
    assert np.std(read[spikes]) == pytest.approx(0.3, rel=0.1)


def test_turbulence_scales_with_the_flow_and_remembers():
    meter = Velocimeter(noise=0.0, spike_share=0.0)
    _, read = meter.read(np.full(1_000_001, 0.2), DT, np.random.default_rng(5))
    eddies = read - 0.2
    assert np.std(eddies) == pytest.approx(0.08 * 0.2, rel=0.06)
    for lag in (1, 5):
        rho = np.mean(eddies[lag:] * eddies[:-lag]) / np.mean(eddies**2)
        assert rho == pytest.approx(np.exp(-lag / 25.0 / 0.2), abs=0.05)
    _, still = meter.read(np.zeros(10_001), DT, np.random.default_rng(5))
    np.testing.assert_array_equal(still, 0.0)


def test_still_water_shows_the_stated_noise():
    meter = Velocimeter(spike_share=0.0)
    _, read = meter.read(np.zeros(1_000_001), DT, np.random.default_rng(6))
    assert np.std(read) == pytest.approx(0.008, rel=0.02)
