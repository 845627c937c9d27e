"""The rig's sensors before a recording system: what their documentation says of them, measured from their readings."""

import numpy as np
import pytest
from scipy.signal import find_peaks

from rov_sim.rig_sensors import RECORDER, Rig, disturbances, flow_read, rung, speed_read

DT = 0.001
RATE = 25.0


def flow(count, seed=1, true=0.0, **sizes):
    """Return readings of a flow at 25 Hz, from a sensor of which only these sizes are not zero."""
    quiet = {"flow_noise": 0.0, "turbulence": 0.0, "spike_share": 0.0}
    rig = Rig(**(quiet | {"memory": RECORDER.memory, "spike_size": RECORDER.spike_size} | sizes))
    noise = disturbances(rig, count, 1.0 / RATE, np.random.default_rng(seed))
    return flow_read(np.full(count, true), noise.flow, noise.eddies, False)


@pytest.mark.parametrize(("frequency", "damping"), [(7.0, 0.04), (8.5, 0.02), (3.0, 0.1)])
def test_the_load_cells_mode_has_the_stated_frequency_and_damping(frequency, damping):
    """Overshoots of a step response: spacing gives the damped frequency, their decay the damping."""
    response = rung(np.where(np.arange(4000) >= 10, 1.0, 0.0), DT, frequency, damping)
    peaks, _ = find_peaks(response, height=1.005)
    peaks = peaks[:6]
    natural = 1.0 / (np.mean(np.diff(peaks)) * DT * np.sqrt(1.0 - damping**2))
    assert natural == pytest.approx(frequency, rel=0.01)
    decrement = np.mean(-np.diff(np.log(response[peaks] - 1.0)))
    assert decrement / np.sqrt(4.0 * np.pi**2 + decrement**2) == pytest.approx(damping, rel=0.03)


def test_a_load_that_lasts_is_read_as_it_is():
    assert rung(np.full(20_000, 12.13), DT, 7.0, 0.04)[-1] == pytest.approx(12.13, rel=1e-6)


def test_speed_and_load_scatter_as_stated():
    noise = disturbances(RECORDER, 60_000, DT, np.random.default_rng(2))
    assert np.std(noise.load) == pytest.approx(0.5, rel=0.02)
    assert np.std(speed_read(np.full(60_000, 80.0), noise.speed, False)) == pytest.approx(0.02 * 49.9723, rel=0.02)


def test_the_tachometer_tells_magnitudes_only():
    np.testing.assert_array_equal(speed_read(np.array([-100.0, 0.0, 100.0]), 0.0, False), [100.0, 0.0, 100.0])


def test_the_stated_share_of_samples_are_spikes():
    read = flow(25_000, seed=4, spike_share=RECORDER.spike_share)
    spikes = read != 0.0
    assert spikes.mean() == pytest.approx(0.05, abs=4.0 * np.sqrt(0.05 * 0.95 / read.size))
    assert np.std(read[spikes]) == pytest.approx(0.3, rel=0.1)


def test_turbulence_scales_with_the_flow_and_remembers():
    eddies = flow(25_000, seed=5, true=0.2, turbulence=RECORDER.turbulence) - 0.2
    assert np.std(eddies) == pytest.approx(0.08 * 0.2, rel=0.06)
    for lag in (1, 5):
        rho = np.mean(eddies[lag:] * eddies[:-lag]) / np.mean(eddies**2)
        assert rho == pytest.approx(np.exp(-lag / RATE / 0.2), abs=0.05)
    np.testing.assert_array_equal(flow(250, turbulence=RECORDER.turbulence), 0.0)


def test_still_water_shows_the_stated_noise():
    assert np.std(flow(25_000, seed=6, flow_noise=RECORDER.flow_noise)) == pytest.approx(0.008, rel=0.02)
