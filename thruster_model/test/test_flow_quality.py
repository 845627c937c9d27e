"""Which velocimeter samples are usable, on synthetic records whose damage is known sample by sample."""

import re

import numpy as np
import pytest
from scipy.signal import lfilter

from thruster_model.identification.flow_quality import FlowLimits, assess_flow

RATE = 25.0
SIZE = 1500


def record(seed=1):
    """A minute of a flow that starts, holds and reverses, with turbulence and white noise [m/s]."""
    rng = np.random.default_rng(seed)
    time = np.arange(SIZE) / RATE
    mean = 0.13 * np.tanh((time - 5.0) / 0.8) + 0.13 - 0.2 * (1.0 + np.tanh((time - 35.0) / 0.8))
    keep = np.exp(-1.0 / (RATE * 0.2))
    eddies = lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], rng.standard_normal(SIZE))
    return mean * (1.0 + 0.06 * eddies) + 0.006 * rng.standard_normal(SIZE), rng


def stated(sentence):
    """The shares [%] of the sentence: spikes, unusable stretches, what remains."""
    pattern = r"(\d+) % of the samples are spikes, (\d+) % lie in unusable stretches, (\d+) % remain"
    return tuple(int(number) for number in re.match(pattern, sentence).groups())


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_clean_record_keeps_at_least_95_percent(seed):
    velocity, _ = record(seed)
    quality = assess_flow(velocity, RATE)
    assert quality.usable.mean() >= 0.95
    assert quality.spikes.mean() <= 0.05


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_nine_in_ten_spikes_are_found_at_no_more_than_five_percent_false_alarms(seed):
    """Phase-space thresholding condemns neighbours of spikes for their slope: these have their own limit."""
    velocity, rng = record(seed)
    hit = rng.random(SIZE) < 0.05
    size = rng.uniform(0.12, 0.5, SIZE) * rng.choice([-1.0, 1.0], SIZE)
    quality = assess_flow(np.where(hit, velocity + size, velocity), RATE)
    assert (quality.spikes & hit).sum() >= 0.9 * hit.sum()
    assert (quality.usable & hit).sum() <= 0.1 * hit.sum()
    apart = np.convolve(hit, np.ones(3), "same") == 0
    assert (quality.spikes & apart).sum() <= 0.05 * apart.sum()
    assert (quality.spikes & ~hit).sum() <= 0.08 * (~hit).sum()


def test_spikes_smaller_than_the_changes_of_the_flow_itself_are_found():
    velocity, rng = record()
    hit = rng.random(SIZE) < 0.02
    size = rng.uniform(0.10, 0.13, SIZE) * np.where(velocity > 0.0, -1.0, 1.0)
    quality = assess_flow(np.where(hit, velocity + size, velocity), RATE)
    assert np.ptp(velocity) > 0.4
    assert (quality.spikes & hit).sum() >= 0.9 * hit.sum()


def test_a_short_pulse_of_flow_in_a_long_rest_is_not_taken_for_spikes():
    rng = np.random.default_rng(4)
    time = np.arange(SIZE) / RATE
    pulse = 0.14 * (np.tanh((time - 30.0) / 0.3) - np.tanh((time - 33.0) / 0.3))
    quality = assess_flow(pulse + 0.003 * rng.standard_normal(SIZE), RATE)
    assert quality.usable[(time > 30.5) & (time < 32.5)].mean() >= 0.95


def test_a_stretch_of_wrapped_velocities_is_left_out_and_the_rest_stays():
    velocity, rng = record()
    wrapped = slice(500, 750)
    velocity[wrapped] = 0.4 * rng.choice([-1.0, 1.0], 250) + 0.02 * rng.standard_normal(250)
    quality = assess_flow(velocity, RATE)
    assert not quality.usable[wrapped].any()
    outside = np.ones(SIZE, dtype=bool)
    outside[480:770] = False  # half a second at either end shares its windows with the garbage
    assert quality.usable[outside].mean() >= 0.95


def test_garbage_within_the_credible_range_is_left_out_for_its_scatter():
    velocity, rng = record()
    velocity[500:750] = rng.uniform(-0.29, 0.29, 250)
    quality = assess_flow(velocity, RATE)
    assert quality.usable[515:735].mean() <= 0.02
    assert quality.usable[:480].mean() >= 0.95


@pytest.mark.parametrize("spread", [0.15, 0.4])
def test_a_channel_of_nothing_but_noise_is_left_out_as_a_whole(spread):
    _, rng = record()
    quality = assess_flow(spread * rng.standard_normal(SIZE), RATE)
    assert not quality.usable.any()
    assert quality.sentence.endswith("fewer than 50 %, so the channel is left out")


def test_the_sentence_states_the_shares_of_the_masks():
    velocity, _ = record()
    velocity[900:1100] = 0.5
    quality = assess_flow(velocity, RATE)
    spikes, unusable, remain = stated(quality.sentence)
    assert spikes == round(100 * quality.spikes.mean())
    assert remain == round(100 * quality.usable.mean())
    assert 13 <= unusable <= 16  # 200 of 1500 samples and the windows at their ends
    assert "left out" not in quality.sentence


def test_missing_samples_are_never_usable():
    velocity, _ = record()
    velocity[200:210] = np.nan
    assert not assess_flow(velocity, RATE).usable[200:210].any()
    assert not assess_flow(np.full(SIZE, np.nan), RATE).usable.any()


def test_a_still_channel_is_usable_throughout():
    assert assess_flow(np.zeros(SIZE), RATE).usable.all()


def test_the_limits_decide():
    velocity, _ = record()
    low = assess_flow(velocity, RATE, FlowLimits(velocity=0.2))
    assert not low.usable[np.abs(velocity) > 0.2].any()
    strict = assess_flow(velocity, RATE, FlowLimits(least_share=0.999))
    assert not strict.usable.any()
