"""Stamps that scatter with the samples are not the log's doing, whatever else is wrong with the model."""

import numpy as np
from scipy.signal import lfilter

from gap_diagnosis.log_readings import LogReading, read_as_suits
from gap_diagnosis.plausibility import checked
from gap_diagnosis.preparing import recording_of
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.stamps import on_regular_stamps
from gap_diagnosis.suspects import suspects
from system_identification.hypothesis import weighed
from system_identification.noise import whitener
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set

HL = load_parameter_set("hl")
NOISE = {"speed": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4}
LAG, SCATTER = 0.08, 0.01  # [s]


def problem(*, told, lag=LAG, outliers=0.0):
    """Return that of samples at scattered instants, as given; `told`: the stamps say when they were.

    `outliers`: their share of the samples.
    """
    rng = np.random.default_rng(4)
    commands = np.repeat(rng.uniform(-4.5, 4.5, 30), 500)
    happened = simulate(HL.model.coefficients(HL.values), commands, 1e-3)
    dense = {"speed": happened.n, "ambient": happened.ambient, "thrust": happened.thrust, "torque": happened.torque}
    if lag:
        share = np.exp(-1e-3 / lag)
        dense["speed"] = lfilter([1.0 - share], [1.0, -share], dense["speed"])
    regular = 0.04 * np.arange(375)
    signals = {}
    for name, values in dense.items():
        taken = regular + rng.uniform(0.0, SCATTER, regular.size)
        read = np.interp(taken, 1e-3 * np.arange(values.size), values)
        stamps = taken if told else regular + rng.uniform(0.0, SCATTER, regular.size)
        noise = NOISE[name] * rng.standard_normal(read.size)
        if outliers:
            noise += 25.0 * NOISE[name] * (rng.random(read.size) < outliers) * rng.standard_normal(read.size)
        signals[name] = (stamps, read + noise)
    recording = recording_of("run", (1e-3 * np.arange(commands.size), commands), signals)
    recordings = tuple(checked([recording]).recordings)
    return Problem(recordings=recordings, parameter_set=HL, deviations=deviations_of(HL))


def test_samples_taken_when_their_stamps_say_are_left_there_once_the_effect_is_known():
    given = problem(told=True)
    suspect = next(s for s in suspects(set(NOISE)) if s.effect == "tach_lag")
    for on_regular in (False, True):  # whichever of the two the hypothesis was fitted on
        reading = LogReading(log=given, straight=None, on_regular=on_regular)
        posed = reading.problem.with_effects(suspect.slots)
        x = posed.start([0.2])
        found = weighed(posed, (suspect,), x, whitener(posed, x))
        better = reading.better_for(found)
        assert (reading if better is None else better).on_regular is False
        assert reading.jitter(found) is None


def on_regular_stamps_or_not(given):
    """Return how stamps are read in the end, asked on those in the log and on regular ones."""
    for on_regular in (False, True):
        reading = LogReading(log=given, straight=None, on_regular=on_regular)
        start = reading.problem.start()
        better = reading.better_for(weighed(reading.problem, (), start, whitener(reading.problem, start)))
        yield (reading if better is None else better).on_regular


def test_where_one_begins_does_not_decide_how_stamps_are_read():
    assert list(on_regular_stamps_or_not(problem(told=False, lag=0.0))) == [True, True]
    assert list(on_regular_stamps_or_not(problem(told=True, lag=0.0))) == [False, False]


def test_outliers_have_no_say_in_how_stamps_are_read():
    assert list(on_regular_stamps_or_not(problem(told=True, lag=0.0, outliers=0.01))) == [False, False]
    assert list(on_regular_stamps_or_not(problem(told=False, lag=0.0, outliers=0.01))) == [True, True]


def test_stamps_that_say_nothing_are_replaced_by_regular_ones():
    given = problem(told=False, lag=0.0)

    def investigated(problem, grew):
        found = weighed(problem, (), problem.start(), whitener(problem, problem.start()))
        grew(found)
        return found

    reading, found = read_as_suits(given, investigated)
    jitter = reading.jitter(found)
    assert reading.on_regular and jitter is not None
    assert 0.002 < jitter.size < 0.004  # even over 10 ms


def test_fast_readings_are_taken_together_alike_on_either_stamps():
    rng = np.random.default_rng(7)
    for _ in range(5):
        taken = 0.005 * np.arange(6000)
        stamps = np.sort(taken + rng.normal(0.0, 0.01, taken.size))
        read = np.sin(5.0 * taken) + 0.01 * rng.standard_normal(taken.size)
        recording = recording_of("run", (taken[::5], np.sin(taken[::5])), {"ambient": (stamps, read)})
        means = [each.experiment.measurements["ambient"] for each in (recording, recording.regular)]
        np.testing.assert_array_equal(means[0].values, means[1].values)
        wrong = [np.nanstd(each.values - np.sin(5.0 * each.time)) for each in means]
        assert wrong[1] < 0.5 * wrong[0]


def test_there_is_no_choice_where_no_stamps_scatter():
    given = problem(told=True)
    plain = recording_of("run", (np.array([0.0, 1.0]), np.array([0.0, 1.0])), {})
    assert on_regular_stamps(Problem(recordings=(plain,), parameter_set=HL, deviations={}), [plain]) is None
    assert given.recordings[0].regular is not None
