"""How a recording starts: a thruster about to turn, one that runs already, water that moves while the rotor rests."""

import numpy as np
import pytest

from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from system_identification.fitting import fit
from system_identification.noise import white_noise
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
NOISE = {"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4}
LEVELS = np.array([0.0, 4.0, 4.0, 0.1, -3.0, 2.0, -4.4, 3.0, 0.0, 1.5])  # [V], a second each


def cut(first, late, *, only=tuple(NOISE)):
    """Return what is recorded from the instant `first` [s] on, the first samples `late` [s] after the throttle's."""
    rng = np.random.default_rng(2)
    commands = np.repeat(LEVELS, 1000)
    happened = simulate(HL.model.coefficients(HL.values), commands, 1e-3)
    dense = {"speed": happened.n, "ambient": happened.ambient, "thrust": happened.thrust, "torque": happened.torque}
    at = np.arange(first + late, 9.95, 0.02)
    signals = {
        name: (
            at - first,
            np.interp(at, 1e-3 * np.arange(values.size), values) + NOISE[name] * rng.standard_normal(at.size),
        )
        for name, values in dense.items()
        if name in only
    }
    stamps = np.arange(0.0, 10.0 - first, 0.02)
    return recording_of("run", (stamps, commands[np.round((stamps + first) * 1e3).astype(int)]), signals)


@pytest.mark.parametrize(
    ("first", "late", "why"),
    [
        (1.0, 0.025, "it has begun to turn before its first sample"),
        (2.5, 0.01, "it runs"),
        (4.02, 0.015, "it is being reversed"),
        (3.6, 0.005, "the water still moves while the rotor rests"),
    ],
)
def test_a_start_that_nothing_tells_is_found_by_the_fit(first, late, why):
    recording = cut(first, late)
    assert recording.start_std
    problem = Problem(recordings=(recording,), parameter_set=HL, deviations=deviations_of(HL))
    found = fit(problem, white_noise(problem), problem.start(), iterations=20)
    early = np.abs(found.white[problem.times < 0.3])
    assert np.max(early) < 4.5, why


@pytest.mark.parametrize("first", [1.5, 2.5, 4.6, 6.3])
def test_a_rotor_that_runs_is_no_other_parameter_where_no_tachometer_tells(first):
    recording = cut(first, 0.01, only=("thrust",))
    assert {"n", "v", "u"} < set(recording.start_std)
    problem = Problem(recordings=(recording,), parameter_set=HL, deviations=deviations_of(HL))
    found = fit(problem, white_noise(problem), problem.start(), iterations=20)
    assert np.max(np.abs(found.white[problem.times < 0.3])) < 4.5
    assert np.max(np.abs(found.x[: len(problem.names)])) < 2.0


def test_a_load_cell_that_tells_nothing_at_the_start_leaves_the_rotor_at_rest():
    assert not cut(0.0, 0.0, only=("thrust",)).start_std


def test_a_thruster_in_still_water_starts_at_rest():
    recording = cut(0.0, 0.0)
    assert set(recording.start_std) == {"ambient"} and recording.start_std["ambient"] < 0.01
    assert recording.start.n == 0.0


def test_a_clock_that_gains_in_one_run_is_found_there():
    rng, gained, runs = np.random.default_rng(5), (0.0, 8e-5), []
    for rate in gained:
        commands = np.repeat(rng.uniform(-4.5, 4.5, 80), 500)  # for half a second each
        n = simulate(HL.model.coefficients(HL.values), commands, 1e-3).n
        at = np.arange(0.01, 39.9, 0.02)
        speed = np.interp(at, 1e-3 * np.arange(n.size), n) + 0.3 * rng.standard_normal(at.size)
        runs.append(recording_of("run", (np.arange(0.0, 40.0, 1e-3), commands), {"speed": (at * (1.0 + rate), speed)}))
    problem = Problem(recordings=tuple(runs), parameter_set=HL, deviations=deviations_of(HL))
    found = fit(problem, white_noise(problem), problem.start(), iterations=20)
    rates = [problem.situation(found.x, run).shifts.rates["speed"] for run in range(2)]
    np.testing.assert_allclose(rates, gained, atol=1.5e-5)
