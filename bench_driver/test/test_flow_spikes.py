"""Spikes of a velocimeter, judged without the future: on made flow with known spikes, jumps and quality."""

import math
from collections import Counter

import numpy as np
import pytest

from bench_driver.flow_spikes import SpikeDetector, SpikeLimits
from bench_driver.vectrino import VectrinoDecoder, Velocity


def turbulence(count: int, deviation: float, seed: int) -> np.ndarray:
    """Return correlated noise [m/s], shape (count,)."""
    noise = np.random.default_rng(seed).normal(size=count) * deviation * math.sqrt(1 - 0.9**2)
    flow = np.zeros(count)
    for k in range(1, count):
        flow[k] = 0.9 * flow[k - 1] + noise[k]
    return flow


def flags(velocities: np.ndarray, limits: SpikeLimits | None = None) -> np.ndarray:
    detector = SpikeDetector(limits)
    return np.array([bool(detector.judge(float(velocity))) for velocity in velocities])


@pytest.mark.parametrize("share", [0.02, 0.05, 0.10])
def test_nineteen_of_twenty_spikes_are_found_and_one_of_fifty_good_samples_is_lost(share: float) -> None:
    chance = np.random.default_rng(1)
    flow = 0.05 + turbulence(5000, 0.01, seed=2)
    hit = chance.random(5000) < share
    flow[hit] += chance.choice([-1, 1], hit.sum()) * chance.uniform(0.08, 0.2, hit.sum())
    found = flags(flow)
    assert found[hit].mean() > 0.95
    assert found[~hit].mean() < 0.02


def test_after_a_true_jump_samples_are_usable_again_within_half_a_window() -> None:
    flow = np.where(np.arange(200) < 100, -0.1, 0.15) + np.random.default_rng(3).normal(size=200) * 0.003
    found = np.flatnonzero(flags(flow))
    assert found.size
    assert np.all((found >= 100) & (found < 100 + SpikeLimits().window // 2 + 2))


def test_the_same_velocity_is_a_spike_or_not_by_the_jump_that_leads_to_it() -> None:
    before = [0.0, 0.02, -0.01, 0.01, -0.02, 0.015, -0.015, 0.005, -0.005, 0.02, -0.02, 0.0, 0.01, -0.01]
    assert flags(np.array([*before, 0.03, -0.03, 0.10])).tolist() == [False] * 16 + [True]
    assert not flags(np.array([*before, -0.03, 0.03, 0.10])).any()  # the same values, so the same median and σ


def test_a_ramp_is_no_spike() -> None:
    assert not flags(np.linspace(-0.2, 0.2, 100)).any()  # 0.1 m/s² at 25 Hz


def test_a_constant_velocity_is_usable_from_the_first_sample_on() -> None:
    assert not flags(np.full(50, 0.1)).any()


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({"velocity": 0.31}, "velocity not credible"),
        ({"velocity": math.nan}, "velocity not credible"),
        ({"velocity": 0.1, "correlation": 29.0}, "correlation too low"),
        ({"velocity": 0.1, "snr": 4.9}, "signal too weak"),
        ({"velocity": 0.1, "correlation": 30.0, "snr": 5.0}, ""),
    ],
)
def test_a_sample_that_cannot_be_used_says_why(arguments: dict[str, float], reason: str) -> None:
    detector = SpikeDetector(SpikeLimits(snr=5.0))
    assert detector.judge(**arguments) == reason


def test_the_judgement_needs_no_future() -> None:
    flow = 0.05 + turbulence(300, 0.02, seed=4)
    whole = flags(flow)
    changed = flow.copy()
    changed[200:] = 0.25
    assert np.array_equal(flags(changed)[:200], whole[:200])


def test_on_the_real_recording_jumps_between_neighbours_shrink(vectrino_recording: bytes) -> None:
    records = [record for record in VectrinoDecoder().feed(vectrino_recording) if isinstance(record, Velocity)]
    detector = SpikeDetector(SpikeLimits(velocity=1.5))
    x = np.array([record.velocity[0] for record in records])
    reasons = [
        detector.judge(record.velocity[0], correlation=min(record.correlation[::2]), snr=min(record.snr[::2]))
        for record in records
    ]
    usable = np.array([not reason for reason in reasons])
    assert usable.mean() > 0.85, Counter(reasons)
    assert np.diff(x[usable]).std() < 0.75 * np.diff(x).std(), (np.diff(x).std(), np.diff(x[usable]).std())
