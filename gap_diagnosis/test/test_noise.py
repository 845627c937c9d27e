"""Noise of signals: what an autoregression is fitted to, and what whitening makes of residuals."""

import numpy as np
import pytest
from scipy.signal import lfilter

from gap_diagnosis.noise import LARGEST_RATIO, NoiseModel, Series, SignalNoise, fit_noise, white_noise, widened


def series(size, signal="speed", first=0):
    return Series(0, signal, first, first + size)


def test_white_noise_divides_by_its_deviation_and_leaves_gaps_at_zero():
    rows = np.array([2.0, np.nan, -4.0])
    assert white_noise({"speed": 2.0}).whiten([series(3)], rows) == pytest.approx([1.0, 0.0, -2.0])


def test_residuals_of_an_autoregression_come_out_white_and_of_deviation_one():
    rng = np.random.default_rng(1)
    rows = lfilter([0.5], [1.0, -0.8, 0.1], rng.standard_normal(20000))
    noise = NoiseModel(
        signals={"speed": SignalNoise(innovation=0.5, marginal=float(np.std(rows)), coefficients=(0.8, -0.1))}
    )
    white = noise.whiten([series(rows.size)], rows)[10:]
    assert np.std(white) == pytest.approx(1.0, abs=3.0 / np.sqrt(2 * white.size))
    assert abs(np.mean(white[1:] * white[:-1])) < 4.0 / np.sqrt(white.size)


def test_whitening_is_linear_also_across_gaps():
    rng = np.random.default_rng(2)
    noise = NoiseModel(signals={"speed": SignalNoise(innovation=0.7, marginal=1.0, coefficients=(0.6, 0.1))})
    a, b = rng.standard_normal((2, 60))
    a[[7, 8, 30]] = b[[7, 8, 30]] = np.nan
    both = noise.whiten([series(60)], np.stack((a, b, 2.0 * a - 3.0 * b), axis=1))
    assert both[:, 2] == pytest.approx(2.0 * both[:, 0] - 3.0 * both[:, 1], abs=1e-12)


def test_the_autoregression_of_coloured_noise_is_found_in_spite_of_missing_samples():
    rng = np.random.default_rng(3)
    rows = lfilter([1.0], [1.0, -0.8], rng.standard_normal(20000))
    rows[rng.random(rows.size) < 0.05] = np.nan
    found = fit_noise([series(rows.size)], rows).signals["speed"]
    assert found.coefficients[0] == pytest.approx(0.8, abs=0.03)
    assert found.innovation == pytest.approx(1.0, abs=0.04)


def test_white_noise_is_not_given_a_memory():
    rows = np.random.default_rng(4).standard_normal(3000)
    assert fit_noise([series(rows.size)], rows).signals["speed"].coefficients == ()


def test_a_slow_wander_does_not_make_the_innovation_vanish():
    rows = np.cumsum(np.random.default_rng(5).standard_normal(4000)) * 0.1
    found = fit_noise([series(rows.size)], rows).signals["speed"]
    assert found.innovation >= found.marginal / LARGEST_RATIO * 0.999


def test_signals_are_told_apart():
    rng = np.random.default_rng(6)
    rows = np.concatenate((rng.standard_normal(2000), 5.0 * rng.standard_normal(2000)))
    found = fit_noise([series(2000), series(2000, "thrust", 2000)], rows).signals
    assert found["thrust"].innovation / found["speed"].innovation == pytest.approx(5.0, rel=0.1)


def test_what_a_coarse_converter_leaves_counts_by_its_memory():
    speed = 50.0 + 20.0 * np.sin(np.arange(3000) / 200.0)
    rows = 12.0 * np.round(speed / 12.0) - speed
    coarse = fit_noise([series(rows.size)], rows, opaque=("speed",)).signals["speed"]
    assert coarse.coefficients == ()
    assert coarse.innovation > 2.0 * np.std(rows)
    white = np.random.default_rng(4).standard_normal(3000)
    assert fit_noise([series(white.size)], white, opaque=("speed",)).signals["speed"].innovation == pytest.approx(
        1.0, abs=0.1
    )


def test_what_signals_have_in_common_counts_once():
    rng = np.random.default_rng(7)
    stamps, shared = np.arange(3000) / 25.0, lfilter([0.2], [1.0, -0.96], rng.standard_normal(3000))
    alike = np.concatenate([shared + 0.3 * rng.standard_normal(3000) for _ in range(3)])
    signals = [series(3000, name, 3000 * k) for k, name in enumerate(("speed", "thrust", "torque"))]
    alone = fit_noise(signals, alike)
    wider = widened(alone, signals, np.tile(stamps, 3), alike)
    for name, noise in wider.signals.items():
        assert 1.4 < (noise.innovation / alone.signals[name].innovation) ** 2 < 3.0
        assert noise.marginal == alone.signals[name].marginal


def test_signals_with_nothing_in_common_keep_their_noise():
    rng = np.random.default_rng(8)
    apart = rng.standard_normal(6000)
    signals = [series(3000), series(3000, "thrust", 3000)]
    alone = fit_noise(signals, apart)
    assert widened(alone, signals, np.tile(np.arange(3000) / 25.0, 2), apart) == alone
